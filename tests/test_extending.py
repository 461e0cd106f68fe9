"""The recipes of `docs/extending.md`, executed."""

import re
import sys
import textwrap
import time as clock
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Literal

import numpy as np
import pytest
import xarray as xr
from conftest import HERE
from matplotlib.figure import Figure

from vsb.engine.hydro.dofs import Displacement
from vsb.engine.hydro.spectral.solver import SpectralProblem
from vsb.engine.integrators.audit import energies, residual
from vsb.engine.integrators.exact import propagate
from vsb.engine.integrators.exponential import phi_integrals
from vsb.engine.integrators.harmonic_balance import harmonic_balance
from vsb.engine.integrators.simulate import METHODS, Method, suited
from vsb.engine.motion import take_off
from vsb.engine.motion.forces import Damper, Excitation, Force, Linear, Spring
from vsb.engine.motion.port import LinearPto
from vsb.engine.motion.scene import Scene
from vsb.engine.motion.system import System
from vsb.engine.shell.deformed import DeformedShell, rigid_buoy, rigid_sphere
from vsb.engine.shell.meridian import RestMeridian
from vsb.engine.shell.modes import Mode, ModeBasis
from vsb.engine.shell.ritz import natural_modes
from vsb.engine.shell.shell import Shell, natural_frequencies
from vsb.engine.waves import kinds as waves
from vsb.errors import ConfigError
from vsb.keys import meanings as keys
from vsb.keys.meanings import UNITS
from vsb.models.rest import study_basis
from vsb.models.take_off import FORCES, with_take_off
from vsb.pipeline.graph import STAGES, Stage, Task
from vsb.report.answer import damping_in_words
from vsb.report.canvas import StudyData, grid_of_axes, legend_above, style
from vsb.stages.stage import Stamp, run_task
from vsb.study import specs
from vsb.tools.files import write_text
from vsb.tools.stamps import faults, read_manifest, record


def recipe(title, number=1, **names):
    """Names defined by the code of a recipe."""
    text = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8").split(f"## {title}\n")[1]
    code = text.split("```python\n")[number].split("```")[0]
    assert len(code.strip().splitlines()) <= 15
    exec(code, names)
    return names


@pytest.fixture
def described(monkeypatch):
    """Keys of the kinds that a test makes are known in it alone."""
    monkeypatch.setattr(keys, "KEYS", {**keys.KEYS})
    monkeypatch.setattr(keys, "UNITS", {**keys.UNITS})


@pytest.mark.usefixtures("described")
def test_first_change_of_contributing():
    """Its sea, its density under its own test, and a described key for every field."""
    text = (HERE.parent / "CONTRIBUTING.md").read_text(encoding="utf-8")
    blocks = [textwrap.dedent(block) for block in re.findall(r"```python\n(.*?) *```", text, re.S)]
    sea, test = blocks
    exec(sea, names := vars(waves) | {"__name__": "swell"})
    names |= {"np": np, "pytest": pytest}
    exec(test, names)
    names["test_swell_has_the_energy_of_its_height_about_its_peak"]()
    section = keys.KEYS["Swell"]
    assert section.keys() == names["Swell"].model_fields.keys()
    assert all(UNITS.get(name, key.unit) == key.unit for name, key in section.items() if key.unit)
    assert names["Swell"](kind="swell", hs=2.0, tp=12.0, bandwidth=0.05).memory == pytest.approx(4 * np.pi / 0.05)


@pytest.mark.usefixtures("described")
def test_a_kind_made_from_another_is_taken_for_what_it_is():
    """A page moves the period of JONSWAP seas by their formula: of those alone whose density it is."""

    class Renamed(waves.Jonswap):
        kind: Literal["renamed"]

    class Flatter(waves.Jonswap):
        kind: Literal["flatter"]

        def density(self, omega):
            return super().density(omega) * (0.5 + 0.25 * np.tanh(omega))

    values = {"hs": 2.0, "tp": 9.0, "gamma": 5.0}
    renamed, flatter = Renamed(kind="renamed", **values), Flatter(kind="flatter", **values)
    tma = waves.Tma(kind="tma", depth=15.0, **values)
    assert (renamed.jonswap, flatter.jonswap, tma.jonswap) == ((2.0, 9.0, 5.0), None, None)
    omega, amplitude = flatter.components(3.0, 600.0)
    _, other = renamed.components(3.0, 600.0)
    assert amplitude**2 == pytest.approx(other**2 * (0.5 + 0.25 * np.tanh(omega)), abs=1e-4 * max(other**2))
    assert keys.KEYS["Flatter"]["tp"] == keys.KEYS["Jonswap"]["tp"]


def test_recipe_of_a_take_off_law(monkeypatch):
    """Its rows make the force of a scene and its words; mean power in the steady motion, the power balance closes."""
    text = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8")
    section = text.split("## A take-off law\n")[1].split("\n## ")[0]
    code, law, force = (textwrap.dedent(block) for block in re.findall(r"```python\n(.*?) *```", section, re.S))
    exec(code, names := {"dataclass": dataclass, "Force": Force, "Linear": Linear, "np": np})
    for table, row in ((take_off.LAWS, eval(f"{{{law}}}", vars(take_off))), (FORCES, eval(f"{{{force}}}", names))):
        monkeypatch.setitem(table, "quadratic", row["quadratic"])

    class WithKey(take_off.Pto):
        quadratic: float = 0.0

    pto, wave = WithKey.model_construct(law="quadratic", quadratic=0.5), np.array([[30.0 + 5j]])
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "damper": Damper(np.array([[1.2]]))}
    forces |= {"excitation": Excitation(np.array([2.5]), wave), "pto": Damper(np.array([[4.0]]))}
    scene = with_take_off(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)), pto, LinearPto(4.0))
    found = harmonic_balance(System.of(scene), 1e-8)
    _, rate = found.at(np.linspace(0.0, 2 * np.pi / 2.5, 4097)[:-1])
    assert found.power.pto == pytest.approx(float(np.mean(0.5 * np.abs(rate[:, 0]) ** 3)), rel=1e-5)
    assert found.power.residual < 1e-6
    words = damping_in_words({"law": "quadratic", "quadratic": 0.5})
    assert (words, pto.law_has_damping) == ("With a damper of 0.5 kg/m times the speed squared", False)


def test_recipe_of_a_force():
    """A hardening spring, integrated by collocation with a closed energy balance."""
    force = recipe("A force", dataclass=dataclass, Force=Force, Linear=Linear, np=np)["Hardening"](400.0)
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "hardening": force}
    system = System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))
    assert suited(system) == "collocation"
    time = np.linspace(0.0, 4.0, 401)
    motion, _ = METHODS["collocation"].follower(system, 1e-9, None)(time, (np.array([0.5]), np.array([0.0])))
    found = energies(system, motion)
    assert residual(found) < 1e-6
    assert np.ptp(force.potential_energy(motion.position)) > 5.0
    assert found["pto"][-1] == pytest.approx(np.trapezoid(1.2 * motion.velocity[:, 0] ** 2, time), rel=1e-3)


def test_recipe_of_an_integrator_converges_at_first_order(monkeypatch):
    """Wave forces held constant over a step: half the step, half the error."""
    monkeypatch.setitem(METHODS, "euler", METHODS["exact"])
    recipe("An integrator", np=np, clock=clock, phi_integrals=phi_integrals, METHODS=METHODS, Method=Method)
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]]))}
    forces["excitation"] = Excitation(np.array([2.5]), np.array([[30.0 + 5j]]))
    system = System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))
    start, errors = (np.array([0.1]), np.array([0.0])), []
    for count in (801, 1601):
        time = np.linspace(0.0, 4.0, count)
        motion, steps = METHODS["euler"].follower(system, 1e-6, None)(time, start)
        errors.append(np.abs(motion.position - propagate(system, time, start).position).max())
        assert steps == count - 1
        assert motion.seconds > 0
    assert errors[0] / errors[1] == pytest.approx(2, abs=0.05)


def test_recipe_of_a_rest_shape_in_the_solver(seed):
    """An inflated sphere is a larger sphere."""
    shape = recipe("A rest shape", np=np, DeformedShell=DeformedShell)["inflated"](study_basis(seed), 0.2, 0.3)
    assert shape.volume() == pytest.approx(rigid_sphere(2.3, 0.2).volume(), rel=1e-12)
    blown, larger = (
        SpectralProblem(s, (Displacement("heave"),), 1025.0, 9.81, 24).solve([1.5])
        for s in (shape, rigid_sphere(2.3, 0.2))
    )
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(blown[name], larger[name], rtol=1e-9)


def test_recipe_of_a_meridian():
    pear = recipe("A rest shape", 2, RestMeridian=RestMeridian)["pear"](2.0, 0.3)
    assert (pear.radius, pear.top, pear.keel) == pytest.approx((2.0, 2.0, -2.6))
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, pear)
    assert rigid_buoy(shell, 0.1).volume() == pytest.approx(pear.volume_below(-0.1), rel=1e-12)
    assert (natural_modes(shell, 6).omega > 0).all()


def test_recipe_of_modes_without_meridional_motion(seed):
    """Ritz values with one of two displacements; breathing has no meridional part and is exact."""
    shell = Shell.of(seed.device)
    modes = recipe("A mode or a direction", Mode=Mode)["radial_modes"](4)
    breathing, *others = ModeBasis(shell, modes, seed.device.mass, bending=False).dry_frequencies
    exact = [natural_frequencies(shell, mode.degree) for mode in modes]
    assert breathing == pytest.approx(max(exact[0]), rel=1e-9)
    for found, (lower, upper) in zip(others, exact[1:], strict=True):
        assert 1.05 * lower < found < 0.995 * upper


def test_recipe_of_a_figure():
    time = np.linspace(0.0, 1.0, 5)
    runs = {
        (d, "sea"): xr.Dataset({"position": (("time", "dof"), k * time[:, None])}, {"time": time})
        for k, d in ((1, "A"), (3, "B"))
    }
    data = SimpleNamespace(designs=("A", "B"), runs=runs)
    names = {one.__name__: one for one in (StudyData, Figure, grid_of_axes, legend_above, style)}
    figure = recipe("A figure", **names)["heave"](data, "sea")
    assert [line.get_ydata()[-1] for line in figure.axes[0].lines] == [1.0, 3.0]
    assert [text.get_text() for text in figure.legends[0].texts] == ["A", "B"]


def test_recipe_of_a_stage(seed, tmp_path, monkeypatch):
    """Run from the text of its specification; that of another version is refused."""
    monkeypatch.setitem(specs.PHYSICS, "draft", 1)
    made = recipe(
        "A stage of the workflow", Stamp=Stamp, StudyPart=specs.StudyPart, write_text=write_text, record=record
    )
    monkeypatch.setitem(sys.modules, "vsb.stages.draft", SimpleNamespace(run_draft=made["run_draft"]))
    monkeypatch.setitem(STAGES, "draft", Stage("modes", "draft", "how deep a buoy lies"))
    out, manifest = str(tmp_path / "draft.txt"), str(tmp_path / "manifest.json")
    task = Task.of("draft", {"study": seed.only("device", "water")}, out, files={"manifest": manifest})
    run_task(task)
    assert float((tmp_path / "draft.txt").read_text().split()[0]) == pytest.approx(seed.draft, rel=1e-5)
    assert faults({out: task.id}, read_manifest(manifest)) == []
    monkeypatch.setitem(specs.PHYSICS, "draft", 2)
    with pytest.raises(ConfigError, match="physics 1: needs 2, of this version"):
        run_task(task)
