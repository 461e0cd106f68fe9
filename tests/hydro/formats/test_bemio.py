"""BEMIO's .h5 file written and read."""

import netCDF4
import numpy as np
import pytest
from hydro.formats.test_exchange import WAVE, random_database, with_structure
from scipy.linalg import block_diag

from vsb.engine.hydro.formats.bemio import bemio_entries, read_bemio, write_h5
from vsb.engine.hydro.formats.capytaine import read_capytaine
from vsb.engine.hydro.radiation import DampingSpectrum
from vsb.errors import DatabaseError
from vsb.stages.coefficients import import_bemio


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


def changed(entries, **changes):
    """Entries with some replaced, or taken away by None; keys are the ends of paths."""
    ends = {place: next((end for end in changes if place.endswith(f"/{end}")), None) for place in entries}
    replaced = {place: changes[end] if end else entries[place] for place, end in ends.items()}
    assert {end for end in ends.values() if end} == set(changes)
    return {place: value for place, value in replaced.items() if value is not None}


def test_file_without_optional_datasets_is_read(elastic, tmp_path):
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


def test_scaled_files_are_dimensional(elastic, tmp_path):
    write_h5(changed(bemio_entries(elastic, "memory"), scaled=np.array([[1.0]])), tmp_path / "scaled.h5")
    back = read_bemio(tmp_path / "scaled.h5")
    assert back.added_mass.values == pytest.approx(elastic.added_mass.values / 1000)
    assert back.radiation_damping.values[:, 0, 0] == pytest.approx(
        elastic.radiation_damping.values[:, 0, 0] / 1000 / elastic.omega.values
    )
    assert back.excitation_force.values == pytest.approx(elastic.excitation_force.values / 1e4)
    assert back.hydrostatic_stiffness.values == pytest.approx(elastic.hydrostatic_stiffness.values / 1e4)
    assert back.inertia_matrix.values == pytest.approx(elastic.inertia_matrix.values)


def of_two_bodies(names=("float", "spar"), sizes=(6, 8), frequencies=5):
    """A file as WEC-Sim's writeBEMIOH5 lays it out: rows with each body, columns of all, two modes of the second."""
    rng, total = np.random.default_rng(4), sum(sizes)
    whole = {
        "hydro_coeffs/added_mass/all": rng.normal(size=(total, total, frequencies)),
        "hydro_coeffs/added_mass/inf_freq": rng.normal(size=(total, total)),
        "hydro_coeffs/radiation_damping/all": rng.normal(size=(total, total, frequencies)),
        "properties/mass": rng.normal(size=(total, total)),
        "properties/stiffness": rng.normal(size=(total, total)),
        **{f"hydro_coeffs/excitation/{part}": rng.normal(size=(total, 1, frequencies)) for part in ("re", "im")},
    }
    restoring = [rng.normal(size=(n, n)) for n in sizes]
    entries = {
        "/simulation_parameters/scaled": np.array([[0.0]]),
        "/simulation_parameters/g": np.array([[10.0]]),
        "/simulation_parameters/rho": np.array([[1000.0]]),
        "/simulation_parameters/w": np.arange(1.0, frequencies + 1).reshape(-1, 1),
        "/simulation_parameters/wave_dir": np.array([[0.0]]),
        "/simulation_parameters/water_depth": "infinite",
    }
    begin = 0
    for k, (name, size) in enumerate(zip(names, sizes, strict=True)):
        own = {place: values[begin : begin + size] for place, values in whole.items()}
        own |= {"hydro_coeffs/linear_restoring_stiffness": restoring[k], "properties/name": name}
        own |= {"properties/dof": np.array([[float(size)]]), "properties/disp_vol": np.array([[7.0 + k]])}
        entries |= {f"/body{k + 1}/{place}": values for place, values in own.items()}
        begin += size
    return entries, whole, restoring


def test_three_bodies_with_their_coupling(tmp_path):
    """The third begins where the second ends, which has one mode more than the first has."""
    entries, whole, restoring = of_two_bodies(("float", "spar", "plate"), (6, 8, 7))
    write_h5(entries, tmp_path / "three.h5")
    ds = read_bemio(tmp_path / "three.h5")
    assert ds.influenced_dof.values[[0, 5, 6, 13, 14, 20]].tolist() == [
        "float__Surge", "float__Yaw", "spar__Surge", "spar__Mode8", "plate__Surge", "plate__Mode7",
    ]  # fmt: skip
    assert ds.added_mass.values == pytest.approx(1000 * np.moveaxis(whole["hydro_coeffs/added_mass/all"], -1, 0))
    assert ds.structural_stiffness.values == pytest.approx(whole["properties/stiffness"])
    assert ds.hydrostatic_stiffness.values == pytest.approx(1e4 * block_diag(*restoring))
    assert [ds.attrs[f"displaced_volume_{name}"] for name in ("float", "spar", "plate")] == [7.0, 8.0, 9.0]


RIGHT = {"T": "periods of", "mag": "moduli of", "phase": "phases of"}


@pytest.mark.parametrize("name", RIGHT)
def test_contradicting_datasets_are_refused(elastic, tmp_path, name):
    entries = bemio_entries(elastic, "memory")
    (place, *_) = [place for place in entries if place.endswith(f"/{name}")]
    write_h5(entries | {place: 1.01 * entries[place]}, tmp_path / "a.h5")
    with pytest.raises(DatabaseError, match=rf"a\.h5: {place} differs from the {RIGHT[name]} .* at \(.*contradicts"):
        read_bemio(tmp_path / "a.h5")
    if name == "phase":
        write_h5(entries | {place: np.degrees(entries[place])}, tmp_path / "b.h5")
        assert read_bemio(tmp_path / "b.h5").sizes["omega"] == 6


FORCE = "/body1/hydro_coeffs/excitation/"
DAMAGES = {
    "phases": lambda h5: {f"{FORCE}{part}": -h5[f"{FORCE}{part}"] for part in ("im", "phase")},
    "headings": lambda h5: {WAVE_DIR: np.radians(h5[WAVE_DIR])},
    "added mass at infinity x 1.3": lambda h5: {A_INF: 1.3 * h5[A_INF]},
    "no added mass at infinity": lambda h5: {A_INF: 0.0 * h5[A_INF]},
    "stiffness of roll and yaw": lambda h5: {STIFFNESS: h5[STIFFNESS] + 0.3 * (np.arange(36).reshape(6, 6) == 23)},
    "parts": lambda h5: {f"{FORCE}scattering/{part}": 1.1 * h5[f"{FORCE}scattering/{part}"] for part in ("re", "im", "mag")},
    "volume": lambda h5: {VOLUME: 1.5 * h5[VOLUME]},
    "centre": lambda h5: {CENTRE: h5[CENTRE] + np.array([[0.2], [0.0], [0.0]])},
}  # fmt: skip
WAVE_DIR, A_INF = "/simulation_parameters/wave_dir", "/body1/hydro_coeffs/added_mass/inf_freq"
STIFFNESS, VOLUME = "/body1/hydro_coeffs/linear_restoring_stiffness", "/body1/properties/disp_vol"
CENTRE = "/body1/properties/cg"
SEEN = dict(zip(DAMAGES, ("phases", "phases", "kramers_kronig", "kramers_kronig", "hydrostatic_symmetry", "parts",
                          "displaced_volume", "trim"), strict=True))  # fmt: skip


@pytest.fixture
def verdicts_of(ball, tmp_path):
    """Function changes of the entries -> verdicts on the file of a hemisphere solved by capytaine."""
    entries = bemio_entries(read_capytaine(ball), "ball")

    def judge(change):
        write_h5(entries | change(entries), tmp_path / "a.h5")
        checks, _, _ = import_bemio(str(tmp_path / "a.h5"), str(tmp_path / "o.nc"), axisymmetric=False)
        return {check.name: check.verdict for check in checks}

    return judge


@pytest.mark.parametrize("damage", DAMAGES)
def test_each_fault_of_a_file_is_found_by_its_check(verdicts_of, damage):
    expected = "doubt" if damage[:6] in ("stiffn", "volume", "centre") else "fail"
    assert verdicts_of(DAMAGES[damage])[SEEN[damage]] == expected


def test_a_file_without_faults_has_none(verdicts_of):
    sound = verdicts_of(lambda _: {})
    assert {sound.get(name, "ok") for name in SEEN.values()} == {"ok"}
