import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
import yaml
from hydro.bodies.test_body import made, rigid

from examples import barge
from vsb.errors import ConfigError
from vsb.hydro import database
from vsb.hydro.bodies import files as bodyfiles
from vsb.hydro.bodies import study as bodystudy
from vsb.hydro.bodies.body import joined, panel_size
from vsb.hydro.bodies.coarsening import CoarserBody, coarser_body
from vsb.hydro.bodies.study import BodyProblem
from vsb.study import blocks
from vsb.study.body import BodyFile
from vsb.study.quantities import content_id
from vsb.study.sections import Water
from vsb.tools.files import load
from vsb.waves.dispersion import group_velocity, wavenumber

LABELS = ("Heave", "Pitch", "Bend")


@pytest.fixture(scope="module")
def body():
    vertices, faces = barge.box(6.0, 4.0, 2.0, 1)
    bend = np.zeros_like(vertices)
    bend[:, 2] = (vertices[:, 0] / 3.0) ** 2
    shapes = np.concatenate([rigid(vertices)[[2, 4]], bend[None]])
    mass = np.diag([1025.0 * 48.0, 1e5, 1e4])
    return made(vertices, faces, shapes, LABELS, mass=mass, stiffness=np.diag([0.0, 0.0, 1e6]))


def files(folder, body, **changes):
    """A body file and what it names, in one folder."""
    bodyfiles.write_body(body, folder / "box.nc")
    raw = {
        "body": "box",
        "mesh": "box.nc",
        "modes": "box.nc",
        "omega": [1.0, 1.3],
        "wave_direction": [0.0, 30.0],
        "lid": 1,
    }
    (folder / "box.yaml").write_text(yaml.safe_dump(raw | changes))
    return folder / "box.yaml"


@pytest.fixture
def calls(monkeypatch):
    """Frequencies solved, as they are solved."""
    solved = []
    monkeypatch.setattr(BodyProblem, "solve", counted(BodyProblem.solve, solved))
    monkeypatch.setattr(BodyProblem, "at_infinity", counted(BodyProblem.at_infinity, solved))
    return solved


def counted(method, solved):
    def call(self, *args):
        if not isinstance(self.body, CoarserBody):
            solved.append(args[0] if args else np.inf)
        return method(self, *args)

    return call


def test_a_body_file_becomes_a_database_with_a_verdict(tmp_path, body, green_folder):
    water = {"density": 1000.0, "gravity": 9.8}
    checks = bodystudy.run(files(tmp_path, body, water=water), tmp_path / "out", green_folder)
    names = {"error_estimate", "symmetry", "far_field", "haskind", "positive_damping", "panels", "corners"}
    names |= {"rigid_names", "one_resolution", "second_order", "afloat", "modes"}
    assert {check.name for check in checks} == names
    ds = load(tmp_path / "out/box.nc")
    assert database.stored_checks(ds) == checks
    assert database.load_database(tmp_path / "out/box.nc", ds.attrs["spec_id"]).attrs["symmetry"] == "xOz+yOz"
    assert list(ds.influenced_dof.values) == list(LABELS)
    assert ds.wave_direction.values == pytest.approx(np.deg2rad([0.0, 30.0]))
    assert ds.excitation_force.values == pytest.approx((ds.Froude_Krylov_force + ds.diffraction_force).values)
    for name in ("added_mass", "radiation_damping", "added_mass_inf", "hydrostatic_stiffness", "structural_stiffness"):
        assert ds[name].values == pytest.approx(ds[name].values.swapaxes(-1, -2), rel=1e-12, abs=1e-6), name
    assert ds.inertia_matrix.values == pytest.approx(body.mass)
    told = {"water_density": 1000.0, "gravity": 9.8, "water_depth": "inf", "symmetry": "xOz+yOz", "separate_sweep": 0}
    told |= {"solves": 2, "frequencies": 2, "solver": blocks.panel_solver(), "Conventions": "CF-1.8"}
    told |= {"title": f"hydro database of box: {len(body.faces)} panels, 3 degrees of freedom"}
    assert {name: ds.attrs[name] for name in told} == told
    assert ds.attrs["displaced_volume"] == pytest.approx(6.0 * 4.0 * 2.0)
    assert ds.attrs["centre_of_buoyancy"] == pytest.approx([0.0, 0.0, -1.0], abs=1e-9)
    assert float(ds.hydrostatic_stiffness[0, 0]) == pytest.approx(1000.0 * 9.8 * 6.0 * 4.0)
    assert ds.structural_stiffness.values == pytest.approx(np.diag([0.0, 0.0, 1e6]))
    spec, solved = json.loads(ds.attrs["spec"]), {path.stem: load(path) for path in tmp_path.glob("out/blocks/*.nc")}
    order = {"inf" if "omega" not in block.dims else float(block.omega[0]): name for name, block in solved.items()}
    assert spec["blocks"] == [order["inf"], order[1.0], order[1.3]]
    assert len(solved) == 3
    assert ds.attrs["bem_seconds"] == pytest.approx(sum(block.attrs["seconds"] for block in solved.values()), rel=1e-12)
    assert all(block.attrs["seconds"] > 0 for block in solved.values())
    assert ds.attrs["spec_id"] == content_id(spec)


def test_what_one_frequency_is_solved_from(body, monkeypatch):
    """Another of these is another block; symmetry is not among them, nor waves and lid at infinite frequency."""
    given = {"body": "box", "mesh": "-", "modes": "-", "omega": (1.0,), "wave_direction": (0.0,), "lid": 1}

    def ids(body=body, **changes):
        file = BodyFile(**given | changes)
        return [content_id(bodystudy._spec(file, body, omega, file.lid)) for omega in (np.inf, 1.0)]

    before = ids()
    assert ids(symmetry="none", tolerance=0.01, omega=(1.0, 2.0), body=body) == before
    for waves in ({"lid": 2}, {"wave_direction": (0.0, 30.0)}):
        assert [a == b for a, b in zip(ids(**waves), before, strict=True)] == [True, False]
    moved = replace(body, vertices=body.vertices * [1.0, 1.0, 0.9])
    other = replace(body, modes=1.1 * body.modes)
    named = replace(body, labels=("Heave", "Pitch", "Bow"))
    turned = replace(body, faces=body.faces[:, [1, 2, 3, 0]])
    for found in (ids(water={"density": 1000.0}), *(ids(body=one) for one in (moved, other, named, turned))):
        assert not {*found} & {*before}
    monkeypatch.setattr(blocks, "version", lambda package: f"{package} of tomorrow")
    assert not {*ids()} & {*before}


def test_nothing_is_solved_twice_and_an_interrupted_run_goes_on(tmp_path, body, green_folder, calls, monkeypatch):
    config, out = files(tmp_path, body), tmp_path / "out"
    save = bodystudy.save

    def killed(ds, *args):
        if "omega" in ds.dims and float(ds.omega[0]) == 1.3:
            raise KeyboardInterrupt
        save(ds, *args)

    monkeypatch.setattr(bodystudy, "save", killed)
    with pytest.raises(KeyboardInterrupt):
        bodystudy.run(config, out, green_folder)
    assert not (out / "box.nc").exists()
    monkeypatch.setattr(bodystudy, "save", save)
    calls.clear()
    bodystudy.run(config, out, green_folder)
    assert calls == [1.3]
    bodystudy.run(files(tmp_path, body, omega=[1.0, 1.15, 1.3], symmetry="none"), out, green_folder)
    assert calls == [1.3, 1.15]
    assert list(load(out / "box.nc").omega.values) == [1.0, 1.15, 1.3]
    bodystudy.run(files(tmp_path, body, water={"density": 1000.0}, omega=[1.0]), out, green_folder)
    assert calls == [1.3, 1.15, np.inf, 1.0]


def test_with_a_tolerance_few_frequencies_are_solved_and_an_interrupted_sweep_goes_on(
    tmp_path, body, green_folder, calls, monkeypatch
):
    omega = np.linspace(0.6, 1.8, 20).round(3).tolist()
    config, out = files(tmp_path, body, omega=omega, tolerance=0.01), tmp_path / "out"
    save, saved = bodystudy.save, []

    def killed(ds, *args):
        if len(saved) == 9:
            raise KeyboardInterrupt
        saved.append(ds)
        save(ds, *args)

    monkeypatch.setattr(bodystudy, "save", killed)
    with pytest.raises(KeyboardInterrupt):
        bodystudy.run(config, out, green_folder)
    monkeypatch.setattr(bodystudy, "save", save)
    calls.clear()
    checks = {check.name: check for check in bodystudy.run(config, out, green_folder)}
    ds, solves = load(out / "box.nc"), 8 + len(calls)
    assert ds.omega.values.tolist() == omega
    assert (ds.attrs["solves"], ds.attrs["frequencies"]) == (solves, 20)
    assert solves < 17
    assert len(list((out / "blocks").glob("*.nc"))) == solves + 1
    assert checks["interpolation_error"].explanation.startswith(f"{solves} solves for 20 frequencies")
    assert 0 < checks["interpolation_error"].value <= 0.01
    calls.clear()
    bodystudy.run(files(tmp_path, body, omega=omega), out, green_folder)
    assert len(calls) == 20 - solves
    true = load(out / "box.nc")
    root = np.sqrt(np.diag(true.added_mass_inf))
    for name in ("added_mass", "radiation_damping", "excitation_force"):
        units = root if name == "excitation_force" else np.outer(root, root)
        missed = np.abs(ds[name].values - true[name].values) / units
        assert missed.max() < 0.01 * (np.abs(true[name].values) / units).max(), name


def test_a_block_cut_short_is_solved_again(tmp_path, body, green_folder, calls):
    config, out = files(tmp_path, body, omega=[1.0]), tmp_path / "out"
    bodystudy.run(config, out, green_folder)
    for block in (out / "blocks").glob("*.nc"):
        block.write_bytes(block.read_bytes()[:200])
    bodystudy.run(config, out, green_folder)
    assert calls == [np.inf, 1.0] * 2


def test_a_block_of_another_specification_is_none_of_this(tmp_path):
    ds = xr.Dataset({"added_mass_inf": (("influenced_dof", "radiating_dof"), [[1.0]])}, attrs={"spec_id": "a"})
    bodystudy.save(ds, tmp_path / "block.nc")
    assert bodystudy._is_solved(tmp_path / "block.nc", "a")
    assert not bodystudy._is_solved(tmp_path / "block.nc", "b")
    assert not bodystudy._is_solved(tmp_path / "other.nc", "a")


@pytest.mark.parametrize("given", [None, "tables"])
def test_the_table_of_the_green_function_stands_beside_the_blocks_unless_told_otherwise(
    tmp_path, body, monkeypatch, given
):
    asked = []

    def blocks_of(*arguments):
        asked.append(arguments[-1])
        raise InterruptedError

    monkeypatch.setattr(bodystudy, "Blocks", blocks_of)
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[0.0])
    with pytest.raises(InterruptedError):
        bodystudy.solved(file, body, tmp_path, given)
    assert asked == [Path(given) if given else tmp_path / "green" / blocks.panel_solver().replace(" ", "-")]


def test_the_verdict_sees_a_body_that_does_not_float_where_it_lies(tmp_path, body, green_folder):
    heavy = made(body.vertices, body.faces, body.shapes, LABELS, mass=2 * body.mass)
    checks = bodystudy.run(files(tmp_path, heavy, omega=[1.0]), tmp_path / "out", green_folder)
    assert {check.name: check.verdict for check in checks}["afloat"] == "fail"


def test_waves_are_measured_over_the_middle_of_a_body_wherever_it_lies(tmp_path, body, monkeypatch):
    """Their phase at the origin would turn the faster with frequency, the further off the body: many solves."""
    seen = []

    class Enough(Exception):
        """The measure was told."""

    def stop(*given):
        seen.append(given[-1])
        raise Enough

    monkeypatch.setattr(bodystudy, "swept", stop)
    infinite = SimpleNamespace(added_mass_inf=xr.DataArray(np.eye(3)))
    monkeypatch.setattr(bodystudy.Blocks, "__call__", lambda *_: SimpleNamespace(own=infinite))
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[90.0])
    vertices = body.vertices + np.array([30.0, -20.0, 0.0])
    with pytest.raises(Enough):
        bodystudy.solved(file, made(vertices, body.faces, rigid(vertices)[[2, 4, 3]], LABELS), tmp_path)
    assert seen[0].centre == pytest.approx([30.0, -20.0, -1.0], abs=1e-12)
    assert seen[0].directions == pytest.approx([np.pi / 2])


def test_the_mass_afloat_is_that_of_heave_wherever_it_stands(body, monkeypatch):
    """Not of another rigid motion, nor of one that heaves by half."""
    monkeypatch.setattr(bodystudy, "error_estimate", lambda *_: 0.0)
    monkeypatch.setattr(bodystudy.quality, "negative_damping", lambda *_: 0.0)
    attrs = dict.fromkeys(("symmetry", "far_field", "haskind", "coarser_share"), 0.0)
    block = SimpleNamespace(own=SimpleNamespace(attrs=attrs))
    swept = SimpleNamespace(solved=[block], coefficients=None, error=0.0)
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[0.0])

    def floating_system(scale, labels, mass):
        one = made(body.vertices, body.faces, scale * body.shapes[[1, 0]], labels, mass=mass)
        return [c.value for c in bodystudy.verdict(file, one, block, swept, np.ones(2)) if c.name == "afloat"]

    mass = np.diag([1e5, 1025.0 * 48.0])
    assert floating_system(1.0, ("Pitch", "Heave"), mass) == pytest.approx([0.0], abs=1e-12)
    assert floating_system(1.0, ("Pitch", "Heave"), np.diag([1e5, 1025.0 * 36.0])) == pytest.approx([0.25], abs=1e-12)
    assert floating_system(0.5, ("Turn", "Half"), mass) == floating_system(1.0, ("Pitch", "Heave"), None) == []


@pytest.mark.parametrize(("wave", "answer"), [(0.5, "ok"), (0.7, "doubt"), (1.5, "fail")])
def test_the_verdict_sees_modes_the_panels_do_not_resolve(tmp_path, body, green_folder, wave, answer):
    """Panels of the box are 1.4 m in size, lobes of cos(wave x) pi/wave long: 4.6, 2.7 and 1.5 panels."""
    bend = np.zeros_like(body.vertices)
    bend[:, 2] = np.cos(wave * body.vertices[:, 0])
    lively = made(body.vertices, body.faces, np.concatenate([body.shapes[:1], bend[None]]), ("Heave", "Wave"))
    checks = bodystudy.run(files(tmp_path, lively, omega=[1.0], lid=0), tmp_path / "out", green_folder)
    assert {check.name: check.verdict for check in checks}["modes"] == answer


DEEP = 9.81 / 2.0**2 * 2 * np.pi  # length of a wave of 2 rad/s [m]
BORDERS = {  # check: where it is ok no more, where it fails
    "error_estimate": (0.05, 0.25), "one_resolution": (0.5, 2.5), "symmetry": (0.02, 0.1), "far_field": (0.02, 0.1),
    "haskind": (0.02, 0.1), "positive_damping": (0.01, 0.01), "panels": (0.25, 1.25), "modes": (1 / 3.5, 0.5),
    "corners": (0.05, 0.25), "rigid_names": (0.01, 0.05), "interpolation_error": (1e-3, 1e-3), "afloat": (0.01, 0.01),
    "hinge_gap": (0.02, np.inf), "second_order": (0.02, np.inf),
}  # fmt: skip


@pytest.mark.parametrize("name", BORDERS)
@pytest.mark.parametrize("part", [0, 1])
def test_every_limit_of_the_verdict_on_either_side(body, monkeypatch, name, part):
    """Of each check alone, by what it is told; all others are sound."""
    border = BORDERS[name][part]

    def verdict(value):
        told = dict.fromkeys(BORDERS, 0.0) | {name: value}
        shapes, mass = np.ones_like(body.modes), 1025.0 * body.volume * (1 + told["afloat"])
        for place, found in {
            "error_estimate": told["error_estimate"], "panel_diameters": np.array([told["panels"] * DEEP]),
            "panels_per_lobe": 1 / max(told["modes"], 1e-9), "at_centres": body.modes + told["corners"] * shapes,
            "rigid_misfit": told["rigid_names"], "hinge_gap": told["hinge_gap"], "linear_share": told["second_order"],
        }.items():  # fmt: skip
            monkeypatch.setattr(bodystudy, place, lambda *_, found=found: found)
        monkeypatch.setattr(bodystudy.quality, "negative_damping", lambda *_: told["positive_damping"])
        attrs = {key: told[key] for key in ("symmetry", "far_field", "haskind")}
        block = SimpleNamespace(own=SimpleNamespace(attrs=attrs | {"coarser_share": 1 - told["one_resolution"]}))
        file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0, 2.0], wave_direction=[0.0], tolerance=1e-3)
        swept = SimpleNamespace(solved=[block], coefficients=None, error=told["interpolation_error"])
        heavy = replace(body, mass=np.diag([mass, 1e5, 1e4]))
        checks = bodystudy.verdict(file, heavy, block, swept, np.ones(3))
        found = {check.name: check.verdict for check in checks}
        assert found.keys() == BORDERS.keys()
        assert {found[other] for other in found if other != name} == {"ok"}
        return found[name]

    if border == np.inf:
        assert verdict(1e9) == "doubt"
        return
    for sign in (1, -1) if name == "afloat" else (1,):  # too light is as wrong as too heavy
        below, above = verdict(0.99 * sign * border), verdict(1.01 * sign * border)
        if part:
            assert below != "fail" == above
        else:
            assert below == "ok" != above


def test_panels_without_area_are_dropped_and_the_repair_is_recorded(tmp_path, body, green_folder):
    """Triangles of a closed fan, quadrilaterals that end in a line: the same numbers without them."""
    faces = np.concatenate([body.faces[:3], [[0, 1, 1, 0], [2, 2, 2, 2]], body.faces[3:]])
    config = files(tmp_path, body, omega=[1.0])
    bodystudy.run(config, tmp_path / "clean", green_folder)
    lean = xr.Dataset({"vertices": (("vertex", "xyz"), body.vertices), "faces": (("panel", "corner"), faces)})
    lean.to_netcdf(tmp_path / "lean.nc")
    config.write_text(config.read_text().replace("mesh: box.nc", "mesh: lean.nc"))
    bodystudy.run(config, tmp_path / "out", green_folder)
    clean, repaired = load(tmp_path / "clean/box.nc"), load(tmp_path / "out/box.nc")
    assert repaired.attrs["history"] == f"panels without area dropped: 2 of {len(faces)}; {clean.attrs['history']}"
    assert np.array_equal(repaired.added_mass, clean.added_mass)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"omega": []}, "needs at least one value"),
        ({"omega": [2.0, 1.0]}, "ascending without repetition"),
        ({"wave_direction": [0.0, 0.0]}, "ascending without repetition"),
        ({"omega": [0.05], "water": {"depth": 10.0}}, "omega 0.05 rad/s: in 10 m of water needs at least"),
        (
            {"omega": [3.0], "water": {"depth": 0.9}},
            "water.depth: received 0.9 m, needs more than the body's draught of 2 m",
        ),
        ({"symmetry": "xyz"}, "symmetry"),
        ({"lid": True}, "a number is needed"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"omega": [1e-300]}, "omega.0: received 1e-300; needs a number of at least 0.001"),
        ({"omega": [1e300]}, "omega.0: received 1e[+]300; needs a number of at most 1000"),
        ({"omega": [1.0, 400.0]}, "omega: received 400 rad/s, whose waves are 0.000385 m long and the largest panel"),
        ({"wave_direction": [1e300]}, "wave_direction.0: received 1e[+]300; needs a number of at most 360"),
        ({"mode": "x.nc"}, "unknown key"),
        ({"mesh": "gone.vtu"}, "gone.vtu: mesh not found"),
    ],
)
def test_a_wrong_body_file_is_refused_in_one_line(tmp_path, body, changes, message):
    with pytest.raises(ConfigError, match=message) as error:
        bodystudy.run(files(tmp_path, body, **changes), tmp_path / "out")
    assert "\n" not in str(error.value)
    assert not (tmp_path / "out").exists()


def test_what_is_no_yaml_file_is_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"gone.yaml: cannot be read"):
        bodystudy.read_config(tmp_path / "gone.yaml", BodyFile)
    (tmp_path / "bad.yaml").write_text("a: [1\n")
    with pytest.raises(ConfigError, match=r"bad.yaml:2: not valid YAML"):
        bodystudy.read_config(tmp_path / "bad.yaml", BodyFile)


def test_a_symmetry_declared_but_missing_is_refused_before_anything_is_solved(tmp_path, body):
    moved = made(body.vertices + np.array([0.2, 0.0, 0.0]), body.faces, body.shapes, LABELS)
    with pytest.raises(ConfigError, match="not mirrored in the yOz plane"):
        bodystudy.run(files(tmp_path, moved, symmetry="xOz+yOz"), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_the_table_of_the_green_function_is_made_whole_or_not_at_all(tmp_path, monkeypatch):
    made_at, faster = [], []

    def table(folder):
        made_at.append(Path(folder))
        Path(folder).mkdir(parents=True, exist_ok=True)
        (Path(folder) / "table").write_text(str(len(made_at)))
        for other in faster:
            other.mkdir()
            (other / "table").write_text("of another run")
            faster.clear()

    monkeypatch.setattr(bodystudy.bem, "green_function", table)
    (tmp_path / ".green.dead").mkdir()  # of a run that was killed
    bodystudy.bem.stored_green_function(tmp_path / "green")
    assert made_at[0].parent == tmp_path
    assert made_at[1:] == [tmp_path / "green"]
    assert (tmp_path / "green").stat().st_mode & 0o777 == 0o755  # a temporary folder is its owner's alone
    (tmp_path / "file").touch()
    with pytest.raises(NotADirectoryError):
        bodystudy.bem.stored_green_function(tmp_path / "file")
    assert made_at.pop().parent == tmp_path
    (tmp_path / "file").unlink()
    bodystudy.bem.stored_green_function(tmp_path / "green")
    assert made_at[2:] == [tmp_path / "green"]
    faster.append(tmp_path / "late")
    bodystudy.bem.stored_green_function(tmp_path / "late")
    assert sorted(path.name for path in tmp_path.iterdir()) == [".green.dead", "green", "late"]


@pytest.mark.parametrize(("depth", "gravity"), [(np.inf, 9.81), (30.0, 4.0)])
def test_a_panel_may_hold_four_wavelengths_and_no_more(body, depth, gravity):
    """Of panels of equal sides 2 sqrt(2) m across; lambda = 2 pi g/omega^2 in water so deep. The highest wave counts."""
    across = max(np.linalg.norm(corners[2] - corners[0]) for corners in body.vertices[body.faces])
    limit = np.sqrt(2 * np.pi * gravity * 4.0 / across)

    def asked(highest):
        water = {"depth": depth, "gravity": gravity}
        given = {"body": "box", "mesh": "-", "modes": "-", "omega": (1.0, highest), "wave_direction": (0.0,)}
        bodystudy._check_wavelengths(BodyFile(**given, water=water), body)

    asked(limit * (1 - 1e-9))
    length = 2 * np.pi * gravity / (1.01 * limit) ** 2
    told = (
        f"omega: received {1.01 * limit:g} rad/s, whose waves are {length:.3g} m long and the largest panel {across:.3g} "
        f"m; needs at most {limit:.3g} rad/s: smaller panels or lower frequencies"
    )
    with pytest.raises(ConfigError) as error:
        asked(1.01 * limit)
    assert str(error.value) == told
    with pytest.raises(ConfigError, match="smaller panels or lower frequencies"):
        asked(limit * (1 + 1e-9))


@pytest.mark.parametrize("tables", [None, "tables"])
def test_a_run_hands_on_its_table_and_finds_mesh_and_modes_beside_its_file(tmp_path, monkeypatch, tables):
    seen = []
    monkeypatch.setattr(bodystudy, "read_body", lambda mesh, modes, gravity: (mesh, modes))
    monkeypatch.setattr(bodystudy, "solve", lambda study, *given: seen.append((study.body, *given)))
    raw = {"body": "b", "mesh": "a/m.gdf", "modes": "modes.nc", "omega": [1.0], "wave_direction": [0.0]}
    (tmp_path / "b.yaml").write_text(yaml.safe_dump(raw))
    bodystudy.run(tmp_path / "b.yaml", "out", tables)
    assert seen == [("b", (tmp_path / "a/m.gdf", tmp_path / "modes.nc"), "out", tables)]


@pytest.mark.parametrize("depth", [2.0, 1.9])
def test_water_is_deeper_than_the_draught(body, depth):
    given = {"body": "b", "mesh": "-", "modes": "-", "omega": (2.0,), "wave_direction": (0.0,)}
    bodystudy.check_solvable(BodyFile(**given, water={"depth": 2.001}), body)
    with pytest.raises(ConfigError) as error:
        bodystudy.check_solvable(BodyFile(**given, water={"depth": depth}), body)
    assert str(error.value) == f"water.depth: received {depth:g} m, needs more than the body's draught of 2 m"


def test_water_is_deeper_than_the_keel_of_a_body_all_of_which_is_below_it(body):
    """Four metres high, its top a metre below the surface."""
    given = {"body": "b", "mesh": "-", "modes": "-", "omega": (2.0,), "wave_direction": (0.0,), "lid": 0}
    mirror = np.array([1.0, 1.0, -1.0])
    vertices, faces = joined([(body.vertices, body.faces), (mirror * body.vertices, body.faces[:, ::-1])])
    sunk = made(vertices - [0.0, 0.0, 3.0], faces, rigid(vertices)[2:3])
    bodystudy.check_solvable(BodyFile(**given, water={"depth": 5.001}), sunk)
    with pytest.raises(ConfigError, match=r"received 5 m, needs more than the body's draught of 5 m"):
        bodystudy.check_solvable(BodyFile(**given, water={"depth": 5.0}), sunk)


def test_identities_are_measured_by_the_impedances_of_both_motions_or_the_least_there_is(body):
    """Pitch next to none: its impedance is that of its least size; of two directions the worse one counts."""
    omega, water = 2.0, Water(density=1010.0, depth=12.0)
    one = made(body.vertices, body.faces, body.shapes[:2], LABELS[:2])
    least = 0.3 * np.sqrt(1010.0 * one.volume * (one.modes**2).sum(axis=2).mean(axis=1))
    a, b = np.array([[5e4, 3e2], [-2e2, 1e-3]]), np.array([[8e3, -4e2], [1e3, -1e-3]])
    far, x = np.array([[9e3, -1e2], [2e3, 5.0]]), np.array([[3e4 + 1e3j, 2e2j], [1e4 - 4e3j, 7e2]])
    haskind = x + np.array([[40.0, -3.0j], [20.0 + 9.0j, 1.0]])
    pair, wave = ("omega", "influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
    ds = xr.Dataset(
        {
            "added_mass": (pair, a[None]), "radiation_damping": (pair, b[None]), "far_field_damping": (pair, far[None]),
            "Froude_Krylov_force": (wave, 0.3 * x[None]), "diffraction_force": (wave, 0.7 * x[None]),
            "haskind_force": (wave, haskind[None]),
        },
        {"omega": [omega]},
    )  # fmt: skip
    z = [abs(b[0, 0] + 2j * a[0, 0]), omega * least[1] ** 2]
    both = np.sqrt(z[0] * z[1])
    k, v = (f(omega, 12.0, water.gravity) for f in (wavenumber, group_velocity))
    wave = np.sqrt(4 * 1010.0 * water.gravity * v / k * np.array(z))
    expected = {
        "symmetry": np.hypot(1.4e3, omega * 5e2) / both,
        "far_field": max(1e3 / z[0], 1e3 / both, 3e2 / both, 5.001 / z[1]),
        "haskind": max(40.0 / wave[0], abs(20 + 9j) / wave[0], 3.0 / wave[1], 1.0 / wave[1]),
    }
    assert abs(b[1, 1] + 2j * a[1, 1]) < z[1]
    assert bodystudy.identities(ds, SimpleNamespace(body=one, water=water)) == pytest.approx(expected, rel=1e-9)


ORDER = [
    "error_estimate", "interpolation_error", "one_resolution", "symmetry", "far_field", "haskind", "positive_damping",
    "panels", "modes", "corners", "rigid_names", "second_order", "afloat",
]  # fmt: skip


def test_the_verdict_is_on_the_worst_frequency_of_each_identity(body, monkeypatch):
    """First, between and last."""
    monkeypatch.setattr(bodystudy, "error_estimate", lambda *_: 0.0)
    monkeypatch.setattr(bodystudy.quality, "negative_damping", lambda *_: 0.0)
    rows = [(0.3, 0.01, 0.02), (0.1, 0.4, 0.03), (0.2, 0.05, 0.5)]
    solved = [
        SimpleNamespace(own=SimpleNamespace(attrs=dict(zip(("symmetry", "far_field", "haskind"), row, strict=True))))
        for row in rows
    ]
    infinite = SimpleNamespace(own=SimpleNamespace(attrs={"coarser_share": 0.8}))
    swept = SimpleNamespace(solved=solved, coefficients="coefficients", error=0.0)
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[0.0])
    found = {check.name: check.value for check in bodystudy.verdict(file, body, infinite, swept, np.ones(3))}
    assert [found[name] for name in ("symmetry", "far_field", "haskind")] == [0.3, 0.4, 0.5]
    assert list(found) == [name for name in ORDER if name != "interpolation_error"]
    asked = file.model_copy(update={"tolerance": 0.01})
    assert [check.name for check in bodystudy.verdict(asked, body, infinite, swept, np.ones(3))] == ORDER
    seen = []
    monkeypatch.setattr(bodystudy, "error_estimate", lambda *given: seen.append(given) or 0.03)
    monkeypatch.setattr(bodystudy.quality, "negative_damping", lambda *given: seen.append(given) or 0.004)
    size = np.array([1.0, 2.0, 3.0])
    found = {check.name: check.value for check in bodystudy.verdict(file, body, infinite, swept, size)}
    assert (found["error_estimate"], found["positive_damping"]) == (0.03, 0.004)
    (blocks, limit, its), (coefficients, pair) = seen
    assert (blocks, coefficients) == (solved, swept.coefficients)
    assert limit is infinite
    assert its is size
    assert pair.tolist() == np.outer(size, size).tolist()
    assert found["one_resolution"] == pytest.approx(0.2)


@pytest.mark.parametrize("part", [0, 1])
def test_displacements_of_panels_agree_with_corners_in_terms_of_each_of_them(body, part):
    """A mode of a thousandth that is off by a fifth of itself, before and behind a large one that is not."""
    modes = np.stack([1e3 * body.modes[0], body.modes[0]])[:: 1 - 2 * part]
    shapes = np.stack([1e3 * body.shapes[0], body.shapes[0]])[:: 1 - 2 * part]
    modes[1 - part] *= 0.8
    one = made(body.vertices, body.faces, shapes, ("A", "B"), modes=modes)
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[0.0])
    found = {check.name: check.value for check in bodystudy.mesh_checks(file, one)}
    assert found["corners"] == pytest.approx(0.25)


def test_what_heaves_and_turns_at_once_has_no_mass_afloat(body):
    file = BodyFile(body="b", mesh="b.nc", modes="b.nc", omega=[1.0], wave_direction=[0.0])
    for turn in (1.0, -1e-3):
        shapes = np.stack([body.shapes[0] + turn * body.shapes[1], body.shapes[2]])
        one = made(body.vertices, body.faces, shapes, ("A", "B"), mass=np.eye(2))
        assert "afloat" not in {check.name for check in bodystudy.mesh_checks(file, one)}


def test_the_longest_panel_is_told_in_the_shortest_waves(body):
    """In shallow water the waves of one frequency are shorter."""
    across = max(np.linalg.norm(corners[2] - corners[0]) for corners in body.vertices[body.faces])
    for depth in (np.inf, 3.0):
        file = BodyFile(
            body="b", mesh="b.nc", modes="b.nc", omega=[0.8, 1.2], wave_direction=[0.0], water={"depth": depth}
        )
        found = {check.name: check.value for check in bodystudy.mesh_checks(file, body)}
        assert found["panels"] == pytest.approx(across * wavenumber(1.2, depth, 9.81) / (2 * np.pi), rel=1e-9)


def test_the_centre_of_buoyancy_of_a_body_off_the_origin(body):
    vertices = body.vertices + np.array([3.0, -2.0, 0.0])
    wedge = vertices.copy()
    wedge[:, 1] += 0.5 * vertices[:, 2]  # sheared: its centre moves by half a metre to the side
    facts = bodystudy._at_rest(made(wedge, body.faces, rigid(wedge)[[2]], ("Heave",)))
    assert facts["centre_of_buoyancy"] == pytest.approx([3.0, -2.5, -1.0], abs=1e-9)
    assert facts["displaced_volume"] == pytest.approx(48.0)


@pytest.mark.parametrize(("lid", "symmetry", "used"), [(0, "auto", "xOz+yOz"), (3, "yOz", "yOz"), (2, "none", "none")])
def test_blocks_are_solved_with_the_lid_and_symmetry_asked_for(tmp_path, body, monkeypatch, lid, symmetry, used):
    asked = []

    def blocks_of(*arguments):
        asked.append(arguments)
        raise InterruptedError

    monkeypatch.setattr(bodystudy, "Blocks", blocks_of)
    given = {"body": "b", "mesh": "b.nc", "modes": "b.nc", "omega": [3.0], "wave_direction": [0.0]}
    file = BodyFile(**given, lid=lid, symmetry=symmetry)
    with pytest.raises(InterruptedError):
        bodystudy.solved(file, body, tmp_path, "tables")
    ((study, same, planes, found, folder, _),) = asked
    assert (study, planes, folder) == (file, used, tmp_path / "blocks")
    assert same is body
    if not lid:
        assert found is None
        return
    vertices, faces = bodystudy.interior_lid(body, lid)
    assert found[0].tolist() == vertices.tolist()
    assert found[1].tolist() == faces.tolist()


def test_centres_of_mass_of_several_parts_are_none_of_the_whole(body):
    vertices, faces = joined([(body.vertices, body.faces), (body.vertices + np.array([9.0, 0.0, 0.0]), body.faces)])
    shapes = rigid(vertices)[2:3]
    centres = np.array([[0.0, 0.0, -0.5], [9.0, 0.0, -0.4]])
    assert "centre_of_mass" not in bodystudy._at_rest(made(vertices, faces, shapes, centre_of_mass=centres))
    found = bodystudy._at_rest(made(vertices, faces, shapes, centre_of_mass=centres[0]))
    assert found["centre_of_mass"].tolist() == [0.0, 0.0, -0.5]
    assert found["centre_of_buoyancy"] == pytest.approx([4.5, 0.0, -1.0], abs=1e-9)


@pytest.mark.parametrize("given", [(), ("mass",), ("stiffness",), ("mass", "stiffness")])
def test_a_database_holds_the_matrices_its_body_has(body, given):
    """And what the blocks took, the one at infinity among them, in their order."""
    matrices = {"mass": np.diag([1.0, 2.0, 3.0]), "stiffness": np.diag([4.0, 5.0, 6.0])}
    one = replace(body, **{name: matrices[name] if name in given else None for name in matrices})
    dof = {"influenced_dof": list(LABELS), "radiating_dof": list(LABELS)}
    pair, wave = ("omega", *dof), ("omega", "wave_direction", "influenced_dof")
    even = np.array([[3.0, 0.5, 0.0], [0.5, 2.0, 0.1], [0.0, 0.1, 1.0]])
    data = {name: (pair, np.stack([even, 2 * even])) for name in ("added_mass", "radiation_damping")}
    data |= {name: (wave, np.ones((2, 1, 3), complex)) for name in ("Froude_Krylov_force", "diffraction_force")}
    coefficients = xr.Dataset(data, {"omega": [1.0, 1.3], "wave_direction": [0.0], **dof})
    infinite = xr.Dataset({"added_mass_inf": (pair[1:], 7 * even)}, dof, {"spec_id": "inf", "seconds": 4.0})
    solved = [
        SimpleNamespace(own=SimpleNamespace(attrs={"spec_id": name, "seconds": s, "resolution_ratio": 1.0}))
        for name, s in (("a", 1.0), ("b", 2.5))
    ]
    file = BodyFile(body="b", mesh="-", modes="-", omega=[1.0, 1.1, 1.3], water={"density": 1010.0, "depth": 30.0})
    found = bodystudy._database(
        file, one, "yOz", SimpleNamespace(own=infinite), SimpleNamespace(coefficients=coefficients, solved=solved), []
    )
    names = {"mass": "inertia_matrix", "stiffness": "structural_stiffness"}
    for name, held in names.items():
        assert (held in found) == (name in given)
        assert held not in found or found[held].values.tolist() == matrices[name].tolist()
    assert json.loads(found.attrs["spec"])["blocks"] == ["inf", "a", "b"]
    told = {"bem_seconds": 7.5, "solves": 2, "frequencies": 3, "symmetry": "yOz", "water_depth": "30.0"}
    assert {name: found.attrs[name] for name in told} == told
    assert found.added_mass_inf.values == pytest.approx(7 * even)
    assert float(found.hydrostatic_stiffness[0, 0]) == pytest.approx(1010.0 * 9.81 * 24.0)


def one_frequency(scale, body, omega=1.3):
    """Coefficients of a body in two directions as a solver returns them, each variable another number."""
    dof = {"influenced_dof": list(body.labels), "radiating_dof": list(body.labels)}
    pair, wave = ("omega", *dof), ("omega", "wave_direction", "influenced_dof")
    n = len(body.labels)
    matrices = {"added_mass": 1.0, "radiation_damping": 2.0, "far_field_damping": 3.0}
    forces = {"Froude_Krylov_force": 4.0, "diffraction_force": 5.0j, "haskind_force": 6.0}
    data = {name: (pair, np.full((1, n, n), scale * value)) for name, value in matrices.items()}
    data |= {name: (wave, np.full((1, 2, n), scale * value + 0j)) for name, value in forces.items()}
    return xr.Dataset(data, {"omega": [omega], "wave_direction": [0.0, 0.5], **dof})


class Solver:
    """What is asked of a body in waves, answered by one number."""

    def __init__(self, scale, body):
        self.scale, self.body, self.asked = scale, body, []

    def at_infinity(self):
        return xr.Dataset({"added_mass_inf": (("i", "j"), [[7.0 * self.scale]])})

    def solve(self, omega, directions):
        self.asked.append((omega, directions.tolist()))
        return one_frequency(self.scale, self.body, omega)


@pytest.mark.parametrize("omega", [1.3, np.inf])
def test_a_block_holds_coefficients_those_on_fewer_panels_and_what_its_own_waves_say(body, monkeypatch, omega):
    coarse, share = coarser_body(body, ("xOz", "yOz"))
    own, fewer = Solver(1.0, body), Solver(10.0, coarse)
    monkeypatch.setattr(
        bodystudy,
        "identities",
        lambda ds, problem: {"symmetry": ds.added_mass.values.max(), "far_field": problem.scale},
    )
    spec = {"omega": omega, "wave_direction": [0.0, 90.0]}
    found = bodystudy._block(own, fewer, share, spec)
    told = {
        "resolution_ratio": panel_size(coarse) / panel_size(body),
        "coarser_share": share,
        "spec_id": content_id(spec),
    }
    assert {name: found.own.attrs[name] for name in told} == told
    assert told["resolution_ratio"] > 1.2
    assert json.loads(found.own.attrs["spec"])["wave_direction"] == [0.0, 90.0]
    assert found.own.attrs["seconds"] >= 0
    if np.isinf(omega):
        assert (float(found.own.added_mass_inf[0, 0]), float(found.fewer.added_mass_inf[0, 0])) == (7.0, 70.0)
        assert len(found.waves.variables) == 0
        assert "symmetry" not in found.own.attrs
        return
    assert own.asked == fewer.asked == [(1.3, [0.0, pytest.approx(np.pi / 2)])]
    assert (found.own.attrs["symmetry"], found.own.attrs["far_field"]) == (1.0, 1.0)
    values = [{name: complex(v.values.flat[0]) for name, v in ds.data_vars.items()} for ds in found]
    assert values == [
        {"added_mass": 1.0, "radiation_damping": 2.0, "Froude_Krylov_force": 4.0, "diffraction_force": 5.0j},
        {"added_mass": 10.0, "radiation_damping": 20.0, "excitation_force": 40.0 + 50.0j},
        {"radiation_damping": 3.0, "excitation_force": 6.0},
    ]


def test_blocks_are_of_the_body_its_water_its_symmetry_and_its_lid(tmp_path, body, monkeypatch):
    """Each is solved once, on its own panels and on fewer, under the name of what it is solved from."""
    monkeypatch.setattr(bodystudy.bem, "stored_green_function", lambda table: f"table in {table}")
    file = BodyFile(body="b", mesh="-", modes="-", omega=[1.0], lid=2, water={"density": 1010.0, "depth": 30.0})
    lid, solved = bodystudy.interior_lid(body, 2), []

    def block(problem, fewer, share, spec):
        solved.append((problem, fewer, share, spec["omega"]))
        parts = [one_frequency(k, body)[["added_mass"]] for k in (1.0, 2.0, 3.0)]
        return bodystudy.Block(parts[0].assign_attrs(spec_id=content_id(spec)), *parts[1:])

    monkeypatch.setattr(bodystudy, "_block", block)
    blocks = bodystudy.Blocks(file, body, "xOz", lid, tmp_path / "blocks", "green")
    for omega in (1.0, 1.5, 1.0):
        found = blocks(omega)
        assert [float(ds.added_mass.values.flat[0]) for ds in found] == [1.0, 2.0, 3.0]
    assert blocks(1.0) is found
    again = bodystudy.Blocks(file, body, "none", lid, tmp_path / "blocks", "green")
    assert [float(ds.added_mass.values.flat[0]) for ds in again(1.5)] == [1.0, 2.0, 3.0]
    assert [each[-1] for each in solved] == [1.0, 1.5]
    names = {path.stem for path in (tmp_path / "blocks").glob("*.nc")}
    assert names == {content_id(bodystudy._spec(file, body, omega, 2)) for omega in (1.0, 1.5)}
    problem, fewer, share, _ = solved[0]
    assert (problem.green, problem.water, problem.symmetry) == ("table in green", file.water, "xOz")
    assert problem.body is body
    assert problem.lid is lid
    expected, part = problem.coarser()
    assert share == part
    assert fewer.body.faces.tolist() == expected.body.faces.tolist()
    assert len(fewer.body.faces) < len(body.faces)


def test_a_body_is_swept_in_the_directions_and_to_the_tolerance_asked_for(tmp_path, body, monkeypatch):
    seen = {}
    infinite = bodystudy.Block(xr.Dataset({"added_mass_inf": (("i", "j"), np.diag([4e6, 1.0, 9e6]))}), None, None)

    class Blocks:
        def __init__(self, *_):
            self.problem = SimpleNamespace(froude_krylov=lambda omegas, directions: (omegas, directions.tolist()))

        def __call__(self, omega):
            assert omega == np.inf
            return infinite

    def swept(blocks, froude_krylov, omega, tolerance, measure):
        seen["swept"] = (froude_krylov("omegas"), omega, tolerance, measure)
        return "found"

    monkeypatch.setattr(bodystudy, "Blocks", Blocks)
    monkeypatch.setattr(bodystudy, "swept", swept)
    monkeypatch.setattr(bodystudy, "verdict", lambda *given: seen.update(verdict=given) or "checks")
    monkeypatch.setattr(bodystudy, "_database", lambda *given: seen.update(database=given) or "database")
    file = BodyFile(
        body="b", mesh="-", modes="-", omega=[1.0, 1.5], wave_direction=[0.0, 90.0], lid=0, tolerance=0.02,
        water={"density": 1010.0, "depth": 30.0}, symmetry="xOz",
    )  # fmt: skip
    assert bodystudy.solved(file, body, tmp_path) == ("database", "checks")
    (omegas, directions), omega, tolerance, measure = seen["swept"]
    assert (omegas, omega, tolerance) == ("omegas", (1.0, 1.5), 0.02)
    assert directions == measure.directions.tolist() == [0.0, pytest.approx(np.pi / 2)]
    least = 0.3 * np.sqrt(1010.0 * body.volume * (body.modes[1] ** 2).sum(axis=1).mean())
    assert measure.size == pytest.approx([2e3, max(1.0, least), 3e3])
    assert measure.water == file.water
    study, one, given, found, size = seen["verdict"]
    assert (study, found) == (file, "found")
    assert one is body
    assert given is infinite
    assert size.tolist() == measure.size.tolist()
    assert seen["database"] == (file, body, "xOz", infinite, "found", "checks")
