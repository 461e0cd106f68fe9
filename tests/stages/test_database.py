"""Rule database: its blocks and no others, in the modes, with a verdict."""

import json
import shutil
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from conftest import SMALL_PLAN, varied
from study.test_shape import OBLATE, raw

from vsb import __version__
from vsb.errors import DatabaseError
from vsb.hydro import orders
from vsb.hydro.database import load_database
from vsb.stages import database
from vsb.stages.make import make
from vsb.stages.stage import stamp
from vsb.study.plan import StudyPlan
from vsb.study.specs import DatabaseSpec
from vsb.study.study import content_id, parse
from vsb.tools.files import load, save


def test_a_database_made_again_is_the_same(small, tmp_path):
    out = tmp_path / "db" / Path(small.database_path).name
    database.run(small.database, small.block_folder, str(out))
    again = load_database(out, content_id(small.database))
    assert again.identical(load_database(small.database_path, content_id(small.database)))
    assert again.attrs["solver"] == "spectral"
    assert (again.attrs["basis"], again.attrs["degree"]) == ("membrane", 2)
    assert float(again.omega[-1]) == small.database.omega_max
    assert {check["verdict"] for check in json.loads(again.attrs["quality"])} <= {"ok", "doubt"}
    stiffness = again.hydrostatic_stiffness.values
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-6 * np.abs(stiffness).max())


def test_a_block_that_is_missing_or_another_is_refused(small, tmp_path):
    (name,) = small.database.sweep
    with pytest.raises(DatabaseError, match=rf"{name}.nc: file not found"):
        database.run(small.database, str(tmp_path), str(tmp_path / "out.nc"))
    save(load(f"{small.block_folder}/{name}.nc").assign_attrs(spec_id="0" * 16), tmp_path / f"{name}.nc")
    with pytest.raises(DatabaseError, match=rf"{name}.nc: holds block 0+, needs {name}; delete it and run again"):
        database.run(small.database, str(tmp_path), str(tmp_path / "out.nc"))
    assert not (tmp_path / "out.nc").exists()


def test_a_check_that_fails_stops_it_unless_it_is_accepted(small, tmp_path):
    """Damping of the wrong size satisfies Haskind's relation no more."""
    (name,) = small.database.sweep
    shutil.copy(f"{small.block_folder}/{name}.nc", tmp_path)
    block = load(tmp_path / f"{name}.nc")
    save(block.assign(radiation_damping=1.3 * block.radiation_damping), tmp_path / f"{name}.nc")
    out = str(tmp_path / "db" / "out.nc")
    with pytest.raises(DatabaseError, match=r"hydro database: check '\w+' failed: .*list the name under hydro.accept"):
        database.run(small.database, str(tmp_path), out)
    assert not Path(out).exists()
    spec = DatabaseSpec(**{**small.database.model_dump(), "accept": ("haskind", "kramers_kronig")})
    database.run(spec, str(tmp_path), out)
    assert "accepted" in load(out).attrs["quality"]


def test_a_rigid_buoy_is_told_to_be_of_degree_one(seed, tmp_path):
    """Its only degree of freedom is heave, a displacement of degree one: `INDEX.tsv` says so."""
    study = varied(seed, designs={"FSB": {"flexible": False}}, modes={"degree": 0}, hydro={
        "omega_max": 3.0, "tolerance": 0.01, "witness": "none"}, reference_shape="undeformed")  # fmt: skip
    plan = StudyPlan(study, root=str(tmp_path))
    make(plan, [plan.database_path])
    found = load_database(plan.database_path, content_id(plan.database))
    assert plan.database.modes is None
    assert (found.attrs["basis"], found.attrs["degree"]) == ("rigid", 1)


@pytest.mark.parametrize("mass", [9e3, 15e3, 22e3])
def test_other_codes_are_told_where_the_water_holds_a_spheroid(mass):
    """Of semi-axes 2 and 1.5 m: a sphere's cap, squeezed; volume and moment of its slices."""
    spec = StudyPlan(parse(raw(OBLATE, device={"mass": mass}))).database
    told, height = database._at_rest(spec), spec.centre_height
    z = np.linspace(-1.5, -height, 20_001)  # of the spheroid's own
    slices = np.pi * 4.0 * (1 - (z / 1.5) ** 2)
    volume = np.trapezoid(slices, z)
    assert volume * 1025 == pytest.approx(mass, rel=1e-6)
    assert told["displaced_volume"] == pytest.approx(volume, rel=1e-6)
    assert told["centre_of_buoyancy"] == pytest.approx(
        [0.0, 0.0, height + np.trapezoid(slices * z, z) / volume], rel=1e-6
    )
    assert told["centre_of_mass"] == [0.0, 0.0, height]


@pytest.mark.parametrize("order", [None, 1, 2])
def test_coefficients_are_judged_by_the_relations_of_their_own_order(small, monkeypatch, order):
    """Swept and tabulated alike; pitch about a sphere's centre moves no water, and is not asked."""
    labels, asked = ["Surge", "Pitch", "Bend"], []
    pair = dict.fromkeys(("influenced_dof", "radiating_dof"), labels)
    values = xr.DataArray(np.ones((3, 3)), pair, tuple(pair))
    monkeypatch.setattr(database.quality, "verdict", lambda *given: asked.append(given))
    basis = SimpleNamespace(order=order) if order else None
    part = database._Part(small.database, None, {}, basis)
    for tabulated in (None, values.to_dataset(name="added_mass_inf")):
        part.verdict(values.to_dataset(name="added_mass_zero"), tabulated, 0.3)
    for (swept, other, *told), name in zip(asked, (None, "added_mass_inf"), strict=True):
        assert told == [small.study.water, 0.3, order or 0]
        assert swept.added_mass_zero.shape == (2, 2)
        assert list(swept.influenced_dof.values) == list(swept.radiating_dof.values) == ["Surge", "Bend"]
        assert other is None if name is None else other[name].shape == (2, 2)


ABOUT = 3.0 + 1e-12
"""A frequency of a grid, which is that of the end of its band but for round-off."""


def fake_run(monkeypatch, spec, solver, families):
    """Everything a run asks for, and what it saves, of blocks that say their solver."""
    asked, saved = {"blocks": [], "parts": [], "modes": [], "verdicts": []}, []
    parts = iter(range(9))

    def block(path, name):
        asked["blocks"].append((path, name))
        dims = {} if name.startswith("inf") else {"omega": [1.0]}
        return xr.Dataset(coords=dims, attrs={"spec": json.dumps({"solver": solver}), "seconds": len(asked["blocks"])})

    class Part:
        def __init__(self, *given):
            asked["parts"].append(given)
            self.number = next(parts)

        def in_modes(self, names):
            asked["modes"].append((self.number, list(names)))
            return f"{self.number}: {'+'.join(names)}"

        def verdict(self, *given):
            asked["verdicts"].append((self.number, *given))
            return [f"verdict {self.number}"]

    def whole(given, all_parts, raw, others):
        asked.setdefault("whole", []).append((given, [part.number for part in all_parts], list(raw), others))
        return xr.Dataset({"x": ("omega", np.ones(4))}, {"omega": [1.0, 2.0, ABOUT, 4.0]}, {"history": "told"})

    def recorded(name, found):
        return lambda *given: asked.setdefault(name, []).append(given) or found

    monkeypatch.setattr(database, "_block", block)
    monkeypatch.setattr(database, "_Part", Part)
    monkeypatch.setattr(database, "_whole", whole)
    monkeypatch.setattr(database, "reference_shell", recorded("reference", SimpleNamespace(basis="the basis")))
    monkeypatch.setattr(database, "order_bases", recorded("bases", families))
    monkeypatch.setattr(database.quality, "estimate_checks", recorded("estimates", ["estimate"]))
    monkeypatch.setattr(database.quality, "judged", recorded("judged", ["judged"]))
    monkeypatch.setattr(database.database, "as_json", lambda checks: f"json of {checks}")
    monkeypatch.setattr(database.database, "save_database", lambda *given: saved.append(given))
    database.run(spec, "blocks", "out.nc")
    return asked, saved


@pytest.mark.parametrize(
    ("solver", "tolerance", "precision"),
    [("spectral", 1e-4, 0.1), ("spectral", 5e-3, 1.0), ("panels", 1e-4, 1.0)],
)
@pytest.mark.parametrize("tabulated", [False, True])
def test_a_run_judges_and_stores_every_order_that_is_solved(monkeypatch, solver, tolerance, precision, tabulated):
    """Sines are their cosines'; frequencies tabulated are stored in front of the sweep, whose end is none of them."""
    families = tuple(SimpleNamespace(order=order, odd=odd) for order, odd in ((1, False), (1, True), (2, False)))
    spec = SMALL_PLAN.database.model_copy(update={
        "sweep": ("one", "inf", "two"), "tabulated": ("three", "four") if tabulated else (), "tolerance": tolerance,
        "accept": ("haskind",), "omega_max": 3.0,
        "water": SMALL_PLAN.study.water.model_copy(update={"density": 1010.0, "gravity": 9.7, "depth": 30.0}),
    })  # fmt: skip
    asked, saved = fake_run(monkeypatch, spec, solver, families)
    names = ["one", "inf", "two", *spec.tabulated]
    assert asked["blocks"] == [(f"blocks/{name}.nc", name) for name in names]
    assert asked["reference"] == [(spec,)]
    assert asked["bases"] == [(spec, "the basis")]
    assert [basis for *_, basis in asked["parts"]] == [None, families[0], families[2]]
    for own, reference, found, _ in asked["parts"]:
        assert (own, reference.basis, list(found)) == (spec, "the basis", names)
    swept = [f"{i}: one+inf+two" for i in range(3)]
    front = [f"{i}: three+four+inf" if tabulated else None for i in range(3)]
    assert asked["verdicts"] == [(i, swept[i], front[i], pytest.approx(precision)) for i in range(3)]
    ((attributes, limit),) = asked["estimates"]
    assert ([each["seconds"] for each in attributes], limit) == (list(range(1, len(names) + 1)), tolerance)
    assert asked["judged"] == [(["estimate", "verdict 0", "verdict 1", "verdict 2"], ("haskind",))]
    assert (spec, [0, 1, 2], swept, families) in asked["whole"]
    if tabulated:
        assert (spec, [0, 1, 2], front, families) in asked["whole"]
    ((kept, everywhere, out),) = saved
    assert out == "out.nc"
    assert kept.omega.values.tolist() == ([1.0, 2.0, ABOUT, 4.0] if tabulated else [1.0, 2.0, ABOUT])
    assert everywhere is None or everywhere.omega.values.tolist() == [1.0, 2.0, ABOUT, 4.0]
    assert (everywhere is not None) == tabulated
    assert kept.attrs == {
        "history": "told", "title": "hydro database of an axisymmetric shell in heave and its modes",
        "source": f"vsb {__version__}", **stamp(spec), "quality": "json of ['judged']", "radius": spec.device.radius,
        "centre_height": spec.centre_height, "basis": "membrane", "degree": 2, "water_density": 1010.0,
        "water_depth": "30.0", "gravity": 9.7, "solver": solver, "bem_seconds": sum(range(1, len(names) + 1)),
    }  # fmt: skip


def ring_of(labels, seed):
    """Coefficients of labelled motions at two frequencies, in the waves that excite them most; matrices uneven."""
    rng, n, pair = np.random.default_rng(seed), len(labels), ("influenced_dof", "radiating_dof")
    matrices = {name: (("omega", *pair), rng.normal(size=(2, n, n))) for name in ("added_mass", "radiation_damping")}
    force = rng.normal(size=(2, 1, n)) + 1j * rng.normal(size=(2, 1, n))
    return xr.Dataset(
        {
            **matrices,
            "added_mass_inf": (pair, rng.normal(size=(n, n))),
            "excitation_force": (("omega", "wave_direction", "influenced_dof"), force),
        },
        {"omega": [0.7, 1.9], "wave_direction": [0.0], **{dim: list(labels) for dim in pair}},
    )


@pytest.mark.parametrize("motion", ["heave", "planar", "free"])
def test_all_orders_stand_side_by_side_sines_as_their_cosines_turned(seed, motion):
    """Damping of m >= 1 is Haskind's; each is excited by the waves that do so most, yaw by none; moored as it says."""
    ballast = {"centre_of_mass": -0.3, "ballast_inertia": 5e3}
    mooring = {"heave": None, "planar": [2e4, 0, 1e3, 0, 5e3, 0], "free": [2e4, 3e4, 1e3, 4e3, 5e3, 6e3]}[motion]
    changes = {
        "heave": {},
        "planar": {"device": ballast, "mooring": mooring},
        "free": {"device": ballast | {"ballast_yaw_inertia": 7e3}, "mooring": mooring},
    }[motion]
    study = varied(seed, motion=motion, modes={"degree": 2, "order": 2 if mooring else 1}, **changes)
    spec = StudyPlan(study).database
    reference = database.reference_shell(spec)
    families = database.order_bases(spec, reference.basis)
    bases = [None, *(one for one in families if not one.odd)]
    parts = [database._Part(spec, reference, {}, basis) for basis in bases]
    raw_parts = [ring_of(b.labels if b else reference.basis.labels, i) for i, b in enumerate(bases)]
    whole = database._whole(spec, parts, raw_parts, families)
    water, pair = spec.water, ("influenced_dof", "radiating_dof")
    complete = {part.order: part.complete(one) for part, one in zip(parts, raw_parts, strict=True)}
    for part, one in zip(parts, raw_parts, strict=True):
        mass = one.added_mass.values
        own = complete[part.order]
        np.testing.assert_allclose(own.added_mass.values, (mass + mass.swapaxes(1, 2)) / 2)
        x, damping = one.excitation_force.values[:, 0], one.radiation_damping.values
        flux = 8 * water.density * water.gravity * (water.gravity / (2 * one.omega.values))
        k = one.omega.values**2 / water.gravity
        haskind = ((k / flux)[:, None, None] * x[:, :, None] * x[:, None].conj()).real
        np.testing.assert_allclose(
            own.radiation_damping.values, haskind if part.order else (damping + damping.swapaxes(1, 2)) / 2, rtol=1e-9
        )
        assert own.inertia_matrix.shape == own.hydrostatic_stiffness.shape == mass.shape[1:]
    if motion == "heave":
        assert whole.identical(complete[0])
        return
    labels = [*reference.basis.labels, *(label for one in families for label in one.labels)]
    assert whole.influenced_dof.values.tolist() == whole.radiating_dof.values.tolist() == labels
    signs = [0] * len(reference.basis.labels) + [one.signed for one in families for _ in one.labels]
    assert whole.azimuthal_order.values.tolist() == signs
    for name in ("added_mass", "radiation_damping", "inertia_matrix", "hydrostatic_stiffness"):
        matrices, start = whole[name].values, 0
        for one in (None, *families):
            like = complete[one.order if one else 0]
            size = len(one.labels) if one else like.sizes["influenced_dof"]
            block = matrices[..., start : start + size, start : start + size]
            yaw = one is not None and one.odd and not one.order
            if name in ("added_mass", "radiation_damping"):
                np.testing.assert_allclose(block, np.zeros_like(block) if yaw else like[name].values, rtol=1e-12)
            elif one:
                stiffness = database.order_stiffness(spec, one, reference)["hydrostatic"]
                np.testing.assert_allclose(block, one.inertia if name == "inertia_matrix" else stiffness, rtol=1e-12)
            start += size
    to_sides = [0.0] if motion == "planar" else [0.0, np.pi / 4, np.pi / 2]
    assert whole.wave_direction.values.tolist() == pytest.approx(to_sides)
    own, start = orders.most_exciting(whole, "excitation_force"), 0
    for one in (None, *families):
        like = complete[one.order if one else 0].excitation_force.values[:, 0]
        size = len(one.labels) if one else like.shape[1]
        yaw = one is not None and one.odd and not one.order
        np.testing.assert_allclose(own[:, start : start + size], 0.0 if yaw else like, atol=1e-12)
        start += size
    among = np.zeros(len(labels))
    for name, stiffness in zip(("Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"), mooring, strict=True):
        if name in labels:
            among[labels.index(name)] = stiffness
    np.testing.assert_allclose(whole.mooring_stiffness.values, np.diag(among))
    assert whole.mooring_stiffness.dims == pair


@pytest.mark.parametrize("order", [0, 1, 2])
def test_of_blocks_an_order_takes_its_own_and_excitation_is_the_whole_force(seed, monkeypatch, order):
    """A block that does not say its order is of order 0; blocks may come in any order of frequency."""
    merged = []
    ds = xr.Dataset({"Froude_Krylov_force": ("omega", [1.0]), "diffraction_force": ("omega", [2.5])}, {"omega": [1.0]})
    found = {
        name: ds.assign_attrs(name=name, spec=json.dumps({"order": of} if of else {"solver": "panels"}))
        for name, of in {"a": 0, "b": 1, "c": 2, "d": 1, "e": 0, "f": 2}.items()
    }
    monkeypatch.setattr(database.database, "merged_blocks", lambda given: merged.extend(given) or ds)
    in_modes = []
    monkeypatch.setattr(database.database, "in_modes", lambda *given: in_modes.append(("axisymmetric", given[1])) or ds)
    monkeypatch.setattr(database.orders, "in_order_modes", lambda *given: in_modes.append(("order", given[1])) or ds)
    basis = SimpleNamespace(order=order) if order else None
    part = database._Part(None, SimpleNamespace(basis="heave and modes"), found, basis)
    assert part.in_modes(["e", "d", "c", "b", "a", "f"]).excitation_force.values.tolist() == [3.5]
    assert [block.attrs["name"] for block in merged] == {0: ["e", "a"], 1: ["d", "b"], 2: ["c", "f"]}[order]
    assert in_modes == [("order", basis) if order else ("axisymmetric", "heave and modes")]


def test_a_block_is_the_one_of_its_name(tmp_path):
    save(xr.Dataset(attrs={"spec_id": "one", "number": 1.0}), tmp_path / "one.nc")
    assert database._block(str(tmp_path / "one.nc"), "one").attrs["number"] == 1.0
    with pytest.raises(DatabaseError, match=r"one.nc: holds block one, needs two; delete it and run again\.$"):
        database._block(str(tmp_path / "one.nc"), "two")
