"""Exchange with WAMIT's numeric files and BEMIO's .h5: conventions by numbers worked out by hand, and round trips."""

import json

import netCDF4
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from vsb.errors import ConfigError, DatabaseError
from vsb.hydro import database
from vsb.hydro.formats.bemio import bemio_entries, excitation_response, impulse_times, read_bemio, write_h5
from vsb.hydro.formats.exchange import export
from vsb.hydro.formats.wamit import import_wamit, wamit_texts
from vsb.hydro.kernel import DampingSpectrum
from vsb.tools import files, units

HALF_DIGIT = 5e-7  # of seven significant digits
PAIR, WAVE = ("influenced_dof", "radiating_dof"), ("omega", "wave_direction", "influenced_dof")
DAMPING = "structural_damping_matrix"
WATER = {"water_density": 1000.0, "gravity": 10.0, "water_depth": "inf"}


def assembled(labels, omega, directions=(0.0,), *, added, damping, force, stiffness, **more):
    """A hydro database of given arrays."""
    data = {
        "added_mass": (("omega", *PAIR), added),
        "radiation_damping": (("omega", *PAIR), damping),
        "excitation_force": (WAVE, force),
        "hydrostatic_stiffness": (PAIR, stiffness),
        **more,
    }
    coords = {"omega": list(omega), "wave_direction": list(directions), **{dof: list(labels) for dof in PAIR}}
    return units.described(xr.Dataset(data, coords).assign_attrs(WATER))


def random_database(modes=2, frequencies=4, headings=1, seed=0, spread=0.0):
    """Random numbers over 10^±spread, in all that a database may hold."""
    rng, n = np.random.default_rng(seed), modes + 1

    def numbers(*shape):
        return rng.choice([-1, 1], shape) * rng.uniform(1, 10, shape) * 10.0 ** rng.uniform(-spread, spread, shape)

    def wave():
        shape = (frequencies, headings, n)
        return WAVE, numbers(*shape) + 1j * numbers(*shape)

    labels = ["Heave", *(f"Membrane{i}" for i in range(modes))]
    ds = assembled(
        labels,
        np.cumsum(rng.uniform(0.05, 1.0, frequencies)),
        np.linspace(-1.0, 2.0, headings),
        added=numbers(frequencies, n, n),
        damping=numbers(frequencies, n, n),
        force=wave()[1],
        stiffness=numbers(n, n),
        added_mass_inf=(PAIR, numbers(n, n)),
    )
    return units.described(ds.assign(Froude_Krylov_force=wave(), diffraction_force=wave()))


def with_structure(ds, alpha=0.0, beta=0.0, heave_mass=4000.0):
    """The same with inertia, stiffness of structure, prestress and gas, heave apart, and the facts of a study."""
    n, modes = ds.sizes["influenced_dof"], np.arange(1.0, ds.sizes["influenced_dof"])
    inertia, stiffness = np.diag([heave_mass, *100 * modes]), np.diag([0.0, *1e5 * modes])
    prestress = 3e3 * (np.eye(n, k=1) + np.eye(n, k=-1))
    prestress[0, :] = prestress[:, 0] = 0.0
    dry = {"inertia_matrix": inertia, "structural_stiffness": stiffness}
    dry |= {"prestress_stiffness": prestress, "gas_stiffness": stiffness / 50}
    spec = json.dumps({"device": {"damping": {"alpha": alpha, "beta": beta}}})
    facts = {"radius": 2.0, "centre_height": 0.0, "spec": spec, "spec_id": "a" * 16, "quality": "[]"}
    return units.described(ds.assign({name: (PAIR, m) for name, m in dry.items()}).assign_attrs(facts))


def written(folder, texts, name="buoy"):
    for extension, text in texts.items():
        (folder / f"{name}{extension}").write_text(text)
    return folder


def read_back(folder, ds, length=1.0):
    written(folder, wamit_texts(ds, "memory", length))
    labels = list(ds.influenced_dof.values)
    return import_wamit(folder, "buoy", density=1000.0, gravity=10.0, length=length, labels=labels)


def rows(text):
    """Numbers of a file without its header."""
    return np.array([[float(word) for word in line.split()] for line in text.splitlines()[1:]])


def relative(values, reference):
    return np.max(np.abs(values - reference) / np.abs(reference))


# --- WAMIT


def two_modes(**more):
    """Period 4 s, rho = 1000, g = 10: every number of the files can be worked out in the head."""
    omega = 2 * np.pi / 4
    return assembled(
        ["Heave", "Membrane0"],
        [omega],
        added=np.array([[[2000.0, -500.0], [-500.0, 4000.0]]]),
        damping=omega * np.array([[[1000.0, 250.0], [250.0, 3000.0]]]),
        force=1e4 * np.array([[[3.0 - 4.0j, 0.0 + 2.0j]]]),
        stiffness=1e4 * np.array([[4.0, -1.0], [-2.0, 8.0]]),
        added_mass_inf=(PAIR, np.array([[1000.0, 0.0], [0.0, 1000.0]])),
        **more,
    )


def test_files_are_these():
    texts = wamit_texts(two_modes(), "memory")
    assert set(texts) == {".1", ".3", ".hst"}
    assert texts[".1"].splitlines()[1:] == [
        "  0.000000E+00     3     3  1.000000E+00",
        "  0.000000E+00     3     7  0.000000E+00",
        "  0.000000E+00     7     3  0.000000E+00",
        "  0.000000E+00     7     7  1.000000E+00",
        "  4.000000E+00     3     3  2.000000E+00  1.000000E+00",
        "  4.000000E+00     3     7 -5.000000E-01  2.500000E-01",
        "  4.000000E+00     7     3 -5.000000E-01  2.500000E-01",
        "  4.000000E+00     7     7  4.000000E+00  3.000000E+00",
    ]
    assert texts[".3"].splitlines()[1:] == [
        "  4.000000E+00  0.000000E+00     3  5.000000E+00  5.313010E+01  3.000000E+00  4.000000E+00",
        "  4.000000E+00  0.000000E+00     7  2.000000E+00 -9.000000E+01  0.000000E+00 -2.000000E+00",
    ]
    assert texts[".hst"].splitlines()[1:] == [
        "     3     3  4.000000E+00",
        "     3     7 -1.000000E+00",
        "     7     3 -2.000000E+00",
        "     7     7  8.000000E+00",
    ]
    for text in texts.values():
        assert "ULEN 1 density 1000 gravity 10 depth inf modes 3=Heave 7=Membrane0" in text.splitlines()[0]


def test_length_scale_divides_as_translations_do():
    one, two = (wamit_texts(two_modes(), "memory", length) for length in (1.0, 2.0))
    assert rows(one[".hst"])[:, 2] == pytest.approx(4 * rows(two[".hst"])[:, 2])
    assert rows(one[".3"])[:, [3, 5, 6]] == pytest.approx(4 * rows(two[".3"])[:, [3, 5, 6]])
    assert rows(one[".3"])[:, 4] == pytest.approx(rows(two[".3"])[:, 4])
    for one_line, two_line in zip(one[".1"].splitlines()[1:], two[".1"].splitlines()[1:], strict=True):
        a, b = (np.array([float(word) for word in line.split()]) for line in (one_line, two_line))
        assert a[:3] == pytest.approx(b[:3])
        assert a[3:] == pytest.approx(8 * b[3:])


def test_force_in_time_is_the_same_in_both_conventions():
    ds = random_database(headings=2)
    for extension, name in ((".3", "excitation_force"), (".3fk", "Froude_Krylov_force"), (".3sc", "diffraction_force")):
        period, heading, mode, modulus, phase, re, im = rows(wamit_texts(ds, "memory")[extension]).T
        t, omega = 0.37, 2 * np.pi / period
        flat = ds[name].values[::-1].ravel()  # periods ascend, frequencies descend
        ours = np.real(flat * np.exp(-1j * omega * t)) / 1e4
        assert modulus * np.cos(omega * t + np.radians(phase)) == pytest.approx(ours, rel=1e-4)
        assert re * np.cos(omega * t) - im * np.sin(omega * t) == pytest.approx(ours, rel=1e-4)
        assert mode.astype(int).tolist() == [3, 7, 8] * 8
        assert np.unique(heading) == pytest.approx(np.degrees([-1.0, 2.0]))


def test_long_waves():
    """A long wave lifts the water like the body lowered: C, - omega^2 A and, leading by a quarter, omega B per metre."""
    radius, omega = 2.0, np.array([0.05, 0.1])
    stiffness, added, damping = 1e4 * np.pi * radius**2, 1.5e4, 900.0 * omega
    full = stiffness - omega**2 * added - 1j * omega * damping  # water moves with -i omega here
    ds = assembled(
        ["Heave"],
        omega,
        added=np.full((2, 1, 1), added),
        damping=damping[:, None, None],
        force=full[:, None, None],
        stiffness=[[stiffness]],
        Froude_Krylov_force=(WAVE, np.full((2, 1, 1), stiffness + 0j)),
    )
    texts = wamit_texts(ds, "memory")
    assert rows(texts[".3fk"])[:, 3:] == pytest.approx(np.tile([4 * np.pi, 0.0, 4 * np.pi, 0.0], (2, 1)), rel=1e-6)
    assert rows(texts[".1"])[:, 4] == pytest.approx([0.9, 0.9])
    im, bar, period = rows(texts[".3"])[:, 6], rows(texts[".1"])[:, 4], rows(texts[".3"])[:, 0]
    assert im == pytest.approx((2 * np.pi / period) ** 2 * bar / 10.0, rel=1e-5)
    assert np.all(rows(texts[".3"])[:, 4] > 0)


def test_zero_frequency_is_written_and_read_as_a_limit(tmp_path):
    ds = random_database(modes=1, frequencies=2).assign_coords(omega=[0.0, np.pi])
    texts = wamit_texts(ds, "memory")
    lines = texts[".1"].splitlines()[1:]
    periods = ["-1.000000E+00", "0.000000E+00", "2.000000E+00"]
    assert [line.split()[0] for line in lines] == np.repeat(periods, 4).tolist()
    assert [len(line.split()) for line in lines] == [4] * 8 + [5] * 4
    assert float(lines[1].split()[3]) == pytest.approx(ds.added_mass.values[0, 0, 1] / 1000, rel=1e-6)
    assert len(rows(texts[".3"])) == 2
    back = import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0)
    assert back.sizes["omega"] == 1
    assert back.added_mass_zero.values == pytest.approx(ds.added_mass.values[0], rel=1e-6)
    again = wamit_texts(back, "memory")
    assert again[".1"].splitlines()[1:] == lines
    assert back.attrs["history"] == "read from WAMIT's files buoy"


@settings(max_examples=25)
@given(st.integers(0, 3), st.integers(1, 5), st.integers(1, 3), st.integers(0, 10**6), st.sampled_from([0.3, 1.0, 7.0]))
def test_round_trip_is_exact_to_the_digits_printed(tmp_path_factory, modes, frequencies, headings, seed, length):
    ds = random_database(modes, frequencies, headings, seed, spread=8.0)
    folder = tmp_path_factory.mktemp("wamit")
    back = read_back(folder, ds, length)
    assert relative(back.omega.values, ds.omega.values) <= HALF_DIGIT * 1.0001
    for name in ("added_mass", "added_mass_inf", "hydrostatic_stiffness"):
        assert relative(back[name].values, ds[name].values) <= HALF_DIGIT * 1.0001
    assert relative(back.radiation_damping.values, ds.radiation_damping.values) <= 2 * HALF_DIGIT * 1.0001
    for name in ("excitation_force", "Froude_Krylov_force", "diffraction_force"):
        assert relative(back[name].values.real, ds[name].values.real) <= HALF_DIGIT * 1.0001
        assert relative(back[name].values.imag, ds[name].values.imag) <= HALF_DIGIT * 1.0001
    assert set(back.data_vars) == set(ds.data_vars)
    for name in ("influenced_dof", "radiating_dof"):
        assert back[name].values.tolist() == ds[name].values.tolist()
    assert np.abs(back.wave_direction.values - ds.wave_direction.values).max() <= HALF_DIGIT * 2.0
    for name in ds.variables:
        assert (back[name].dims, back[name].attrs) == (ds[name].dims, ds[name].attrs)
    again = wamit_texts(back, "memory", length)
    for extension, text in wamit_texts(ds, "memory", length).items():
        kept = [0, 1, 2, 5, 6] if extension.startswith(".3") else slice(None)  # modulus and phase are of rounded parts
        for line, second in zip(text.splitlines()[1:], again[extension].splitlines()[1:], strict=True):
            assert np.array(line.split())[kept].tolist() == np.array(second.split())[kept].tolist()


def test_numbers_stay_apart_however_small(tmp_path):
    ds = two_modes()
    tiny = ds.assign(added_mass=-1e-140 * ds.added_mass, hydrostatic_stiffness=-1e-120 * ds.hydrostatic_stiffness)
    back = read_back(tmp_path, tiny.assign_attrs(WATER))
    assert relative(back.added_mass.values, tiny.added_mass.values) <= HALF_DIGIT * 1.0001
    assert relative(back.hydrostatic_stiffness.values, tiny.hydrostatic_stiffness.values) <= HALF_DIGIT * 1.0001


FOREIGN = {
    ".1": """ WAMIT Numeric Output -- Filename  barge.1      01-Jan-2001  00:00:00
 -1.000000E+00     3     3  9.000000E+00
  0.000000E+00     1     1  5.000000E-01
  0.000000E+00     3     3  1.500000E+00
  0.000000E+00     3     9 -2.500000E-01
  0.000000E+00     9     9  1.000000E+00
  2.000000E+00     1     1  1.000000E+00  1.000000E+00
  2.000000E+00     3     3  2.000000E+00  3.000000E-01
  2.000000E+00     3     9  4.000000E-01  5.000000E-02
  2.000000E+00     9     9  6.000000D-01  7.000000D-02
  4.000000E+00     1     1  1.000000E+00  1.000000E+00
  4.000000E+00     3     3  2.500000E+00  3.500000E-01
  4.000000E+00     3     9  4.500000E-01  5.500000E-02
  4.000000E+00     9     9  6.500000E-01  7.500000E-02
""",
    ".3": """ WAMIT Numeric Output -- Filename  barge.3      01-Jan-2001  00:00:00
  2.000000E+00  9.000000E+01     1  1.000000E+00  9.000000E+01  0.000000E+00  1.000000E+00
  2.000000E+00  9.000000E+01     3  5.000000E+00  5.313010E+01  3.000000E+00  4.000000E+00
  2.000000E+00  9.000000E+01     9  2.000000E+00  1.800000E+02 -2.000000E+00  0.000000E+00
  4.000001E+00  9.000000E+01     1  1.000000E+00  9.000000E+01  0.000000E+00  1.000000E+00
  4.000001E+00  9.000000E+01     3  1.000000E+01 -5.313010E+01  6.000000E+00 -8.000000E+00
  4.000001E+00  9.000000E+01     9  1.000000E+00 -9.000000E+01  0.000000E+00 -1.000000E+00
""",
    ".hst": """ WAMIT -- Force Output File -- barge.hst      01-Jan-2001  00:00:00
     1     1   0.000000E+00
     3     3   7.000000E+00
     3     9   1.000000E+00
     9     3  -1.000000E+00
     9     9   2.000000E+00
     1     3   0.000000E+00
     1     9   0.000000E+00
     3     1   0.000000E+00
     9     1   5.000000E-01
""",
}


def test_output_of_others_with_generalized_modes(tmp_path):
    """ULEN = 2, rho = 1000, g = 10: rho L^3 = 8000 kg, rho g L^2 = 40000 N/m; of modes 1, 3 and 9, 1 is uncoupled."""
    ds = import_wamit(written(tmp_path, FOREIGN), "buoy", density=1000.0, gravity=10.0, length=2.0, depth=30.0)
    assert ds.influenced_dof.values.tolist() == ["Surge", "Heave", "Mode9"]
    assert ds.omega.values == pytest.approx([np.pi / 2, np.pi])
    assert ds.wave_direction.values == pytest.approx([np.pi / 2])
    assert ds.added_mass.values == pytest.approx(
        8000 * np.array([[[1, 0, 0], [0, 2.5, 0.45], [0, 0, 0.65]], [[1, 0, 0], [0, 2.0, 0.4], [0, 0, 0.6]]])
    )
    assert ds.added_mass_inf.values == pytest.approx(8000 * np.array([[0.5, 0, 0], [0, 1.5, -0.25], [0, 0, 1.0]]))
    long, short = ds.radiation_damping.values / np.pi
    assert short == pytest.approx(8000 * np.array([[1, 0, 0], [0, 0.3, 0.05], [0, 0, 0.07]]))
    assert long == pytest.approx(4000 * np.array([[1, 0, 0], [0, 0.35, 0.055], [0, 0, 0.075]]))
    assert ds.excitation_force.values[:, 0] == pytest.approx(4e4 * np.array([[-1j, 6 + 8j, 1j], [-1j, 3 - 4j, -2]]))
    assert ds.hydrostatic_stiffness.values == pytest.approx(4e4 * np.array([[0, 0, 0], [0, 7, 1], [0.5, -1, 2]]))
    assert ds.attrs["history"] == "read from WAMIT's files buoy; left out: zero frequency, not of all pairs"
    assert {name: ds.attrs[name] for name in WATER} == {**WATER, "water_depth": "30.0"}
    assert {name: ds[name].attrs["units"] for name in ds.data_vars} == {
        "added_mass": "kg",
        "added_mass_inf": "kg",
        "radiation_damping": "kg/s",
        "excitation_force": "N/m",
        "hydrostatic_stiffness": "N/m",
    }
    files.save(ds, tmp_path / "imported.nc")
    assert files.load(tmp_path / "imported.nc").equals(ds)


def test_a_header_may_be_missing_and_infinite_frequency_too(tmp_path):
    bare = {extension: text.partition("\n")[2] for extension, text in FOREIGN.items()}
    bare[".1"] = "".join(line + "\n" for line in bare[".1"].splitlines() if not line.startswith("  0.0"))
    ds = import_wamit(written(tmp_path, bare), "buoy", density=1000.0, gravity=10.0)
    assert "added_mass_inf" not in ds
    assert ds.added_mass.values[1, 1] == pytest.approx([0.0, 2000.0, 400.0])


def edited(extension, old, new):
    assert old in FOREIGN[extension]
    return {**FOREIGN, extension: FOREIGN[extension].replace(old, new, 1)}


LINE = "  2.000000E+00     3     9  4.000000E-01  5.000000E-02\n"
FORCE = "  2.000000E+00  9.000000E+01     9  2.000000E+00  1.800000E+02 -2.000000E+00  0.000000E+00\n"
BROKEN = {
    "nan": (edited(".1", "4.000000E-01", "nan"), r"buoy\.1, line 9: '2.000000E\+00.*' is not of 4 or 5 finite numbers; needs"),
    "words": (edited(".1", "4.000000E-01", "********"), r"buoy\.1, line 9: .*is not of 4 or 5 finite numbers"),
    "columns": (edited(".1", "5.000000E-02", "1 2"), r"buoy\.1, line 9: .*needs numbers PER I J A, and B where PER > 0"),
    "no damping": (edited(".1", "  5.000000E-02", ""), r"buoy\.1, line 9: .*has no damping"),
    "half a mode": (edited(".1", "     3     9  4.0", "   3.5     9  4.0"), r"line 9: .*mode numbers that are not whole"),
    "mode zero": (edited(".1", "     3     9  4.0", "     0     9  4.0"), r"line 9: .*mode numbers that are not whole"),
    "repeated": (edited(".1", LINE, 2 * LINE), r"buoy\.1, line 10: .*repeats an earlier line"),
    "missing pair": (edited(".1", LINE, ""), r"buoy\.1: no line starts with \(2\.0, 3, 9\)"),
    "period": (edited(".1", "-1.000000E+00", "-2.000000E+00"), r"buoy\.1: holds period -2; needs periods > 0, 0 or -1"),
    "no waves": ({**FOREIGN, ".1": "".join(FOREIGN[".1"].splitlines(True)[:6])}, r"buoy\.1: holds no period > 0; needs lines PER I J A B"),
    "nothing": ({**FOREIGN, ".1": "header\n"}, r"buoy\.1: holds no data; needs lines PER I J A"),
    "no force": (edited(".3", FORCE, ""), r"buoy\.3: no line starts with \(2\.0, 90\.0, 9\)"),
    "force nan": (edited(".3", "-2.000000E+00", "inf"), r"buoy\.3, line 4: .*is not of 7 finite numbers"),
    "modulus": (edited(".3", "  2.000000E+00  1.8", "  2.100000E+00  1.8"), r"buoy\.3, line 4: .*modulus that contradicts"),
    "force twice": (edited(".3", FORCE, 2 * FORCE), r"buoy\.3, line 5: .*repeats an earlier line"),
    "other periods": ({**FOREIGN, ".3": FOREIGN[".3"].replace("4.000001E+00", "4.001000E+00")}, r"buoy\.3: its periods are not those of .*buoy\.1"),
    "same periods": ({**FOREIGN, ".3": FOREIGN[".3"].replace("4.000001E+00", "2.000001E+00")}, r"buoy\.3: its periods are not those of"),
    "parts of another run": ({**FOREIGN, ".3fk": FOREIGN[".3"].replace("9.000000E+01  ", "0.000000E+00  ")}, r"buoy\.3fk: no line starts with"),
    "empty": ({**FOREIGN, ".3": "header\n"}, r"buoy\.3: holds no data; needs lines PER BETA I"),
    "stiffness": (edited(".hst", "     9     3  -1.000000E+00\n", ""), r"buoy\.hst: no line starts with \(9, 3\)"),
    "stiffness twice": (edited(".hst", "     9     3", "     3     9"), r"buoy\.hst, line 5: .*repeats an earlier line"),
    "stiffness nan": (edited(".hst", "7.000000E+00", "NaN"), r"buoy\.hst, line 3: .*is not of 3 finite numbers; needs numbers I J C"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_broken_files_are_refused_by_name_and_line(tmp_path, case):
    texts, message = BROKEN[case]
    with pytest.raises(DatabaseError, match=message) as error:
        import_wamit(written(tmp_path, texts), "buoy", density=1000.0, gravity=10.0)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("extension", [".1", ".3", ".hst"])
def test_missing_files_are_refused(tmp_path, extension):
    written(tmp_path, {name: text for name, text in FOREIGN.items() if name != extension})
    with pytest.raises(DatabaseError, match=rf"buoy\{extension}: cannot be read \(No such file or directory\); needs"):
        import_wamit(tmp_path, "buoy", density=1000.0, gravity=10.0)


@pytest.mark.parametrize(
    ("facts", "message"),
    [
        ({"density": 0.0}, "density: received 0.0, needs a positive number"),
        ({"gravity": -9.81}, "gravity: received -9.81, needs a positive number"),
        ({"length": np.nan}, "length: received nan, needs a positive number"),
        ({"depth": 0.0}, "depth: received 0.0, needs a positive number of m, or inf"),
        ({"depth": np.nan}, "depth: received nan, needs"),
        ({"labels": ["Heave"]}, r"holds modes \[1, 3, 9\]; needs as many labels of these, received \['Heave'\]"),
        ({"labels": ["Surge", "Membrane0", "Heave"]}, "needs as many labels of these, received"),
        ({"labels": ["Heave", "Heave"]}, "needs at least one, and none twice"),
    ],
)
def test_facts_that_do_not_fit_the_files_are_refused(tmp_path, facts, message):
    with pytest.raises((ConfigError, DatabaseError), match=message):
        import_wamit(written(tmp_path, FOREIGN), "buoy", **{"density": 1000.0, "gravity": 10.0, **facts})


def test_labels_of_the_modes_may_be_given(tmp_path):
    labels = ["Surge", "Heave", "Bending1"]
    ds = import_wamit(written(tmp_path, FOREIGN), "buoy", density=1000.0, gravity=10.0, labels=labels)
    assert ds.radiating_dof.values.tolist() == labels


def test_what_cannot_be_written_is_refused():
    ds = random_database()
    bare = ds.drop_vars("excitation_force").drop_attrs()
    with pytest.raises(
        DatabaseError, match="memory: holds no gravity, excitation_force; needs a complete hydro database"
    ):
        wamit_texts(bare.assign_attrs(water_density=1.0, water_depth=2.0), "memory")
    with pytest.raises(DatabaseError, match="memory: variable added_mass holds NaN"):
        wamit_texts(ds.assign(added_mass=ds.added_mass * np.nan).assign_attrs(WATER), "memory")
    for omega in ([1.0, 2.0, np.nan, 4.0], [1.0, 2.0, 3.0, np.inf], [-1.0, 2.0, 3.0, 4.0], [1.0, 3.0, 2.0, 4.0]):
        with pytest.raises(DatabaseError, match=r"memory: frequencies \[.*\] rad/s; needs finite, ascending ones"):
            wamit_texts(ds.assign_coords(omega=omega), "memory")
    with pytest.raises(DatabaseError, match="memory: periods equal to seven digits"):
        wamit_texts(ds.assign_coords(omega=[1.0, 1.0 + 1e-9, 2.0, 3.0]), "memory")


# --- BEMIO


@pytest.fixture
def elastic():
    """Heave and two modes with their structure, damping of a passive body."""
    ds = random_database(modes=2, frequencies=6, headings=2)
    factor = np.random.default_rng(3).normal(size=(6, 3, 3))
    return with_structure(
        ds.assign(radiation_damping=(("omega", *PAIR), factor @ factor.transpose(0, 2, 1))), 0.5, 1e-3
    )


@pytest.fixture
def bemio(elastic, tmp_path):
    write_h5(bemio_entries(elastic, "memory"), tmp_path / "buoy.h5")
    with netCDF4.Dataset(tmp_path / "buoy.h5") as file:
        file.set_auto_mask(False)
        yield file


def test_h5_has_the_layout_wec_sim_reads(bemio):
    """Dimensions as in a file of MATLAB's writeBEMIOH5: reversed when MATLAB shows them."""
    shapes = {
        "/simulation_parameters/scaled": (1, 1), "/simulation_parameters/g": (1, 1), "/simulation_parameters/rho": (1, 1),
        "/simulation_parameters/w": (6, 1), "/simulation_parameters/T": (6, 1), "/simulation_parameters/wave_dir": (2, 1),
        "/simulation_parameters/water_depth": (), "/bem_data/code": (), "/body1/properties/name": (),
        "/body1/properties/body_number": (1, 1), "/body1/properties/cb": (3, 1), "/body1/properties/cg": (3, 1),
        "/body1/properties/disp_vol": (1, 1), "/body1/properties/dof": (1, 1), "/body1/properties/dof_start": (1, 1),
        "/body1/properties/dof_end": (1, 1), "/body1/properties/mass": (8, 8), "/body1/properties/stiffness": (8, 8),
        "/body1/properties/damping": (8, 8), "/body1/hydro_coeffs/linear_restoring_stiffness": (8, 8),
        "/body1/hydro_coeffs/added_mass/all": (8, 8, 6), "/body1/hydro_coeffs/added_mass/inf_freq": (8, 8),
        "/body1/hydro_coeffs/radiation_damping/all": (8, 8, 6),
        "/body1/hydro_coeffs/radiation_damping/impulse_response_fun/K": (8, 8, 1001),
        "/body1/hydro_coeffs/radiation_damping/impulse_response_fun/t": (1001, 1),
        "/body1/hydro_coeffs/excitation/impulse_response_fun/f": (8, 2, 2001),
        "/body1/hydro_coeffs/excitation/impulse_response_fun/t": (2001, 1),
        **{f"/body1/hydro_coeffs/excitation/{part}{key}": (8, 2, 6) for part in ("", "froude-krylov/", "scattering/") for key in ("re", "im", "mag", "phase")},
    }  # fmt: skip
    assert {place: bemio[place].shape for place in shapes} == shapes
    assert {bemio[place].dtype for place, shape in shapes.items() if shape} == {np.dtype("f8")}
    numbers = {"scaled": 0.0, "g": 10.0, "rho": 1000.0}
    assert {key: bemio[f"/simulation_parameters/{key}"][0, 0] for key in numbers} == numbers
    facts = {"body_number": 1.0, "dof": 8.0, "dof_start": 1.0, "dof_end": 8.0}
    assert {key: bemio[f"/body1/properties/{key}"][0, 0] for key in facts} == facts
    assert bemio["/simulation_parameters/water_depth"][...] == "infinite"
    assert bemio["/body1/properties/name"][...] == "buoy"


def test_h5_normalization_and_places(bemio, elastic):
    """Indices from 0: heave is 2, the modes 6 and 7; A/rho, B/(rho omega), C/(rho g), structure in SI."""
    place = [2, 6, 7]
    hydro, body = bemio["/body1/hydro_coeffs"], bemio["/body1/properties"]
    for i, row in enumerate(place):
        for j, column in enumerate(place):
            a, b = elastic.added_mass.values[:, i, j], elastic.radiation_damping.values[:, i, j]
            assert hydro["added_mass/all"][row, column] == pytest.approx(a / 1000)
            assert hydro["radiation_damping/all"][row, column] == pytest.approx(b / 1000 / elastic.omega.values)
            assert hydro["added_mass/inf_freq"][row, column] == pytest.approx(
                elastic.added_mass_inf.values[i, j] / 1000
            )
            assert hydro["linear_restoring_stiffness"][row, column] == pytest.approx(
                elastic.hydrostatic_stiffness.values[i, j] / 1e4
            )
    for name in ("added_mass/all", "radiation_damping/all", "added_mass/inf_freq", "linear_restoring_stiffness"):
        held = np.delete(np.delete(hydro[name][...], place, axis=0), place, axis=1)
        assert not held.any()
        assert np.count_nonzero(hydro[name][...]) == elastic.added_mass.values[0].size * (6 if "all" in name else 1)
    assert body["mass"][6:, 6:] == pytest.approx(np.diag([100.0, 200.0]))
    assert body["stiffness"][6:, 6:] == pytest.approx(np.array([[1.02e5, 3e3], [3e3, 2.04e5]]))
    assert body["damping"][6:, 6:] == pytest.approx(np.diag([0.5 * 100 + 100.0, 0.5 * 200 + 200.0]))
    assert np.count_nonzero(body["damping"][...]) == 2
    assert (body["mass"][2, 2], body["disp_vol"][0, 0]) == (4000.0, 4.0)
    assert body["cb"][:, 0] == pytest.approx([0, 0, -3 / 8 * 2.0])  # half a ball of radius 2
    assert body["cg"][:, 0] == pytest.approx([0, 0, 0])
    assert bemio["/simulation_parameters/T"][:, 0] == pytest.approx(2 * np.pi / elastic.omega.values)
    assert bemio["/simulation_parameters/wave_dir"][:, 0] == pytest.approx(np.degrees([-1.0, 2.0]))


def test_h5_force_in_time(bemio, elastic):
    """WEC-Sim forms re cos(omega t) - im sin(omega t), C1 Re(X e^{-i omega t})."""
    parts = {"": "excitation_force", "froude-krylov/": "Froude_Krylov_force", "scattering/": "diffraction_force"}
    t, omega = 0.81, elastic.omega.values
    for folder, name in parts.items():
        re, im, mag, phase = (
            bemio[f"/body1/hydro_coeffs/excitation/{folder}{k}"] for k in ("re", "im", "mag", "phase")
        )
        ours = np.real(elastic[name].values[:, 1, 2] * np.exp(-1j * omega * t)) / 1e4
        assert re[7, 1] * np.cos(omega * t) - im[7, 1] * np.sin(omega * t) == pytest.approx(ours)
        assert mag[7, 1] * np.cos(omega * t + phase[7, 1]) == pytest.approx(ours)


def test_h5_impulse_response_is_the_retardation_kernel(bemio, elastic):
    response = bemio["/body1/hydro_coeffs/radiation_damping/impulse_response_fun"]
    time = response["t"][:, 0]
    assert (time[0], time[1], time[-1], len(time)) == (0.0, 0.05, 50.0, 1001)  # 4 m^3
    early = time < 10 / np.diff(elastic.omega.values, prepend=0.0).max()
    spectrum = DampingSpectrum(elastic.omega.values, elastic.radiation_damping.values)
    assert response["K"][2, 7, early] == pytest.approx(spectrum.kernel(time[early])[:, 0, 2] / 1000, abs=1e-8)
    assert response["K"][7, 7, 0] > 0


def test_late_impulse_response_of_few_frequencies_is_no_artefact(bemio, elastic):
    """At 49 s the eight points between two frequencies 1 rad/s apart are too few; against adaptive quadrature."""
    spectrum = DampingSpectrum(elastic.omega.values, elastic.radiation_damping.values)
    top, late = elastic.omega.values[-1], 973
    time = 0.05 * late

    def integral(place, upper, weight=lambda w: 1.0):
        options = {"weight": "cos", "wvar": time, "limit": 500, "limlst": 500, "epsabs": 1e-6}
        return quad(lambda w: spectrum.at(np.array([w]))[0][place], *upper, **options)[0]

    expected = 2 / np.pi * (integral((0, 2), (0.0, top)) + integral((0, 2), (top, np.inf)))
    assert bemio["/body1/hydro_coeffs/radiation_damping/impulse_response_fun/K"][2, 7, late] == pytest.approx(
        expected / 1000, rel=1e-5, abs=1e-6 * abs(spectrum.damping).max() / 1000
    )


@pytest.mark.parametrize(("radius", "step"), [(2.0, 0.1), (0.02, 0.01), (0.2, 0.02), (20.0, 0.2), (50.0, 0.5)])
def test_impulse_responses_last_as_long_as_the_body_is_large(radius, step):
    """A 2 m buoy has 0.1 s and 100 s; the steps fall between 0.09 and 0.23 sqrt(radius/g)."""
    time = impulse_times(radius, 9.81)
    assert (time[0], time[1], time[-1], len(time)) == (0.0, pytest.approx(step), pytest.approx(1000 * step), 1001)
    assert 0.4 * 0.23 <= step / np.sqrt(radius / 9.81) <= 0.23


def test_excitation_is_the_transform_of_its_impulse_response():
    """As WEC-Sim convolves it: force = sum f(s) eta(t - s) dt, eta = Re e^{i omega t}."""
    omega = np.linspace(0.05, 5.0, 100)
    pulses = np.exp(-((omega / 1.5) ** 2))[:, None] * np.exp(1j * omega[:, None] * [[1.3, -0.4]])  # two headings
    ds = with_structure(random_database(modes=2, frequencies=100, headings=2)).assign_coords(omega=omega)
    ds = ds.assign(excitation_force=(WAVE, pulses[:, :, None] * np.array([4e4, 1e4, -3e3])))
    entries, place = bemio_entries(ds, "memory"), "/body1/hydro_coeffs/excitation/"
    time, f = entries[f"{place}impulse_response_fun/t"][:, 0], entries[f"{place}impulse_response_fun/f"]
    assert (f.shape, time[0], time[1000], time[-1]) == ((8, 2, 2001), -50.0, 0.0, 50.0)
    x = entries[f"{place}re"] + 1j * entries[f"{place}im"]
    back = f @ np.exp(-1j * np.outer(time, omega)) * (time[1] - time[0])
    assert back == pytest.approx(x, abs=1e-4 * np.abs(x).max())
    assert time[np.abs(f[2, 0]).argmax()] == pytest.approx(1.3)  # force of heading 0 lags by 1.3 s


def test_impulse_response_of_a_force_known_in_closed_form():
    """X = conj of exp(-(omega/2)^2 - i omega t0): f is a Gaussian about t0."""
    omega, delay = np.linspace(0.05, 14.0, 400), 1.7
    force = np.conj(np.exp(-((omega / 2) ** 2) - 1j * omega * delay))[:, None, None]
    time = np.linspace(-30.0, 30.0, 601)
    expected = np.exp(-((time - delay) ** 2)) / np.sqrt(np.pi)
    assert excitation_response(omega, force, time)[:, 0, 0] == pytest.approx(expected, abs=1e-6)


def test_centre_of_buoyancy_of_a_cap(elastic):
    """By quadrature over the discs of the wet part."""
    radius, height = 2.0, 0.7
    z = np.linspace(height - radius, 0.0, 20001)
    area = radius**2 - (z - height) ** 2
    entries = bemio_entries(elastic.assign_attrs(centre_height=height), "memory")
    expected = np.trapezoid(z * area, z) / np.trapezoid(area, z)
    assert entries["/body1/properties/cb"][2, 0] == pytest.approx(expected, rel=1e-6)
    assert entries["/body1/properties/cg"][2, 0] == height


def test_h5_reads_back(bemio, elastic):
    back = read_bemio(bemio.filepath())
    assert set(back.data_vars) == set(elastic.data_vars) - {"prestress_stiffness", "gas_stiffness"} | {DAMPING}
    damping = 0.5 * elastic.inertia_matrix + 1e-3 * elastic.structural_stiffness
    assert back[DAMPING].values[1:] == pytest.approx(damping.values[1:])
    assert not back[DAMPING].values[0].any()
    back = back.drop_vars(DAMPING)
    dry = elastic.structural_stiffness + elastic.prestress_stiffness + elastic.gas_stiffness
    for name in back.data_vars:
        expected = dry if name == "structural_stiffness" else elastic[name]
        assert back[name].values == pytest.approx(expected.values, rel=1e-12, abs=1e-12)
        assert (back[name].dims, back[name].attrs) == (elastic[name].dims, elastic[name].attrs)
    assert back.influenced_dof.values.tolist() == ["Heave", "Membrane0", "Membrane1"]
    assert back.omega.values == pytest.approx(elastic.omega.values)
    assert back.wave_direction.values == pytest.approx(elastic.wave_direction.values)
    assert {name: back.attrs[name] for name in WATER} == WATER
    assert back.attrs["displaced_volume"] == 4.0
    assert back.attrs["centre_of_buoyancy"] == pytest.approx([0.0, 0.0, -0.75])
    assert back.attrs["centre_of_mass"] == pytest.approx([0.0, 0.0, 0.0])
    entries, again = (
        bemio_entries(elastic, "memory"),
        bemio_entries(back.assign({DAMPING: (PAIR, damping.values * [[0], [1], [1]])}), "memory"),
    )
    numbers = [place for place, value in entries.items() if not isinstance(value, str)]
    for place in numbers:
        assert again[place] == pytest.approx(entries[place], rel=1e-9, abs=1e-9)


def changed(entries, **changes):
    """Entries with some replaced, or taken away by None; keys are the ends of paths."""
    ends = {place: next((end for end in changes if place.endswith(f"/{end}")), None) for place in entries}
    replaced = {place: changes[end] if end else entries[place] for place, end in ends.items()}
    assert {end for end in ends.values() if end} == set(changes)
    return {place: value for place, value in replaced.items() if value is not None}


def test_files_of_others_are_read(elastic, tmp_path):
    """No names of modes, no structure, a finite depth, scattering not computed."""
    nan = np.full((8, 2, 6), np.nan)
    entries = bemio_entries(elastic, "memory")
    entries = changed(entries, mode_labels=None, mass=None, stiffness=None, water_depth=np.array([[30.0]]))
    entries |= {f"/body1/hydro_coeffs/excitation/scattering/{part}": nan for part in ("re", "im", "mag", "phase")}
    write_h5(entries, tmp_path / "other.h5")
    back = read_bemio(tmp_path / "other.h5")
    labels = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw", "Mode7", "Mode8"]
    assert back.influenced_dof.values.tolist() == labels
    assert back.attrs["water_depth"] == "30.0"
    assert set(back.data_vars) & {"diffraction_force", "inertia_matrix", "structural_stiffness"} == set()
    assert back.Froude_Krylov_force.values[..., [2, 6, 7]] == pytest.approx(elastic.Froude_Krylov_force.values)
    assert not back.Froude_Krylov_force.values[..., [0, 1, 3, 4, 5]].any()


def test_scaled_files_are_dimensional_already(elastic, tmp_path):
    write_h5(changed(bemio_entries(elastic, "memory"), scaled=np.array([[1.0]])), tmp_path / "scaled.h5")
    back = read_bemio(tmp_path / "scaled.h5")
    assert back.added_mass.values == pytest.approx(elastic.added_mass.values / 1000)
    assert back.radiation_damping.values[:, 0, 0] == pytest.approx(
        elastic.radiation_damping.values[:, 0, 0] / 1000 / elastic.omega.values
    )
    assert back.excitation_force.values == pytest.approx(elastic.excitation_force.values / 1e4)
    assert back.hydrostatic_stiffness.values == pytest.approx(elastic.hydrostatic_stiffness.values / 1e4)
    assert back.inertia_matrix.values == pytest.approx(elastic.inertia_matrix.values)


def test_rigid_buoy_has_six_degrees_of_freedom(tmp_path):
    ds = with_structure(random_database(modes=0))
    entries = bemio_entries(ds.assign_attrs(water_depth=12.5), "memory")
    assert entries["/body1/properties/dof"].item() == 6
    assert entries["/body1/hydro_coeffs/added_mass/all"].shape == (6, 6, 4)
    assert entries["/simulation_parameters/water_depth"].item() == 12.5
    write_h5(entries, tmp_path / "rigid.h5")
    assert read_bemio(tmp_path / "rigid.h5").added_mass.values == pytest.approx(ds.added_mass.values)


def test_h5_that_cannot_be_read_is_refused(elastic, tmp_path):
    path = tmp_path / "buoy.h5"
    with pytest.raises(DatabaseError, match=r"buoy\.h5: cannot be read: .*No such file.*; needs BEMIO's \.h5 file"):
        read_bemio(path)
    path.write_bytes(b"no HDF5")
    with pytest.raises(DatabaseError, match=r"buoy\.h5: cannot be read: .*Unknown file format"):
        read_bemio(path)
    entries = bemio_entries(elastic, "memory")
    write_h5(changed(entries, inf_freq=None), path)
    with pytest.raises(DatabaseError, match=r"buoy\.h5: holds no /body1/hydro_coeffs/added_mass/inf_freq; needs"):
        read_bemio(path)
    write_h5(changed(entries, dof=np.array([[9.0]])), path)
    with pytest.raises(DatabaseError, match=r"holds 9 degrees of freedom; needs 8 for its mode_labels \['Heave', 'Mem"):
        read_bemio(path)
    write_h5(changed(entries, mode_labels=None, dof=np.array([[9.0]])), path)
    with pytest.raises(DatabaseError, match=r"added_mass/all has shape \(8, 8, 6\); needs \(9, 9, 6\)"):
        read_bemio(path)
    write_h5(entries | {"/body2/properties/name": "other"}, path)
    with pytest.raises(DatabaseError, match=r"buoy\.h5: holds body1, body2; needs the file of one body"):
        read_bemio(path)
    write_h5(changed(entries, inf_freq=np.full((8, 8), np.nan)), path)
    with pytest.raises(DatabaseError, match=r"buoy\.h5: variable added_mass_inf holds NaN"):
        read_bemio(path)


def test_h5_of_an_unfit_database_is_refused(elastic):
    bare = elastic.drop_vars("inertia_matrix").drop_attrs().assign_attrs(WATER, radius=2.0, centre_height=0.0)
    with pytest.raises(DatabaseError, match="memory: holds no inertia_matrix and structural_stiffness; generalized"):
        bemio_entries(bare, "memory")
    with pytest.raises(DatabaseError, match="memory: holds no added_mass_inf; needs a complete hydro database"):
        bemio_entries(elastic.drop_vars("added_mass_inf"), "memory")
    with pytest.raises(DatabaseError, match="memory: holds zero frequency"):
        bemio_entries(elastic.assign_coords(omega=np.arange(6.0)), "memory")
    for name in ("inertia_matrix", "gas_stiffness"):
        coupled = elastic[name] + 10.0 * (np.eye(3, k=1) + np.eye(3, k=-1))
        total = "inertia_matrix" if name == "inertia_matrix" else "structural_stiffness"
        with pytest.raises(DatabaseError, match=f"memory: {total} couples rigid and generalized modes, which WEC-Sim"):
            bemio_entries(elastic.assign({name: coupled}), "memory")


# --- files


@pytest.fixture
def stored(elastic, tmp_path):
    path = tmp_path / "db" / f"{'a' * 16}.nc"
    database.save_database(elastic, None, path)
    return path


ALL = ["buoy.1", "buoy.3", "buoy.3fk", "buoy.3sc", "buoy.hst", "buoy.mmx", "buoy.h5"]


def test_export_writes_what_it_names(stored, elastic, tmp_path):
    files = export(stored, tmp_path / "out", "buoy", length=2.0)
    assert [path.name for path in files] == ALL
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == sorted(ALL)
    back = import_wamit(tmp_path / "out", "buoy", density=1000.0, gravity=10.0, length=2.0)
    assert back.added_mass.values == pytest.approx(elastic.added_mass.values, rel=1e-6)
    assert read_bemio(files[-1]).added_mass.values == pytest.approx(elastic.added_mass.values)
    assert [path.name for path in export(stored, tmp_path / "text", "buoy", ["wamit"])] == ALL[:-1]
    assert [path.name for path in export(stored, tmp_path / "h5", "buoy", ["bemio"])] == ALL[-1:]
    assert [path.name for path in (tmp_path / "h5").iterdir()] == ["buoy.h5"]


def test_an_exported_and_imported_database_is_stored_like_any(stored, tmp_path):
    export(stored, tmp_path, "buoy")
    back = import_wamit(tmp_path, "buoy", density=1000.0, gravity=10.0).assign_attrs(spec_id="b" * 16, quality="[]")
    path = tmp_path / "db" / f"{'b' * 16}.nc"
    database.save_database(back, None, path)
    assert [p.name for p in export(path, tmp_path / "again", "buoy", ["wamit"])] == ALL[:-1]
    assert (tmp_path / "again" / "buoy.1").read_text().splitlines()[1:] == (
        (tmp_path / "buoy.1").read_text().splitlines()[1:]
    )


def test_nothing_is_written_unless_all_can_be(stored, elastic, tmp_path):
    with pytest.raises(DatabaseError, match=r"formats: received \['nemoh'\], needs wamit, bemio or both"):
        export(stored, tmp_path / "out", "buoy", ["nemoh"])
    with pytest.raises(DatabaseError, match="formats: received"):
        export(stored, tmp_path / "out", "buoy", [])
    with pytest.raises(ConfigError, match=r"length: received 0\.0, needs"):
        export(stored, tmp_path / "out", "buoy", length=0.0)
    coupled = elastic.inertia_matrix + 10.0 * (np.eye(3, k=1) + np.eye(3, k=-1))
    database.save_database(elastic.assign(inertia_matrix=coupled), None, stored)
    with pytest.raises(DatabaseError, match="couples rigid and generalized modes"):
        export(stored, tmp_path / "out", "buoy")
    with pytest.raises(DatabaseError, match="needs 'c'"):
        export(stored, tmp_path / "out", "buoy", expected_id="c")
    files.save(elastic.drop_attrs().assign_attrs(spec_id="c"), tmp_path / "block.nc")
    with pytest.raises(DatabaseError, match=r"block\.nc: holds no separate_sweep; needs a hydro database"):
        export(tmp_path / "block.nc", tmp_path / "out", "buoy")
    assert not (tmp_path / "out").exists()


def test_an_interrupted_file_leaves_the_old_one(tmp_path):
    path = tmp_path / "buoy.h5"
    path.write_text("old")
    with pytest.raises((TypeError, ValueError)):
        write_h5({"/first": np.ones((1, 1)), "/second": object()}, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
