"""BEMIO's .h5 file written and read."""

import re
from itertools import pairwise
from types import SimpleNamespace

import netCDF4
import numpy as np
import pytest
from hydro.formats.test_exchange import DAMPING, PAIR, WATER, WAVE, random_database, with_structure
from scipy.integrate import quad
from scipy.interpolate import CubicSpline
from scipy.linalg import block_diag

from vsb.cli import main
from vsb.errors import DatabaseError
from vsb.hydro.formats.bemio import (
    _edges,
    _Entries,
    _labels,
    _round_below,
    bemio_entries,
    excitation_response,
    impulse_times,
    read_bemio,
    write_h5,
)
from vsb.hydro.formats.capytaine import read_capytaine
from vsb.hydro.retardation import DampingSpectrum
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
    whole = re.escape(str(path))
    with pytest.raises(DatabaseError, match=rf"^{whole}: cannot be read: .*No such file.*; needs BEMIO's \.h5 file"):
        read_bemio(path)
    path.write_bytes(b"no HDF5")
    with pytest.raises(DatabaseError, match=rf"^{whole}: cannot be read: .*Unknown file format"):
        read_bemio(path)
    entries = bemio_entries(elastic, "memory")
    write_h5(changed(entries, inf_freq=None), path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: holds no /body1/hydro_coeffs/added_mass/inf_freq; needs"):
        read_bemio(path)
    write_h5(changed(entries, dof=np.array([[9.0]])), path)
    with pytest.raises(
        DatabaseError, match=rf"^{whole}: holds 9 degrees of freedom; needs 8 for its mode_labels \['Heave', 'Mem"
    ):
        read_bemio(path)
    write_h5(changed(entries, mode_labels=None, dof=np.array([[9.0]])), path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: .*added_mass/all has shape \(8, 8, 6\); needs \(9, 9, 6\)"):
        read_bemio(path)
    write_h5(entries | {"/body2/properties/name": "other"}, path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: holds no /body2/properties/dof; needs BEMIO's \.h5 file"):
        read_bemio(path)
    write_h5({place: value for place, value in entries.items() if not place.startswith("/body1/")}, path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: holds no /body1/properties/dof; needs BEMIO's \.h5 file"):
        read_bemio(path)
    write_h5(changed(entries, water_depth=np.zeros((1001, 1))), path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: .*water_depth has shape \(1001, 1\); needs a short text\.$"):
        read_bemio(path)
    write_h5(entries | {"/body3/properties/name": "other"}, path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: holds body1, body3; needs body1, body2, \.\.\. without a gap"):
        read_bemio(path)
    write_h5(changed(entries, inf_freq=np.full((8, 8), np.nan)), path)
    with pytest.raises(DatabaseError, match=rf"^{whole}: variable added_mass_inf holds NaN"):
        read_bemio(path)


def test_h5_of_an_unfit_database_is_refused(elastic):
    bare = elastic.drop_vars("inertia_matrix").drop_attrs().assign_attrs(WATER, radius=2.0, centre_height=0.0)
    with pytest.raises(DatabaseError, match="memory: holds no inertia_matrix and structural_stiffness; generalized"):
        bemio_entries(bare, "memory")
    with pytest.raises(DatabaseError, match="memory: holds no added_mass_inf; needs a complete hydro database"):
        bemio_entries(elastic.drop_vars("added_mass_inf"), "memory")
    for name in ("inertia_matrix", "gas_stiffness"):
        coupled = elastic[name] + 10.0 * (np.eye(3, k=1) + np.eye(3, k=-1))
        total = "inertia_matrix" if name == "inertia_matrix" else "structural_stiffness"
        with pytest.raises(DatabaseError, match=f"memory: {total} couples rigid and generalized modes, which WEC-Sim"):
            bemio_entries(elastic.assign({name: coupled}), "memory")


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


def test_a_file_of_two_bodies_is_read_with_all_that_couples_them(tmp_path):
    entries, whole, restoring = of_two_bodies()
    write_h5(entries, tmp_path / "rm3.h5")
    ds = read_bemio(tmp_path / "rm3.h5")
    rigid = ["Surge", "Sway", "Heave", "Roll", "Pitch", "Yaw"]
    labels = [f"float__{name}" for name in rigid] + [f"spar__{name}" for name in [*rigid, "Mode7", "Mode8"]]
    assert ds.influenced_dof.values.tolist() == labels
    assert ds.added_mass.values == pytest.approx(1000 * np.moveaxis(whole["hydro_coeffs/added_mass/all"], -1, 0))
    omega = np.arange(1.0, 6.0)[:, None, None]
    damping = 1000 * omega * np.moveaxis(whole["hydro_coeffs/radiation_damping/all"], -1, 0)
    assert ds.radiation_damping.values == pytest.approx(damping)
    assert ds.inertia_matrix.values == pytest.approx(whole["properties/mass"])
    force = (whole["hydro_coeffs/excitation/re"] - 1j * whole["hydro_coeffs/excitation/im"]).T * 1e4
    assert ds.excitation_force.values == pytest.approx(force)
    assert ds.hydrostatic_stiffness.values == pytest.approx(1e4 * block_diag(*restoring))
    assert (ds.attrs["displaced_volume_float"], ds.attrs["displaced_volume_spar"]) == (7.0, 8.0)
    assert "centre_of_mass" not in ds.attrs


@pytest.mark.parametrize("names", [("one body", "spar"), ("float", "float"), ("a__b", "c")])
def test_bodies_whose_names_are_none_have_numbers(names, tmp_path):
    write_h5(of_two_bodies(names)[0], tmp_path / "rm3.h5")
    assert read_bemio(tmp_path / "rm3.h5").influenced_dof.values[[0, 6]].tolist() == ["body1__Surge", "body2__Surge"]


@pytest.mark.parametrize("lacking", ["body1", "body2"])
def test_a_matrix_of_one_of_two_bodies_alone_is_refused(tmp_path, lacking):
    entries, *_ = of_two_bodies()
    del entries[f"/{lacking}/properties/mass"]
    write_h5(entries, tmp_path / "rm3.h5")
    with pytest.raises(DatabaseError, match=rf"rm3\.h5: holds no /{lacking}/properties/mass; needs BEMIO's \.h5 file"):
        read_bemio(tmp_path / "rm3.h5")


def test_two_bodies_are_not_written_as_one(tmp_path):
    write_h5(of_two_bodies()[0], tmp_path / "rm3.h5")
    with pytest.raises(DatabaseError, match=r"float__Surge, .*: are of several bodies; needs those of one"):
        bemio_entries(read_bemio(tmp_path / "rm3.h5"), "memory")


@pytest.mark.parametrize("name", ["inertia_matrix", "structural_stiffness"])
def test_modes_couple_where_they_do_by_more_than_round_off_of_the_largest_entry(elastic, name):
    """A billionth of it, whatever the unit; of rigid motions and modes, either side of the diagonal."""
    size = 1e-9 * (elastic.prestress_stiffness + elastic.gas_stiffness if "stiff" in name else 0.0 * elastic[name])
    largest = float(abs(elastic[name] + size * 1e9).max())
    for part in (1e-6, 1.0):
        ds = elastic.assign({key: part * elastic[key] for key in (name, "prestress_stiffness", "gas_stiffness")})
        entry = np.zeros((3, 3))
        entry[0, 2] = entry[2, 0] = 1e-9 * part * largest
        bemio_entries(ds.assign({name: ds[name] + 0.9 * entry}), "memory")
        with pytest.raises(DatabaseError, match=f"memory: {name} couples rigid and generalized modes"):
            bemio_entries(ds.assign({name: ds[name] - 1.1 * entry}), "memory")  # as much the other way
        with pytest.raises(
            DatabaseError, match=f"memory: {name} couples rigid and generalized modes, which WEC-Sim dro"
        ):
            bemio_entries(ds.assign({name: ds[name] + 1.1 * entry}), "memory")


def test_a_file_of_three_bodies_of_unequal_sizes_is_read_with_all_that_couples_them(tmp_path):
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


def test_parts_of_the_excitation_with_any_nan_are_left_out(elastic, tmp_path):
    entries, place = bemio_entries(elastic, "memory"), "/body1/hydro_coeffs/excitation"
    for part in ("scattering/re", "froude-krylov/im"):
        entries[f"{place}/{part}"] = entries[f"{place}/{part}"].copy()
        entries[f"{place}/{part}"][7, 1, 3] = np.nan
    write_h5(entries, tmp_path / "some.h5")
    assert {"diffraction_force", "Froude_Krylov_force"} & {*read_bemio(tmp_path / "some.h5").data_vars} == set()
    entries[f"{place}/re"][2, 0, 1] = np.nan  # of the excitation itself
    write_h5(entries, tmp_path / "some.h5")
    with pytest.raises(DatabaseError, match="variable excitation_force holds NaN"):
        read_bemio(tmp_path / "some.h5")


@pytest.mark.parametrize(("dof", "known"), [(5, False), (6, True), (1000, True), (1001, False), (7.5, False)])
def test_a_body_has_six_degrees_of_freedom_or_up_to_a_thousand(dof, known):
    found = SimpleNamespace(source="a.h5", text=lambda place: "")
    if known:
        assert len(_labels(found, "body1", float(dof))) == dof
        return
    with pytest.raises(DatabaseError, match=rf"a\.h5: holds {dof:g} degrees of freedom; needs six rigid and a few"):
        _labels(found, "body1", float(dof))


@pytest.mark.parametrize("time", [(-40.0, -35.5, 1.0), (40.0, 12.5, -1.0)])
def test_the_excitation_responds_at_late_and_early_times_alike(time):
    """Frequencies far apart, times long before and after zero; by adaptive quadrature."""
    omega = np.array([0.7, 1.0])
    force = ((2.0 - omega) + 0.5j * omega)[:, None, None]
    both = np.concatenate([-omega[::-1], omega])
    spline = CubicSpline(both, np.concatenate([force[::-1], force.conj()])[:, 0, 0])
    expected = [
        quad(lambda w, t=t: np.real(spline(w) * np.exp(1j * w * t)), 0.0, 1.0, limit=200, epsabs=1e-12)[0] / np.pi
        for t in time
    ]
    found = excitation_response(omega, force, np.array(time))[:, 0, 0]
    assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("part", "step"), [(0.99, 0.05), (1.01, 0.1)])
def test_times_are_those_of_a_hemisphere_of_the_bodys_displacement(elastic, part, step):
    """Of 2/3 pi r^3 m^3, at whose radius 0.23 sqrt(r/g) is a tenth of a second."""
    radius = 10.0 * (0.1 / 0.23) ** 2
    volume = 2 / 3 * np.pi * radius**3 * part
    facts = {"displaced_volume": volume, "centre_of_buoyancy": [0.0, 0.0, -1.0], "centre_of_mass": [0.0, 0.0, 0.0]}
    entries = bemio_entries(elastic.assign_attrs(facts), "memory")
    place = "/body1/hydro_coeffs/{}/impulse_response_fun/t"
    radiated, excited = (entries[place.format(name)][:, 0] for name in ("radiation_damping", "excitation"))
    assert (radiated[0], radiated[1], radiated[-1]) == (0.0, pytest.approx(step), pytest.approx(1000 * step))
    assert excited == pytest.approx(np.concatenate([-radiated[::-1], radiated[1:]]))


@pytest.mark.parametrize(
    ("bound", "below"), [(0.2, 0.2), (0.19999, 0.1), (0.5, 0.5), (0.4999, 0.2), (1.0, 1.0), (0.99, 0.5), (73.0, 50.0)]
)
def test_steps_are_the_largest_of_one_two_and_five_not_above_a_bound(bound, below):
    assert _round_below(bound) == below


@pytest.mark.parametrize("last", [0.1, 7.0, 50.0])
def test_no_frequencies_are_further_apart_than_ten_over_the_last_time(last):
    omega = np.array([0.3, 0.45, 1.7, 4.0])
    found = _edges(omega, last)
    assert np.isin(omega, found).all()
    assert (found[0], found[-1]) == (0.3, 4.0)
    counts = [np.count_nonzero((found >= a) & (found < b)) for a, b in pairwise(omega)]
    assert counts == [max(1, int(np.ceil(round((b - a) * last / 10, 9)))) for a, b in pairwise(omega)]
    assert np.diff(found).max() <= 10 / last + 1e-12


UNITS = {
    "m/s^2": ["g"], "kg/m^3": ["rho"], "s": ["T", "radiation_damping/impulse_response_fun/t"], "rad/s": ["w"],
    "deg": ["wave_dir"], "m": ["water_depth", "cg", "cb"], "kg": ["mass"], "kg/s": ["damping"], "N/m": ["stiffness"],
    "m^3": ["disp_vol", "added_mass/all", "radiation_damping/all", "inf_freq"], "m^3/s^2": ["K"], "rad": ["phase"],
    "m^2/s": ["f"], "m^2": ["linear_restoring_stiffness", "excitation/re", "scattering/im", "froude-krylov/mag"],
    "": ["scaled", "dof", "body_number", "name", "code"],
}  # fmt: skip


def test_every_dataset_has_its_unit(bemio, elastic):
    places = list(bemio_entries(elastic, "memory"))
    for unit, ends in UNITS.items():
        for end in ends:
            found = {bemio[place].units for place in places if place.endswith(f"/{end}")}
            assert found == {unit}, end


def test_more_than_nine_bodies_are_read_in_their_order_and_other_groups_are_none(tmp_path):
    names = tuple(f"part{k}" for k in range(1, 12))
    entries, *_ = of_two_bodies(names, (6,) * 11, frequencies=2)
    write_h5(entries | {"/body_mesh/name": "none", "/body1old/name": "none"}, tmp_path / "many.h5")
    labels = read_bemio(tmp_path / "many.h5").influenced_dof.values.tolist()
    assert labels[::6] == [f"{name}__Surge" for name in names]


def test_a_short_text_has_a_thousand_letters_at_most():
    for count in (1000, 1001):
        letters = np.full((count, 1), "a")
        found = _Entries(SimpleNamespace(groups={}, variables={"name": letters}), "a.h5")
        if count == 1000:
            assert found.text("/name") == "a" * 1000
            assert found.text("/other") == ""
            continue
        with pytest.raises(DatabaseError, match=r"^a.h5: /name has shape \(1001, 1\); needs a short text\.$"):
            found.text("/name")


def test_numbers_are_read_in_the_order_of_their_dimensions_alone():
    """As many in another order would be read as others; dimensions of one are none."""
    values = np.arange(6.0).reshape(1, 2, 3)
    found = _Entries(SimpleNamespace(groups={}, variables={"name": values}), "a.h5")
    np.testing.assert_array_equal(found.numbers("/name", 2, 3, 1), values.reshape(2, 3, 1))
    for shape in ((3, 2), (6,), (2, 4)):
        with pytest.raises(
            DatabaseError, match=rf"^a.h5: /name has shape \(1, 2, 3\); needs {re.escape(str(shape))}\.$"
        ):
            found.numbers("/name", *shape)


class Unread:
    """A variable that must not be read."""

    def __init__(self, *shape):
        self.shape = shape

    def __getitem__(self, _):
        raise InterruptedError


@pytest.mark.parametrize(
    ("shape", "refused"), [((10**4, 10**4), False), ((10**4, 10**4, 1, 2), True), ((10**8 + 1,), True)]
)
def test_a_dataset_has_a_hundred_million_numbers_at_most(shape, refused):
    found = _Entries(SimpleNamespace(groups={}, variables={"name": Unread(*shape)}), "a.h5")
    if not refused:
        with pytest.raises(InterruptedError):
            found.numbers("/name")
        return
    with pytest.raises(DatabaseError, match=r"^a.h5: /name has shape \(.*\); needs at most 100000000 numbers\.$"):
        found.numbers("/name")


def test_one_generalized_mode_alone_needs_its_inertia_and_stiffness(elastic):
    """The first of them is the seventh mode."""
    with pytest.raises(DatabaseError, match="memory: holds no inertia_matrix and structural_stiffness; generalized"):
        bemio_entries(random_database(modes=1), "memory")
    assert bemio_entries(with_structure(random_database(modes=1)), "memory")["/body1/properties/mass"][6, 6] == 100.0


@pytest.mark.parametrize("name", ["inertia_matrix", DAMPING, "structural_stiffness"])
@pytest.mark.parametrize("place", [(0, 2), (2, 0)])
def test_what_couples_a_rigid_motion_and_a_mode_on_one_side_alone_is_refused(elastic, name, place):
    """Of what follows or does not act back; each entry is dropped by WEC-Sim."""
    ds = elastic.assign({DAMPING: (PAIR, np.diag([0.0, 1.0, 2.0]))})
    bemio_entries(ds, "memory")
    coupling = np.zeros((3, 3))
    coupling[place] = -0.1 * float(abs(ds[name]).max())
    with pytest.raises(DatabaseError, match=f"memory: {name} couples rigid and generalized modes, which WEC-Sim drops"):
        bemio_entries(ds.assign({name: ds[name] + coupling}), "memory")


def test_what_a_group_does_not_hold_is_not_looked_for_elsewhere(tmp_path):
    """Excitation that was not split into parts is none of them."""
    inner = SimpleNamespace(groups={}, variables={"x": "inner"})
    found = _Entries(SimpleNamespace(groups={"a": inner}, variables={"x": "outer"}), "a.h5")
    assert [found.find(place) for place in ("/x", "/a/x", "/b/x", "/a/b/x", "/a/y")] == [
        "outer",
        "inner",
        None,
        None,
        None,
    ]
    write_h5(of_two_bodies()[0], tmp_path / "rm3.h5")
    assert {"Froude_Krylov_force", "diffraction_force"} & {*read_bemio(tmp_path / "rm3.h5").data_vars} == set()


RIGHT = {"T": "periods of", "mag": "moduli of", "phase": "phases of"}


@pytest.mark.parametrize("name", RIGHT)
def test_what_a_file_tells_twice_must_agree(elastic, tmp_path, name):
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


@pytest.mark.parametrize("damage", DAMAGES)
def test_each_fault_of_a_file_of_others_is_seen(ball, tmp_path, damage):
    """Of a hemisphere solved by capytaine: a check of its own is no longer ok."""
    entries = bemio_entries(read_capytaine(ball), "ball")
    for name, changes in (("sound", {}), ("damaged", DAMAGES[damage](entries))):
        write_h5(entries | changes, tmp_path / f"{name}.h5")
        checks, _, _ = import_bemio(str(tmp_path / f"{name}.h5"), str(tmp_path / "o.nc"), axisymmetric=False)
        verdicts = {check.name: check.verdict for check in checks}
        assert (verdicts.get(SEEN[damage], "ok") == "ok") == (name == "sound"), verdicts
    assert verdicts[SEEN[damage]] == ("doubt" if damage[:6] in ("stiffn", "volume", "centre") else "fail")


def test_added_mass_of_nothing_is_one_line(ball, tmp_path, capsys):
    entries = bemio_entries(read_capytaine(ball), "ball")
    nothing = {place: 0.0 * value for place, value in entries.items() if "/added_mass/" in place}
    write_h5(entries | nothing, tmp_path / "a.h5")
    assert main(["import-bemio", str(tmp_path / "a.h5"), str(tmp_path / "o.nc")]) == 2
    assert "added mass is zero for all motions; needs coefficients of waves" in capsys.readouterr().err
    assert not (tmp_path / "o.nc").exists()
