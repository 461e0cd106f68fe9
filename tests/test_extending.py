"""Recipes of `docs/extending.md` as they stand there; an integrator in a study is `integrators/test_simulate.py`'s."""

import sys
import time as clock
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import HERE, varied
from pydantic import ValidationError

from vsb.errors import ConfigError
from vsb.hydro.dofs import Displacement
from vsb.hydro.spectral.solver import SpectralProblem
from vsb.integrators.audit import energies, residual
from vsb.integrators.exact import propagate
from vsb.integrators.harmonic_balance import harmonic_balance
from vsb.integrators.phi import phi_integrals
from vsb.integrators.simulate import METHODS, Method, suited
from vsb.motion.forces import Damper, Excitation, Force, Linear, Spring
from vsb.motion.pto import LinearPto
from vsb.motion.scene import Scene
from vsb.motion.system import System
from vsb.report.canvas import grid_of_axes, style
from vsb.scenes.rest import study_basis
from vsb.scenes.take_off import LAWS, with_take_off
from vsb.shell.deformed import DeformedShell, rigid_buoy, rigid_sphere
from vsb.shell.modes import Mode, ModeBasis
from vsb.shell.ritz import natural_modes
from vsb.shell.sphere import Shell, natural_frequencies
from vsb.stages.stage import Stage
from vsb.study import specs
from vsb.study.blocks import HydroPlan
from vsb.study.meridian import RestMeridian
from vsb.study.study import canonical, content_id
from vsb.study.take_off import Pto
from vsb.study.waves import WhiteNoise
from vsb.tools.files import write_text
from vsb.tools.stamps import faults, read_manifest, record
from vsb.waves import seas


def recipe(title, number=1, **names):
    """What the code of a recipe defines, its first or another."""
    text = (HERE.parent / "docs" / "extending.md").read_text(encoding="utf-8").split(f"## {title}\n")[1]
    code = text.split("```python\n")[number].split("```")[0]
    assert len(code.strip().splitlines()) <= 15
    exec(code, names)
    return names


def test_a_take_off_law_takes_what_the_wave_brings():
    """Its mean power is that of its force on the steady motion, and the balance of harmonic balance closes."""
    law = recipe("A take-off law", dataclass=dataclass, Force=Force, Linear=Linear, np=np)["QuadraticDamper"](0.5)
    wave, spring = Excitation(np.array([2.5]), np.array([[30.0 + 5j]])), Spring(np.array([[50.0]]))
    forces = {"hydrostatic": spring, "damper": Damper(np.array([[1.2]])), "excitation": wave, "square": law}
    found = harmonic_balance(
        System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1), take_off="square")), 1e-8
    )
    _, rate = found.at(np.linspace(0.0, 2 * np.pi / 2.5, 4097)[:-1])
    assert found.power.pto == pytest.approx(float(np.mean(0.5 * np.abs(rate[:, 0]) ** 3)), rel=1e-5)
    assert found.power.residual < 1e-6


def test_a_law_that_is_not_of_straight_pieces_is_a_row(monkeypatch):
    """It need not be a `TakeOff`, and what follows it is told by the force alone."""
    law = recipe("A take-off law", dataclass=dataclass, Force=Force, Linear=Linear, np=np)["QuadraticDamper"]
    monkeypatch.setitem(LAWS, "saturated", lambda pto, port, damper, rest: law(damper))
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]]))}
    scene = Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1))
    found = with_take_off(scene, Pto(damping=1.2, law="saturated", force_limit=9.0), LinearPto(1.2))
    assert found.forces["pto"] == law(1.2)
    assert suited(System.of(found)) == "collocation"


def test_a_force_is_followed_and_its_energy_told():
    """A spring that hardens: no matrix knows it, collocation and audit do."""
    force = recipe("A force", dataclass=dataclass, Force=Force, Linear=Linear, np=np)["Hardening"](400.0)
    forces = {"hydrostatic": Spring(np.array([[50.0]])), "pto": Damper(np.array([[1.2]])), "hardening": force}
    system = System.of(Scene(("Heave",), np.array([[2.0]]), forces, np.eye(1)))
    assert suited(system) == "collocation"
    time = np.linspace(0.0, 4.0, 401)
    motion, _ = METHODS["collocation"].follower(system, 1e-9, None)(time, (np.array([0.5]), np.array([0.0])))
    found = energies(system, motion)
    assert residual(found) < 1e-6
    assert np.ptp(force.stored(motion.position)) > 5.0
    assert found["pto"][-1] == pytest.approx(np.trapezoid(1.2 * motion.velocity[:, 0] ** 2, time), rel=1e-3)


def test_a_spectrum_carries_its_significant_height(monkeypatch):
    swell = recipe("A sea spectrum", np=np)["swell"]
    monkeypatch.setattr(seas, "spectrum", lambda wave, omega: swell(omega, wave.hs, 1.0, 0.05))
    sea = seas.irregular(WhiteNoise(kind="white_noise", hs=1.5, band=(0.5, 1.5)), 3.0, 600.0)
    assert 16 * np.sum(np.abs(sea.amplitude) ** 2) / 2 == pytest.approx(1.5**2, rel=1e-6)
    assert sea.omega[np.argmax(np.abs(sea.amplitude))] == pytest.approx(1.0, abs=0.01)


def test_an_integrator_is_a_function_and_a_row(monkeypatch):
    """Waves held over a step: half the step, half the error."""
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


def test_the_water_around_a_rest_shape_follows_from_it(seed):
    """A sphere blown up is a larger sphere to the solver."""
    shape = recipe("A rest shape", np=np, DeformedShell=DeformedShell)["inflated"](study_basis(seed), 0.2, 0.3)
    assert shape.volume() == pytest.approx(rigid_sphere(2.3, 0.2).volume(), rel=1e-12)
    blown, larger = (
        SpectralProblem(s, (Displacement("heave"),), 1025.0, 9.81, 24).solve([1.5])
        for s in (shape, rigid_sphere(2.3, 0.2))
    )
    for name in ("added_mass", "radiation_damping"):
        np.testing.assert_allclose(blown[name], larger[name], rtol=1e-9)


def test_the_solvers_of_the_water_are_told_every_rest_shape(seed):
    """One that has no name there yet is refused; it was taken for the sphere."""
    with pytest.raises(ValidationError, match="reference_shape"):
        _ = HydroPlan(seed.model_copy(update={"reference_shape": "inflated"})).shape
    rigid = varied(seed, reference_shape="equilibrium", designs={"FSB": {"flexible": False}})
    assert isinstance(HydroPlan(rigid).shape, specs.Sphere)


def test_an_unloaded_shape_is_a_meridian():
    pear = recipe("A rest shape", 2, RestMeridian=RestMeridian)["pear"](2.0, 0.3)
    assert (pear.radius, pear.top, pear.keel) == pytest.approx((2.0, 2.0, -2.6))
    shell = Shell(2.0, 0.01, 1e7, 0.3, 2700.0, pear)
    assert rigid_buoy(shell, 0.1).volume() == pytest.approx(pear.volume_below(-0.1), rel=1e-12)
    assert (natural_modes(shell, 6).omega > 0).all()


def test_modes_without_meridional_motion_lie_between_both_branches(seed):
    """Ritz values of one coordinate where there are two; breathing has no meridional part and is exact."""
    shell = Shell.of(seed.device)
    modes = recipe("A mode or a direction", Mode=Mode)["radial_modes"](4)
    breathing, *others = ModeBasis(shell, modes, seed.device.mass, bending=False).dry_frequencies
    exact = [natural_frequencies(shell, mode.degree) for mode in modes]
    assert breathing == pytest.approx(max(exact[0]), rel=1e-9)
    for found, (lower, upper) in zip(others, exact[1:], strict=True):
        assert 1.05 * lower < found < 0.995 * upper


def test_a_figure_draws_what_its_data_say():
    time = np.linspace(0.0, 1.0, 5)
    runs = {
        (d, "sea"): xr.Dataset({"position": (("time", "dof"), k * time[:, None])}, {"time": time})
        for k, d in ((1, "A"), (3, "B"))
    }
    data = SimpleNamespace(designs=("A", "B"), runs=runs)
    figure = recipe("A figure", grid_of_axes=grid_of_axes, style=style)["heave"](data, "sea")
    assert [line.get_ydata()[-1] for line in figure.axes[0].lines] == [1.0, 3.0]


def test_a_stage_is_a_specification_and_a_function(seed, tmp_path, monkeypatch):
    """From its text alone; that of another version is refused, and what it does not name it does not have."""
    monkeypatch.setitem(specs.PHYSICS, "draft", 1)
    made = recipe("A stage", AfloatSpec=specs.AfloatSpec, write_text=write_text, record=record, content_id=content_id)
    monkeypatch.setitem(sys.modules, "vsb.stages.draft", SimpleNamespace(run=made["run"]))
    stage, spec = (
        Stage("draft", "how deep a buoy lies", made["DraftSpec"], ("out", "manifest")),
        made["DraftSpec"](device=seed.device, water=seed.water),
    )
    out, manifest = str(tmp_path / "draft.txt"), str(tmp_path / "manifest.json")
    stage.run({"out": out, "manifest": manifest}, canonical(spec))
    assert float((tmp_path / "draft.txt").read_text().split()[0]) == pytest.approx(seed.draft, rel=1e-5)
    assert faults({out: content_id(spec)}, read_manifest(manifest)) == []
    assert not hasattr(spec, "waves")
    monkeypatch.setitem(specs.PHYSICS, "draft", 2)
    with pytest.raises(ConfigError, match="physics 1: needs 2, of this version"):
        stage.read(canonical(spec))
