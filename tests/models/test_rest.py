"""The shell a study is linearised about: equilibrium, stability, gas, and BEM on the deformed shape."""

import numpy as np
import pytest
from conftest import varied

from vsb.engine.hydro.panels import mesh as meshing
from vsb.engine.motion.port import port_direction
from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.loaded import equilibrium
from vsb.engine.shell.modes import mode_basis
from vsb.errors import ConfigError
from vsb.models.rest import (
    carries_load,
    check_rests,
    check_spring,
    check_stable,
    computed_buckling,
    design_stiffness,
    loaded_shell,
    reference_shell,
    seen_by_take_off,
    study_basis,
)
from vsb.pipeline.graph import StudyPlan
from vsb.stages.preview import check

RHO, G = 1025.0, 9.81


@pytest.fixture(scope="module")
def pressurised(seed):
    """The seed's shell at an internal pressure that carries it."""
    return varied(
        seed,
        device={"internal_pressure": 16.5e3},
        modes={"basis": "full", "degree": 4},
        reference_shape="equilibrium",
    )


def test_vented_undeformed_shell_is_that_of_the_publication(seed):
    reference = reference_shell(seed)
    basis = study_basis(seed)
    assert set(reference.stiffness) == {"structural", "hydrostatic"}
    assert reference.stiffness["structural"] == pytest.approx(basis.stiffness, rel=1e-14)
    hydrostatic = DeformedShell(basis, seed.centre_height).hydrostatic_stiffness(RHO, G)
    assert reference.stiffness["hydrostatic"] == pytest.approx(hydrostatic, abs=1e-9 * np.abs(hydrostatic).max())
    assert np.all(reference.modal_amplitude == 0.0)
    assert reference.keel_depth == pytest.approx(seed.draft, rel=1e-14)


def test_trapped_gas_stiffens_the_breathing_mode_by_its_bulk_modulus(seed):
    gas = reference_shell(varied(seed, device={"gas": {}})).stiffness["gas"]
    area, volume = 4 * np.pi * 4.0, 4 / 3 * np.pi * 8.0
    assert gas[1, 1] == pytest.approx(1.4 * 101325.0 * area**2 / volume, rel=1e-12)
    gas[1, 1] = 0.0
    assert np.abs(gas).max() < 1e-6  # no other mode changes the volume of a sphere to first order


def test_at_the_equilibrium_forces_vanish_and_the_stiffness_is_the_tangent(pressurised):
    reference = reference_shell(pressurised)
    loaded = loaded_shell(pressurised, reference.basis)
    weight = pressurised.device.mass * G
    assert np.abs(loaded.force(reference.modal_amplitude)).max() < 1e-9 * weight
    assert reference.shape.volume() * RHO == pytest.approx(pressurised.device.mass, rel=1e-10)
    tangent = loaded.stiffness(reference.modal_amplitude)
    assert reference.total == pytest.approx(tangent, abs=1e-10 * np.abs(tangent).max())
    check_stable(pressurised, reference)


@pytest.mark.parametrize("degree", [4, 30, 60])
def test_the_equilibrium_in_any_basis_is_that_to_which_the_load_leads(pressurised, degree):
    """In fewer modes than the basis that resolves buckling has, and in more."""
    study = varied(pressurised, device={"thickness": 0.05, "young_modulus": 4e7}, modes={"degree": degree})
    found = reference_shell(study)
    led = equilibrium(loaded_shell(study, study_basis(study)))
    assert found.modal_amplitude == pytest.approx(led, abs=1e-9)


def test_buckling_shell_has_no_equilibrium(seed):
    """Seven membrane modes alone would not detect it."""
    with pytest.raises(ConfigError, match=r"reference_shape: received 'equilibrium', but the shell buckles at 0\.01"):
        reference_shell(varied(seed, reference_shape="equilibrium"))


def test_trapped_gas_supports_a_soft_shell_less_than_a_reservoir(seed):
    carried = varied(seed, device={"internal_pressure": 2e4})
    trapped = varied(carried, device={"gas": {}})
    assert (carries_load(carried), carries_load(trapped)) == (True, False)
    assert computed_buckling(trapped).load_factor < 0.1 < 1.0 < computed_buckling(carried).load_factor


def test_an_unstable_design_is_refused(seed):
    """Crushed by vacuum."""
    crushed = varied(seed, device={"internal_pressure": -60e3}, modes={"basis": "full", "degree": 6})
    with pytest.raises(
        ConfigError, match=r"design FSB is unstable|design VSWEC is unstable .* internal_pressure -60000 Pa"
    ):
        check_stable(crushed, reference_shell(crushed))


@pytest.mark.parametrize("model", [{"model": "body_exact"}, {"model": "assumed_pressure", "pressure": 10.0}])
def test_shell_that_collapses_in_still_water_is_refused(seed, model):
    soft = varied(seed, device={"young_modulus": 1e6}, modes={"degree": 2})
    check_rests(soft, reference_shell(soft))  # linear: it needs no rest
    carried = varied(seed, modes={"degree": 2}, hydro=model)
    check_rests(carried, reference_shell(carried))
    yields = varied(soft, hydro=model)
    with pytest.raises(ConfigError, match=r"hydro.model: received '.*' for design VSWEC, but the loaded buoy does not"):
        check_rests(yields, reference_shell(yields))


def deformed(seed, height=0.0, **by_label):
    basis = mode_basis(seed.device, "full", 4)
    return DeformedShell(basis, height, np.array([by_label.get(label, 0.0) for label in basis.labels]))


@pytest.mark.parametrize(
    ("shell", "sphere"),
    [({"height": 0.3}, (2.0, 0.3)), ({"Heave": 0.3}, (2.0, 0.3)), ({"height": 0.2, "Membrane0": 0.25}, (2.25, 0.2))],
    ids=["raised", "heaved", "inflated"],
)
def test_mesh_of_a_deformed_sphere_is_that_of_the_sphere(seed, shell, sphere):
    ours = meshing.deformed_mesh(deformed(seed, **shell), 12, 24, 6)
    theirs = meshing.mean_mesh(*sphere, 12, 24, 6)
    for name in theirs.data_vars:
        assert ours[name].values == pytest.approx(theirs[name].values, abs=1e-12), name


def test_gas_in_front_of_a_take_off_becomes_a_chamber(seed):
    study = varied(seed, device={"gas": {"adiabatic_index": 1.4}}, modes={"degree": 2}, pto={"port": "volume"})
    whole = reference_shell(study)
    opened, chamber = seen_by_take_off(study, whole)
    volume = 4 / 3 * np.pi * 2.0**3
    assert chamber == pytest.approx(volume / (1.4 * 101325.0), rel=1e-9)  # V/(kappa p)
    assert opened.total + whole.stiffness["gas"] == pytest.approx(whole.total, rel=1e-12)
    elsewhere = varied(study, pto={"port": "heave"})
    assert seen_by_take_off(elsewhere, whole) == (whole, 0.0)


def test_softest_spring_behind_a_chamber(seed):
    study = varied(seed, device={"gas": {"adiabatic_index": 1.4}}, modes={"degree": 2}, pto={"port": "volume"})
    reference = reference_shell(study)
    opened, chamber = seen_by_take_off(study, reference)
    b = port_direction("volume", reference.shape)
    least = -1 / (chamber + b @ np.linalg.solve(opened.total, b))
    check_spring(varied(study, pto={"stiffness": float(0.999 * least)}), reference)
    with pytest.raises(
        ConfigError, match=r"pto.stiffness: received -[\d.]+ N/m, which makes the buoy statically unstable"
    ):
        check_spring(varied(study, pto={"stiffness": float(1.001 * least)}), reference)


def test_shell_supported_by_its_gas_only_is_unstable_when_vented(seed):
    crushed = varied(
        seed, device={"gas": {"adiabatic_index": 1.4}, "young_modulus": 1e5, "internal_pressure": -9e4},
        modes={"degree": 0}, designs={"VSWEC": {}},
    )  # fmt: skip
    check_stable(crushed, reference_shell(crushed))
    opened = varied(crushed, pto={"port": "volume"})
    with pytest.raises(ConfigError, match=r"device: the shell of design VSWEC is unstable"):
        check_stable(opened, seen_by_take_off(opened, reference_shell(opened))[0])
    with pytest.raises(ConfigError, match=r"device: the shell of design VSWEC is unstable"):
        check(StudyPlan(opened))


@pytest.mark.parametrize("k", [-1e4, 0.0, 3e4])
def test_least_stiffness_of_a_design_with_a_spring(seed, k):
    reference = reference_shell(seed)
    beside = k * np.eye(len(reference.basis.labels), 1) @ np.eye(1, len(reference.basis.labels))
    rigid = RHO * G * np.pi * (seed.device.radius**2 - seed.centre_height**2)
    assert design_stiffness(seed, reference, "FSB", beside) == pytest.approx(rigid + k, rel=1e-9)
    clamped = reference.basis.clamped([np.pi / 2])
    expected = np.linalg.eigvalsh(clamped.T @ (reference.total + beside) @ clamped)[0]
    assert design_stiffness(seed, reference, "VSWEC90", beside) == pytest.approx(expected, rel=1e-9)


def test_mooring_limits_a_negative_spring_on_surge(seed):
    study = varied(
        seed,
        motion="planar",
        device={"centre_of_mass": -0.5, "ballast_inertia": 8e3},
        designs={"FSB": {"flexible": False}},
        pto={"port": "surge"},
    ).model_copy(update={"mooring": np.diag([2e4, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()})
    reference = reference_shell(study)

    def with_spring(stiffness):
        return study.model_copy(update={"pto": study.pto.model_copy(update={"stiffness": stiffness})})

    check_spring(with_spring(-19990.0), reference)
    with pytest.raises(
        ConfigError, match=r"received -20010 N/m, which makes the buoy statically unstable; needs more than -20000"
    ):
        check_spring(with_spring(-20010.0), reference)
