"""The shell a study is linearised about, and BEM on its shape at rest."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import varied

from vsb.errors import ConfigError, ConvergenceError
from vsb.hydro import database, dofs, quality
from vsb.hydro.panels import mesh as meshing
from vsb.hydro.panels import rings as bem
from vsb.motion.port import port_direction
from vsb.scenes import rest
from vsb.scenes.directions import loaded_shell, order_bases
from vsb.scenes.rest import (
    check_equilibrium,
    check_rests,
    check_spring,
    check_stable,
    complete_loaded_shell,
    computed_buckling,
    design_stiffness,
    reference_shell,
    seen_by_take_off,
    study_basis,
)
from vsb.shell.deformed import DeformedShell
from vsb.shell.loaded import equilibrium
from vsb.shell.modes import mode_basis, rigid_basis
from vsb.stages.preview import check_before_run
from vsb.study.plan import StudyPlan
from vsb.study.quantities import is_rigid

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


def test_vented_and_undeformed_is_the_papers_shell(seed):
    reference = reference_shell(seed)
    basis = study_basis(seed)
    assert set(reference.stiffness) == {"structural", "hydrostatic"}
    assert reference.stiffness["structural"] == pytest.approx(basis.stiffness, rel=1e-14)
    hydrostatic = DeformedShell(basis, seed.centre_height).hydrostatic_stiffness(RHO, G)
    assert reference.stiffness["hydrostatic"] == pytest.approx(hydrostatic, abs=1e-9 * np.abs(hydrostatic).max())
    assert np.all(reference.modal_amplitude == 0.0)
    assert reference.keel_depth == pytest.approx(seed.draft, rel=1e-14)


def test_internal_pressure_brings_its_prestress(seed):
    reference = reference_shell(varied(seed, device={"internal_pressure": 1e3}))
    assert set(reference.stiffness) == {"structural", "hydrostatic", "prestress"}
    prestress = reference.stiffness["prestress"]
    assert np.abs(prestress[0]).max() < 1e-9 * np.abs(prestress).max()  # rigid heave neither strains nor swells


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


def test_a_stiff_shell_rests_as_a_sphere(pressurised):
    sizes = []
    moduli = np.array([1e10, 1e11, 1e12, 1e13])
    for modulus in moduli:
        reference = reference_shell(varied(pressurised, device={"young_modulus": float(modulus)}))
        sizes.append(np.abs(reference.modal_amplitude[1:]).max())
    slopes = np.diff(np.log(sizes)) / np.diff(np.log(moduli))
    assert np.all(np.abs(slopes + 1.0) < 0.05), slopes


def test_a_shell_that_buckles_has_no_equilibrium_to_be_linear_about(seed):
    """Seven membrane modes alone would not notice."""
    with pytest.raises(ConfigError, match=r"reference_shape: received 'equilibrium', but the shell buckles at 0\.01"):
        check_equilibrium(varied(seed, reference_shape="equilibrium"))
    with pytest.raises(ConfigError, match=r"reference_shape: received 'equilibrium', but the shell buckles at 0\.01"):
        reference_shell(varied(seed, reference_shape="equilibrium"))


def test_trapped_gas_carries_a_soft_shell_less_than_a_reservoir_does(seed):
    """It loses its pressure as the shell gives way: in the basis that resolves buckling as in the study's own."""
    carried = varied(seed, device={"internal_pressure": 2e4})
    trapped = varied(carried, device={"gas": {}})
    check_equilibrium(carried)
    with pytest.raises(ConfigError, match=r"reference_shape: received 'equilibrium', but the shell buckles at 0\.03"):
        check_equilibrium(trapped)
    assert computed_buckling(trapped).load_factor < 0.1 < 1.0 < computed_buckling(carried).load_factor


def test_an_unstable_design_is_refused(seed):
    """Pressure far below what the vented shell bears: crushed by vacuum."""
    crushed = varied(seed, device={"internal_pressure": -60e3}, modes={"basis": "full", "degree": 6})
    with pytest.raises(
        ConfigError, match=r"design FSB is unstable|design VSWEC is unstable .* internal_pressure -60000 Pa"
    ):
        check_stable(crushed, reference_shell(crushed))


@pytest.mark.parametrize(
    "model", [{"model": "body_exact"}, {"model": "assumed_pressure", "pressure": 10.0}, {"model": "auto"}]
)
def test_a_shell_that_gives_way_in_the_water_as_it_is_is_refused(seed, model):
    soft = varied(seed, device={"young_modulus": 1e6}, modes={"degree": 2})
    check_rests(soft, reference_shell(soft))  # linear: it needs no rest
    carried = varied(seed, modes={"degree": 2}, hydro=model)
    check_rests(carried, reference_shell(carried))
    yields = varied(soft, hydro=model)
    with pytest.raises(ConfigError, match=r"hydro.model: received '.*' for design VSWEC, but the loaded buoy does not"):
        check_rests(yields, reference_shell(yields))


def test_assumed_pressure_is_for_the_vented_sphere(seed):
    assumed = {"hydro": {"model": "assumed_pressure", "pressure": 10.0}}
    for change in ({"reference_shape": "equilibrium"}, {"device": {"internal_pressure": 5.0}}):
        with pytest.raises(ConfigError, match="is the paper's vented shell about the undeformed sphere"):
            varied(seed, **assumed, **change)
    for idle in ({"accept": ["nonsense"]}, {"rows": 20}, {"omega": [1.0]}):
        with pytest.raises(ConfigError, match=r"has no coefficients to solve or judge; remove it"):
            varied(seed, hydro={**assumed["hydro"], **idle})
    with pytest.raises(ConfigError, match=r"remove device\.gas"):
        varied(seed, **assumed, device={"gas": {}})


# meshes and BEM ---------------------------------------------------------------------------------------------------


def deformed(seed, height=0.0, **by_label):
    basis = mode_basis(seed.device, "full", 4)
    return DeformedShell(basis, height, np.array([by_label.get(label, 0.0) for label in basis.labels]))


@pytest.mark.parametrize(
    ("shell", "sphere"),
    [({"height": 0.3}, (2.0, 0.3)), ({"Heave": 0.3}, (2.0, 0.3)), ({"height": 0.2, "Membrane0": 0.25}, (2.25, 0.2))],
    ids=["raised", "heaved", "inflated"],
)
def test_a_deformed_mesh_of_a_sphere_is_that_spheres(seed, shell, sphere):
    ours = meshing.deformed_mesh(deformed(seed, **shell), 12, 24, 6)
    theirs = meshing.mean_mesh(*sphere, 12, 24, 6)
    for name in theirs.data_vars:
        assert ours[name].values == pytest.approx(theirs[name].values, abs=1e-12), name


def test_a_shape_without_one_waterline_has_no_mesh(seed):
    for height in (2.5, -2.5):
        with pytest.raises(ConfigError, match="needs one waterline with the keel below it"):
            meshing.deformed_mesh(deformed(seed, height), 12, 24, 6)


class TestBem:
    DISPLACEMENTS = (*(f"Radial{n}" for n in range(5)), *(f"Meridional{n}" for n in range(1, 5)))

    def problem(self, green_folder, shell, rows=24):
        mesh = meshing.deformed_mesh(shell, rows, 2 * rows, rows // 2)
        return bem.AxisymmetricProblem(
            bem.green_function(green_folder), mesh, dofs.displacements(self.DISPLACEMENTS), RHO, np.inf, G
        )

    def test_normal_velocities_are_those_of_the_displacements(self, green_folder, seed):
        problem = self.problem(green_folder, deformed(seed, Membrane2=0.2, Bending3=0.1))
        _, n_z = problem.normals
        labels = list(self.DISPLACEMENTS)
        heave = problem.velocities[labels.index("Radial1")] + problem.velocities[labels.index("Meridional1")]
        assert heave == pytest.approx(n_z, abs=1e-14)
        sphere = self.problem(green_folder, deformed(seed, Membrane0=0.2))
        assert np.abs(sphere.velocities[labels.index("Meridional1") :]).max() < 1e-14

    def test_identities_hold_on_a_deformed_shell(self, green_folder, seed):
        """Symmetry, one channel, Haskind: errors of the mesh, that fall with its rows."""
        shell = deformed(seed, 0.1, Membrane2=0.15, Bending2=-0.2)
        found = []
        for rows in (12, 24, 48):
            raw = self.problem(green_folder, shell, rows).solve([1.0, 2.5, 4.0])
            modal = database.with_excitation(database.in_modes(raw, shell.basis))
            haskind = quality.haskind_difference(modal, np.inf, RHO, G)
            found.append([quality.asymmetry(modal), quality.second_channel(modal), haskind])
        found = np.array(found)
        assert np.all(found[-1] < [2e-3, 1e-3, 4e-3]), found
        assert np.all(found[-1] < 0.4 * found[0]), found

    def test_a_spheroid_by_two_bases_is_one_body(self, green_folder, seed):
        """Heave of one shape, reached by other amplitudes of another basis, has the same coefficients."""
        wide = deformed(seed, Membrane2=0.2)
        more = mode_basis(seed.device, "full", 6)
        q = np.array(
            [dict(zip(wide.basis.labels, wide.modal_amplitude, strict=True)).get(label, 0.0) for label in more.labels]
        )
        results = []
        for shell in (wide, replace(wide, basis=more, modal_amplitude=q)):
            raw = self.problem(green_folder, shell).solve([2.0])
            heave = database.in_modes(raw, rigid_basis(seed.device))
            results.append([heave.added_mass.item(), heave.radiation_damping.item()])
        assert results[0] == pytest.approx(results[1], rel=1e-10)

    def test_plan_of_a_study_about_its_equilibrium(self, pressurised):
        pressurised = varied(pressurised, hydro={"solver": "panels"})
        plan = StudyPlan(pressurised)
        block = plan.sweep_blocks[1]
        assert "Meridional4" in block.displacements
        assert block.mesh.reference_shape == "equilibrium"
        assert "damping" not in block.mesh.model_dump()["device"]
        vented = StudyPlan(varied(pressurised, reference_shape="undeformed"))
        assert block.mesh.rows == 1.5 * vented.sweep_blocks[1].mesh.rows


def test_water_and_year_rest_on_one_equilibrium(pressurised, monkeypatch):
    study = varied(pressurised, device={"internal_pressure": 17.1e3})
    undamped = varied(study, device={"damping": {"alpha": 0.0, "beta": 0.0}})
    solved = []
    monkeypatch.setattr(rest, "equilibrium", lambda loaded: solved.append(loaded) or equilibrium(loaded))
    first, second = reference_shell(study), reference_shell(undamped)
    assert len(solved) == 2  # in the study's modes, and in those that resolve its buckling
    np.testing.assert_array_equal(first.modal_amplitude, second.modal_amplitude)
    assert first.basis.beta > 0 == second.basis.beta


def test_gas_that_a_take_off_lets_out_holds_the_shell_no_more(seed):
    study = varied(seed, device={"gas": {"adiabatic_index": 1.4}}, modes={"degree": 2}, pto={"port": "volume"})
    whole = reference_shell(study)
    opened, chamber = seen_by_take_off(study, whole)
    volume = 4 / 3 * np.pi * 2.0**3
    assert chamber == pytest.approx(volume / (1.4 * 101325.0), rel=1e-9)  # V/(kappa p)
    assert opened.total + whole.stiffness["gas"] == pytest.approx(whole.total, rel=1e-12)
    elsewhere = varied(study, pto={"port": "heave"})
    assert seen_by_take_off(elsewhere, whole) == (whole, 0.0)


def test_a_rigid_buoy_has_no_gas_to_let_out(seed):
    """Its volume does not change: no chamber, and a spring of any stiffness there pushes nothing."""
    study = varied(
        seed, device={"gas": {"adiabatic_index": 1.4}}, designs={"FSB": {"flexible": False}}, pto={"port": "volume"}
    )
    whole = reference_shell(study)
    assert seen_by_take_off(study, whole) == (whole, 0.0)
    check_spring(varied(study, pto={"stiffness": -1e9}), whole)


def test_a_spring_behind_a_chamber_may_be_as_soft_as_shell_and_gas_together(seed):
    study = varied(seed, device={"gas": {"adiabatic_index": 1.4}}, modes={"degree": 2}, pto={"port": "volume"})
    reference = reference_shell(study)
    opened, chamber = seen_by_take_off(study, reference)
    b = port_direction("volume", reference.shape)
    least = -1 / (chamber + b @ np.linalg.solve(opened.total, b))
    check_spring(varied(study, pto={"stiffness": float(0.999 * least)}), reference)
    with pytest.raises(ConfigError, match=r"pto.stiffness: received -[\d.]+ N/m, with which a buoy does not rest"):
        check_spring(varied(study, pto={"stiffness": float(1.001 * least)}), reference)


@pytest.mark.parametrize("order", [("FSB", "VSWEC"), ("VSWEC", "FSB")])
def test_the_design_that_yields_most_decides_which_spring_is_refused_in_any_order(seed, order):
    """Under a unit force at heave an elastic buoy yields more than a rigid one, 1/(rho g pi r^2)."""
    study = varied(seed, designs={name: seed.designs[name].model_dump() for name in order})
    reference = reference_shell(study)
    yields = np.linalg.inv(reference.total)[0, 0]
    assert yields > 1.01 / (RHO * G * np.pi * seed.device.radius**2)
    check_spring(varied(study, pto={"stiffness": float(-0.999 / yields)}), reference)
    with pytest.raises(ConfigError, match=rf"with which a buoy does not rest; needs more than {-1 / yields:.6g} N/m"):
        check_spring(varied(study, pto={"stiffness": float(-1.001 / yields)}), reference)


def test_a_shell_that_only_its_gas_holds_does_not_rest_once_that_can_leave(seed):
    crushed = varied(
        seed, device={"gas": {"adiabatic_index": 1.4}, "young_modulus": 1e5, "internal_pressure": -9e4},
        modes={"degree": 0}, designs={"VSWEC": {}},
    )  # fmt: skip
    check_stable(crushed, reference_shell(crushed))
    opened = varied(crushed, pto={"port": "volume"})
    with pytest.raises(ConfigError, match=r"device: the shell of design VSWEC is unstable"):
        check_stable(opened, seen_by_take_off(opened, reference_shell(opened))[0])
    with pytest.raises(ConfigError, match=r"device: the shell of design VSWEC is unstable"):
        check_before_run(opened, StudyPlan(opened))


@pytest.mark.parametrize("gas", [None, {"adiabatic_index": 1.4}])
def test_about_an_equilibrium_the_parts_of_the_stiffness_are_those_of_the_deformed_shell(seed, gas, monkeypatch):
    """With trapped gas as well, which has left its volume; together they are the tangent there."""
    monkeypatch.setattr(rest, "check_equilibrium", lambda study: None)
    device = {"internal_pressure": 9e4, "young_modulus": 4e7, "gas": gas}
    study = varied(seed, device=device, modes={"basis": "full", "degree": 2}, reference_shape="equilibrium")
    reference = reference_shell(study)
    loaded, q = loaded_shell(study, reference.basis), reference.modal_amplitude
    tangent = loaded.stiffness(q)
    assert reference.total == pytest.approx((tangent + tangent.T) / 2, abs=1e-11 * np.abs(tangent).max())
    assert ("gas" in reference.stiffness) == (gas is not None)
    assert np.abs(q[1:]).max() > 0.02
    if gas:
        assert reference.stiffness["gas"] == pytest.approx(loaded.gas_stiffness(q), rel=1e-9)


def test_a_shell_may_be_told_in_another_basis_than_its_own(seed):
    wider = mode_basis(seed.device, "full", 8)
    reference = reference_shell(seed, wider)
    assert reference.basis is wider
    assert reference.total.shape == (len(wider.labels),) * 2
    assert reference_shell(seed).basis.labels == study_basis(seed).labels != wider.labels


def test_a_rigid_buoy_has_no_prestress_and_no_gas_whatever_is_inside_it(seed):
    """Nor modes, though the study tells some."""
    inside = {"internal_pressure": 3e4, "gas": {"adiabatic_index": 1.4}}
    study = varied(seed, device=inside, designs={"FSB": {"flexible": False}, "other": {"flexible": False}})
    reference = reference_shell(study)
    assert reference.basis.labels == ("Heave",)
    assert set(reference.stiffness) == {"structural", "hydrostatic"}


def test_the_shell_that_shows_its_buckling_is_that_of_the_study(seed):
    """Its device, water, height and contents; not its modes."""
    study = varied(
        seed,
        device={"internal_pressure": 4e3, "gas": {"adiabatic_index": 1.3}, "mass": 12e3},
        water={"density": 1010.0, "gravity": 9.7},
    )
    shell = complete_loaded_shell(study)
    assert (shell.internal_pressure, shell.gas, shell.centre_height) == (4e3, study.device.gas, study.centre_height)
    assert (shell.water_density, shell.gravity, shell.basis.total_mass) == (1010.0, 9.7, 12e3)
    assert shell.basis.highest_degree > 40
    own = loaded_shell(study, study_basis(study))
    for name in ("internal_pressure", "gas", "centre_height", "water_density", "gravity"):
        assert getattr(own, name) == getattr(shell, name)


def test_the_design_that_is_unstable_is_named_wherever_it_stands(seed):
    """Clamped at its equator the shell bears a vacuum that crushes it without; told with what it is made of."""
    study = varied(
        seed,
        device={"internal_pressure": -60e3, "young_modulus": 2e7},
        modes={"basis": "full", "degree": 6},
        designs={"first": {"flexible": False}, "second": {}},
    )
    told = (
        r"^device: the shell of design second is unstable \(least stiffness -[\d.e+]+ N/m\) with young_modulus 2e\+07 "
        r"Pa, thickness 0.01 m and internal_pressure -60000 Pa; needs more of one of them$"
    )
    reference = reference_shell(study)
    assert design_stiffness(study, reference, "first") > 0 > design_stiffness(study, reference, "second")
    with pytest.raises(ConfigError, match=told):
        check_stable(study, reference)


@pytest.mark.parametrize("k", [-1e4, 0.0, 3e4])
def test_the_least_stiffness_of_a_design_is_of_what_its_clamps_leave_with_a_spring_beside(seed, k):
    """Of a rigid buoy that of its waterplane and the spring."""
    reference = reference_shell(seed)
    beside = k * np.eye(len(reference.basis.labels), 1) @ np.eye(1, len(reference.basis.labels))
    rigid = RHO * G * np.pi * (seed.device.radius**2 - seed.centre_height**2)
    assert design_stiffness(seed, reference, "FSB", beside) == pytest.approx(rigid + k, rel=1e-9)
    clamped = reference.basis.clamped([np.pi / 2])
    expected = np.linalg.eigvalsh(clamped.T @ (reference.total + beside) @ clamped)[0]
    assert design_stiffness(seed, reference, "VSWEC90", beside) == pytest.approx(expected, rel=1e-9)


def test_clamps_that_leave_no_mode_are_refused_with_those_there_are(seed):
    study = varied(seed, designs={"VSWEC": {}, "held": {"clamp": [0, 40, 80, 120]}})
    reference = reference_shell(study)
    with pytest.raises(
        ConfigError,
        match=r"^designs.held.clamp: received \[0.0, 40.0, 80.0, 120.0\], which leaves none of the 7 shell modes free; ",
    ):
        check_stable(study, reference)


def test_every_design_is_looked_at_whether_it_rests_in_the_water_as_it_is(seed, monkeypatch):
    """In the water of the study, each with its own motions; the one that does not is named."""
    asked = []

    def still(reference, density, gravity, motions):
        asked.append((density, gravity, motions.shape[1]))
        if motions.shape[1] > 1:
            raise ConvergenceError("it sinks")

    monkeypatch.setattr("vsb.motion.builders.still_scene", still)
    study = varied(seed, hydro={"model": "body_exact"}, water={"density": 1010.0, "gravity": 9.7})
    with pytest.raises(ConfigError, match=r"^hydro.model: received 'body_exact' for design VSWEC, but it sinks$"):
        check_rests(study, reference_shell(study))
    assert asked == [(1010.0, 9.7, 1), (1010.0, 9.7, 8)]


@pytest.mark.parametrize(("least", "refused"), [(0.0, True), (-1e-9, True), (1e-9, False)])
def test_a_design_of_no_stiffness_does_not_rest(seed, monkeypatch, least, refused):
    """Whichever of them it is."""
    names = list(seed.designs)
    found = dict.fromkeys(names, 5.0) | {names[-1]: least}
    monkeypatch.setattr(rest, "design_stiffness", lambda study, reference, design: found[design])
    reference = reference_shell(seed)
    if not refused:
        check_stable(seed, reference)
        return
    told = (
        rf"^device: the shell of design {names[-1]} is unstable \(least stiffness {least:.3g} N/m\) with young_modulus"
    )
    with pytest.raises(ConfigError, match=told):
        check_stable(seed, reference)


def test_the_clamps_of_a_design_are_all_of_its_own_in_degrees(seed):
    study = varied(
        seed, modes={"basis": "full", "degree": 5}, designs={"a": {"clamp": 20}, "b": {"clamp": [140, 65, 20]}}
    )
    basis = study_basis(study)
    for design, clamps in (("a", [20.0]), ("b", [140.0, 65.0, 20.0])):
        motions = rest.design_motions(study, basis, design)
        assert motions.shape == (len(basis.labels), len(basis.labels) - 2 * len(clamps))
        np.testing.assert_allclose(basis.clamp_rows(np.pi / 180 * np.array(clamps)) @ motions, 0.0, atol=1e-12)


@pytest.mark.parametrize("inside", [-300.0, 300.0])
def test_pressure_of_either_sign_prestresses_a_shell_about_the_sphere(seed, inside):
    """By as much as the load's own prestress and what the pressure does."""
    study = varied(seed, device={"internal_pressure": inside}, modes={"basis": "full", "degree": 3})
    reference = reference_shell(study)
    expected = loaded_shell(study, reference.basis).prestress_stiffness
    np.testing.assert_allclose(
        reference.stiffness["prestress"], (expected + expected.T) / 2, atol=1e-12 * np.abs(expected).max()
    )
    assert list(reference.stiffness) == ["structural", "hydrostatic", "prestress"]
    for matrix in reference.stiffness.values():
        np.testing.assert_array_equal(matrix, matrix.T)


def planar(seed, **changes):
    """The seed, free to surge and pitch on ballast half a metre below its centre, with a rigid and two shells."""
    designs = {"FSB": {"flexible": False}, "free": {}, "held": {"clamp": [40, 180]}}
    device = {"centre_of_mass": -0.5, "ballast_inertia": 9e3} | changes
    return varied(seed, motion="planar", modes={"degree": 4, "order": 2}, device=device, designs=designs)


def test_a_rigid_design_beside_flexible_ones_moves_in_rigid_motions_of_all_orders_alone(seed):
    """Clamps hold the shell in every order, at their colatitudes."""
    study = planar(seed)
    basis = study_basis(study)
    families = order_bases(study, basis)
    labels = [*basis.labels, *(label for each in families for label in each.labels)]
    rigid, free, held = (rest.design_motions(study, basis, design) for design in study.designs)
    assert [label for label, row in zip(labels, rigid, strict=True) if row.any()] == ["Heave", "Surge", "Pitch"]
    assert [label for label in labels if is_rigid(label)] == ["Heave", "Surge", "Pitch"]
    assert rigid.shape[1] == 3
    np.testing.assert_array_equal(free, np.eye(len(labels)))
    assert held.shape[1] < len(labels)
    begin = 0
    for each in (basis, *families):
        rows = each.clamp_rows(np.deg2rad([40.0, 180.0]))
        assert rows.any()
        np.testing.assert_allclose(rows @ held[begin : begin + len(each.labels)], 0.0, atol=1e-12)
        begin += len(each.labels)


def test_a_buoy_that_falls_over_does_not_rest_whatever_its_shell_does(seed):
    """As a mooring that pushes it away; one that holds it lets it rest."""
    upright, top_heavy = planar(seed), planar(seed, centre_of_mass=0.2)
    check_stable(upright, reference_shell(upright))
    with pytest.raises(ConfigError, match=r"^device.centre_of_mass: received 0.2 m above .* does not stay upright"):
        check_stable(top_heavy, reference_shell(top_heavy))
    pushed = upright.model_copy(update={"mooring": np.diag([-1e3, 0.0, 0.0, 0.0, 0.0, 0.0]).tolist()})
    with pytest.raises(ConfigError, match=r"^mooring: received .* out of its rest, most in surge; needs one"):
        check_stable(pushed, reference_shell(pushed))


@pytest.mark.parametrize(("yields", "stiffness", "rests"), [
    (0.25, -4.0, False), (0.25, -3.999, True), (0.25, -4.001, False), (0.25, 0.0, True), (np.inf, 0.0, True),
    (np.inf, -1e-9, False), (np.inf, 1e-9, True), (0.0, -1e12, True),
])  # fmt: skip
def test_a_spring_just_as_strong_as_what_holds_the_port_holds_nothing(seed, monkeypatch, yields, stiffness, rests):
    """But none at all where nothing else does; where nothing yields any spring will do."""
    monkeypatch.setattr(rest, "compliance", lambda stiffness, direction: yields)
    study, reference = varied(seed, pto={"stiffness": stiffness}), reference_shell(seed)
    if rests:
        check_spring(study, reference)
        return
    least = -1 / yields + 0.0  # no -0 N/m
    told = rf"^pto.stiffness: received {stiffness:g} N/m, with which a buoy does not rest; needs more than {least:.6g} N/m$"
    with pytest.raises(ConfigError, match=told):
        check_spring(study, reference)


def test_a_spring_on_surge_may_be_as_strong_as_the_mooring_that_holds_it(seed):
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
        ConfigError, match=r"received -20010 N/m, with which a buoy does not rest; needs more than -20000"
    ):
        check_spring(with_spring(-20010.0), reference)
