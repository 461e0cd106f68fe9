"""Rigid and generalized modes in WAMIT's and BEMIO's forms, verdicts on numbers of others, and the commands."""

import json

import numpy as np
import pytest
import xarray as xr

from examples import barge
from vsb.cli import main
from vsb.engine.hydro.bodies import solution as bodystudy
from vsb.engine.hydro.bodies.body_file import BodyFile
from vsb.engine.hydro.formats.bemio import bemio_entries
from vsb.engine.hydro.formats.common import RIGID, body_names, floating, mode_labels, mode_numbers, rotations, structure
from vsb.engine.hydro.formats.exchange import exported
from vsb.engine.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.engine.waves.water import group_velocity, wavenumber
from vsb.errors import DatabaseError
from vsb.tools import files, variables

PAIR, WAVE = ("influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
RHO, G = 1000.0, 9.81
FACTS = {"displaced_volume": 4000.0, "centre_of_buoyancy": [0.0, 0.0, -2.5], "centre_of_mass": [0.0, 0.0, 0.5]}
FACTS["rotation_centre"] = FACTS["centre_of_mass"]
LABELS = ("Pitch", "Heave", "Bend", "Surge")  # in no order


def flexible(labels=LABELS, headings=(0.0,), *, omega=(0.5, 1.0, 1.5), dry=True, seed=0):
    """A database of random coefficients, damping that of its excitation if the headings are many."""
    rng, n = np.random.default_rng(seed), len(labels)
    omega, headings = np.array(omega), np.radians(headings)
    directions = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    shape = rng.normal(size=(3, len(omega), n)) + 1j * rng.normal(size=(3, len(omega), n))

    def wave(beta):
        return np.einsum("mwi,mb->wbi", shape, [np.ones_like(beta), np.cos(beta), np.sin(2 * beta)]) * 1e5

    factor = np.array([wavenumber(w, np.inf, G) / (4 * RHO * G * group_velocity(w, np.inf, G)) for w in omega])
    x = wave(directions)
    damping = np.einsum("w,wbi,wbj->wij", factor, x, x.conj()).real / 16
    added = rng.normal(size=(len(omega), n, n)) * 1e3
    stiffness = rng.normal(size=(n, n)) * 1e6
    stiffness[[label == "Heave" for label in labels]] *= 0.0  # no waterplane: nothing to be said of long waves
    data = {
        "added_mass": (("omega", *PAIR), added + added.transpose(0, 2, 1) + 2e4 * np.eye(n)),
        "radiation_damping": (("omega", *PAIR), damping),
        "added_mass_inf": (PAIR, 1e4 * np.eye(n)),
        "excitation_force": (WAVE, wave(headings)),
        "hydrostatic_stiffness": (PAIR, stiffness),
    }
    if dry:
        data |= {"inertia_matrix": (PAIR, np.diag(1e6 * np.arange(1.0, n + 1)))}
        data |= {"structural_stiffness": (PAIR, np.diag(np.where(np.isin(labels, RIGID), 0.0, 5e7)))}
        data |= {"structural_damping_matrix": (PAIR, np.diag(np.where(np.isin(labels, RIGID), 0.0, 3e4)))}
    attrs = {"water_density": RHO, "gravity": G, "water_depth": "inf", "separate_sweep": 0, "spec_id": "x", **FACTS}
    coords = {"omega": omega, "wave_direction": headings, **{dof: list(labels) for dof in PAIR}}
    return variables.described(xr.Dataset(data, coords, attrs))


def written(folder, texts):
    for extension, text in texts.items():
        (folder / f"barge{extension}").write_text(text)
    return folder


def read(folder, **facts):
    return import_wamit(folder, "barge", **{"density": RHO, "gravity": G, **facts})


def rows(text):
    """Values by mode numbers of a file of pairs."""
    lines = [line.split() for line in text.splitlines()[1:]]
    return {tuple(map(int, line[:2])): float(line[2]) for line in lines}


def test_mode_numbers_and_labels():
    assert mode_numbers(RIGID) == [1, 2, 3, 4, 5, 6]
    assert mode_numbers(["Heave", "Pitch", "Bending1", "Bending2"]) == [3, 5, 7, 8]
    assert mode_numbers(["Bend", "Yaw", "Twist", "Surge"]) == [7, 6, 8, 1]
    assert mode_numbers(["Twist", "Yaw", "Bend", "Surge", "Arch"]) == [7, 6, 8, 1, 9]  # as they stand
    assert mode_labels([1, 3, 5, 7, 12]) == ["Surge", "Heave", "Pitch", "Mode7", "Mode12"]
    assert rotations([1, 3, 4, 5, 6, 7]).tolist() == [0, 0, 1, 1, 1, 0]
    assert body_names(["float", "spar_1"]) == ["float", "spar_1"]
    assert body_names(["float"]) == [""]
    for names in (["float", "float"], ["float", ""], ["a__b", "c"]):
        assert body_names(names) == ["body1", "body2"]
    for labels in ([], ["Heave", "Bend", "Bend"]):
        with pytest.raises(DatabaseError, match="needs at least one, and none twice"):
            mode_numbers(labels)


def test_ulen_enters_once_more_for_every_rotation():
    """ULEN = 2: WAMIT's k = 3, 4, 5 for mass and damping, 2, 3, 4 for stiffness, 2 and 3 for excitation."""
    ds = flexible()
    one, two = (wamit_texts(ds, "memory", length) for length in (1.0, 2.0))
    power = {3: 0, 5: 1, 7: 0, 1: 0}
    stiffness, half = rows(one[".hst"]), rows(two[".hst"])
    assert stiffness == {
        pair: pytest.approx(half[pair] * 2.0 ** (2 + power[pair[0]] + power[pair[1]]), rel=2e-6) for pair in half
    }
    for line, other in zip(one[".1"].splitlines()[1:], two[".1"].splitlines()[1:], strict=True):
        (start, i, j, *a), (_, _, _, *b) = (list(map(float, text.split())) for text in (line, other))
        assert a == pytest.approx(np.array(b) * 2.0 ** (3 + power[i] + power[j]), rel=2e-6), (start, i, j)
    for line, other in zip(one[".3"].splitlines()[1:], two[".3"].splitlines()[1:], strict=True):
        a, b = (list(map(float, text.split())) for text in (line, other))
        assert np.array(a)[[3, 5, 6]] == pytest.approx(np.array(b)[[3, 5, 6]] * 2.0 ** (2 + power[a[2]]), rel=2e-6)
        assert a[4] == pytest.approx(b[4])
    assert stiffness[(5, 7)] * RHO * G == pytest.approx(ds.hydrostatic_stiffness.values[0, 2], rel=1e-6)
    assert one[".mmx"].partition("matrices")[2] == two[".mmx"].partition("matrices")[2]
    assert {text.partition(" density")[0] for text in two.values()} == {" WAMIT's form: ULEN 2"}
    assert "modes 1=Surge 3=Heave 5=Pitch 7=Bend" in two[".1"]
    firsts = [line.split()[1] for line in two[".1"].splitlines()[1:]]
    assert firsts == 4 * [mode for mode in "1357" for _ in range(4)]  # infinite frequency and three periods


def test_wamit_files_are_read_back(tmp_path):
    ds = flexible(headings=(-30.0, 0.0, 90.0))
    back = read(
        written(tmp_path, wamit_texts(ds, "memory", 2.0)), length=2.0, labels=["Surge", "Heave", "Pitch", "Bend"]
    )
    assert set(back.data_vars) == set(ds.data_vars)
    for name in ds.data_vars:
        order = {dof: list(LABELS) for dof in PAIR if dof in ds[name].dims}
        assert back[name].sel(order).values == pytest.approx(ds[name].values, rel=2e-6)
    for name, value in FACTS.items():
        assert back.attrs[name] == pytest.approx(value)


MMX = """ WAMIT -- Force Output File -- barge.mmx                  15-Mar-2017  19:33:35

 Gravity:     9.81000                Length scale:        1.00000

 NBODY =     1       IALTFRC = 2

 WAMIT  Ouputs for body N =     1    IALTFRCN = 2
 Volumes (VOLX,VOLY,VOLZ):           4000.01      4000.00     0.399999E+04
 Center of Buoyancy (Xb,Yb,Zb):     0.000000     0.000000    -2.500000
 Center of Gravity:  (Xg,Yg,Zg)     0.000000     0.000000     0.500000

 External force matrices:
     I     J      MASS(I,J)      DAMP(I,C)      STIF(I,J)
     3     3   4.000000E+06   0.000000E+00   0.000000E+00
     3     7   0.000000E+00   0.000000E+00   0.000000E+00
     7     3   0.000000E+00   0.000000E+00   0.000000E+00
     7     7   1.079216E+06   2.000000E+04   6.077064E+06
"""


@pytest.fixture
def foreign(tmp_path):
    """Heave and one mode of another code, with its own .mmx file."""
    texts = wamit_texts(flexible(["Heave", "Bend"], dry=False), "memory")
    assert ".mmx" not in texts
    return written(tmp_path, {**texts, ".mmx": MMX})


def test_mmx_file_of_wamit_is_read(foreign):
    ds = read(foreign)
    assert ds.inertia_matrix.values.tolist() == [[4e6, 0.0], [0.0, 1.079216e6]]
    assert ds.structural_damping_matrix.values.tolist() == [[0.0, 0.0], [0.0, 2e4]]
    assert ds.structural_stiffness.values.tolist() == [[0.0, 0.0], [0.0, 6.077064e6]]
    own = FACTS | {"rotation_centre": [0.0, 0.0, 0.0]}  # of the axes WAMIT's centres are in
    assert {name: np.asarray(ds.attrs[name]).tolist() for name in own} == own
    assert bemio_entries(ds, "memory")["/body1/properties/stiffness"][6, 6] == 6.077064e6


# --- commands

CIRCLE = tuple(np.arange(0.0, 360.0, 30.0))


@pytest.fixture(scope="module")
def solved(tmp_path_factory, green_folder):
    """A barge of few panels in waves from all around."""
    folder = tmp_path_factory.mktemp("barge")
    one = barge.Barge(length=20.0, beam=8.0, draught=3.0, centre_of_mass=-0.5, bending_stiffness=1e9, modes=2)
    study = BodyFile(body="barge", mesh="", modes="", omega=(0.8, 1.1), wave_direction=CIRCLE, lid=0)
    bodystudy.solve(study, one.body(1, study.water.density), folder, green_folder)
    return folder / "barge.nc"


def test_solved_barge_is_exported_and_imported_in_both_formats(solved, tmp_path, capsys):
    """Solved by capytaine; exported by file, read back by commands, judged by Haskind over all headings."""
    ds = files.load(solved)
    assert main(["export", str(solved), str(tmp_path)]) == 0
    names = [f"barge{end}" for end in (".1", ".3", ".3fk", ".3sc", ".hst", ".mmx", ".h5")]
    zero = f"{tmp_path}/barge.1: without lines PER = -1, whose added mass {solved} does not hold"
    assert capsys.readouterr().out.splitlines() == [*(str(tmp_path / name) for name in names), zero]
    assert main(["import-wamit", str(tmp_path), "barge", str(tmp_path / "w.nc")]) == 0
    assert main(["import-bemio", str(tmp_path / "barge.h5"), str(tmp_path / "b.nc")]) == 0
    out = capsys.readouterr().out
    assert out.count("ok           haskind = ") == 2
    for name, labels, error in (
        ("w", ["Heave", "Pitch", "Bending1", "Bending2"], 1e-6),
        ("b", ["Heave", "Pitch", "Bending1", "Bending2"], 1e-12),
    ):
        back = files.load(tmp_path / f"{name}.nc")
        assert back.influenced_dof.values.tolist() == labels
        kept = [n for n in ds.data_vars if not n.endswith("_error") and "outline" not in n]  # no such file holds these
        assert set(back.data_vars) == {*kept, "structural_damping_matrix"}
        for key in kept:
            assert back[key].values == pytest.approx(
                ds[key].values, rel=error, abs=1e-9 * np.abs(ds[key].values).max()
            ), key
        again = exported(tmp_path / f"{name}.nc", tmp_path / name, "barge")[: len(names)]
        assert again == [str(tmp_path / name / each) for each in names]


def test_wrong_ulen_fails_the_import(solved, tmp_path, capsys):
    for ending, text in wamit_texts(files.load(solved), "barge", 2.0).items():
        if ending != ".mmx":  # which would say so
            (tmp_path / f"barge{ending}").write_text(text)
    assert main(["import-wamit", str(tmp_path), "barge", str(tmp_path / "w.nc")]) == 1
    out = capsys.readouterr().out
    assert "fail         haskind" in out
    assert "look at haskind: --depth not HBOT; --length not ULEN; --gravity not GRAV; PER not a column" in out
    assert "fail" in files.load(tmp_path / "w.nc").attrs["quality"]
    assert main(["import-wamit", str(tmp_path), "barge", str(tmp_path / "w.nc"), "--length", "2"]) == 0


@pytest.mark.parametrize("height", [-0.9, 0.7])
def test_centre_of_buoyancy_of_a_spherical_cap(height):
    """By slices; the mass lies in its middle."""
    ds = flexible().drop_attrs().assign_attrs(water_density=RHO, gravity=G, water_depth="inf", radius=2.0)
    found = floating(ds.assign_attrs(centre_height=height), "memory")
    z = np.linspace(height - 2.0, 0.0, 20001)
    area = 4.0 - (z - height) ** 2
    assert found.centre_of_buoyancy == pytest.approx(
        [0.0, 0.0, np.trapezoid(z * area, z) / np.trapezoid(area, z)], rel=1e-6
    )
    assert found.centre_of_mass.tolist() == [0.0, 0.0, height]
    assert found.volume == 2000.0


def test_rayleigh_damping_of_mass_and_elastic_stiffness():
    """Prestress and gas lose nothing; all three make the stiffness. What is stored is taken as it is."""
    rng, n = np.random.default_rng(4), len(LABELS)
    ds = flexible().drop_vars("structural_damping_matrix")
    extra = {name: (PAIR, 1e6 * rng.normal(size=(n, n))) for name in ("prestress_stiffness", "gas_stiffness")}
    elastic = 1e7 * rng.normal(size=(n, n))
    device = {"device": {"damping": {"alpha": 0.1, "beta": 1e-3}}}
    ds = ds.assign(extra | {"structural_stiffness": (PAIR, elastic)}).assign_attrs(spec=json.dumps(device))
    found = structure(ds, "memory")
    at = LABELS.index("Bend")
    assert found.damping[at, at] == pytest.approx(0.1 * ds.inertia_matrix.values[at, at] + 1e-3 * elastic[at, at])
    assert np.count_nonzero(found.damping) == 1
    assert found.stiffness == pytest.approx(elastic + sum(matrix for _, matrix in extra.values()))
    assert found.mass == pytest.approx(ds.inertia_matrix.values)
    stored = np.arange(16.0).reshape(4, 4)
    assert structure(ds.assign(structural_damping_matrix=(PAIR, stored)), "memory").damping.tolist() == stored.tolist()
