"""Bodies of panels against matched eigenfunctions, Newman's rigid forms, and boxes by hand."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from verification import wec_sim_barge as wamit
from verification.beam import free_free, stiffness
from verification.cylinder import radiation
from verification.disc import power

RHO, G = 1025.0, 9.81


def database(command, folder: Path, name: str, vertices, faces, shapes: dict, centre, **body) -> xr.Dataset:
    """What `vsb body` makes of a mesh and its displacements."""
    dims = ("part", "xyz") if np.ndim(centre) == 2 else "xyz"
    modes = np.array(list(shapes.values()))
    xr.Dataset(
        {
            "vertices": (("vertex", "xyz"), vertices),
            "faces": (("panel", "corner"), faces),
            "mode_shape": (("dof", "vertex", "xyz"), modes),
            "centre_of_mass": (dims, np.asarray(centre, dtype=float)),
        },
        coords={"dof": list(shapes)},
    ).to_netcdf(folder / f"{name}.nc")
    raw = {"body": name, "mesh": f"{name}.nc", "modes": f"{name}.nc", "wave_direction": [0.0], **body}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(raw), encoding="utf-8")
    command("body", folder / f"{name}.yaml", folder / name)
    with xr.open_dataset(folder / name / f"{name}.nc") as found:
        return found.load()


def cylinder(radius: float, draft: float, counts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Corners and panels of a cylinder's bottom and wall, finer towards its edges; counts around, in r and in z."""
    around, across, down = counts
    angle = 2 * np.pi * np.arange(around) / around
    r = radius * np.sin(np.pi / 2 * np.arange(1, across + 1) / across)
    z = -draft * (1 + np.cos(np.pi * np.arange(1, down + 1) / down)) / 2
    z[-1] = 0.0
    rings = [(q, -draft) for q in r] + [(radius, q) for q in z]
    ring = [[(q * np.cos(t), q * np.sin(t), height) for t in angle] for q, height in rings]
    vertices = np.vstack([[(0.0, 0.0, -draft)], *ring])
    faces = [[0, 1 + (i + 1) % around, 1 + i, 1 + i] for i in range(around)]
    for j in range(len(rings) - 1):
        low, high = 1 + j * around, 1 + (j + 1) * around
        faces += [[low + i, low + (i + 1) % around, high + (i + 1) % around, high + i] for i in range(around)]
    return vertices, np.array(faces)


@pytest.mark.parametrize("lid", [0, None], ids=["no lid", "default lid"])
def test_cylinder(agree, command, tmp_path, lid):
    """Radius 5 m, draft 4 m, water of 12 m; the first irregular frequency of heave is 2.2 rad/s."""
    vertices, faces = cylinder(5.0, 4.0, (48, 8, 10))
    zero, one = np.zeros(len(vertices)), np.ones(len(vertices))
    shapes = {"Surge": np.transpose([one, zero, zero]), "Heave": np.transpose([zero, zero, one])}
    omega = [0.6, 1.2, 1.8] if lid == 0 else [0.6, 1.2, 1.8, 2.2]
    given = {} if lid is None else {"lid": lid}
    water = {"density": RHO, "depth": 12.0, "gravity": G}
    found = database(
        command, tmp_path, "cylinder", vertices, faces, shapes, [0, 0, 0], water=water, omega=omega, **given
    )
    for motion in ("surge", "heave"):
        wanted = np.array([radiation(w, 5.0, 4.0, 12.0, motion, RHO, 200) for w in omega])
        at = {"influenced_dof": motion.capitalize(), "radiating_dof": motion.capitalize()}
        added = found["added_mass"].sel(at).sel(omega=omega)
        damping = found["radiation_damping"].sel(at).sel(omega=omega)
        name = f"{motion} of a cylinder, {'no' if lid == 0 else 'default'} lid"
        agree("bodies, finite depth", f"added mass, {name}", added, wanted[:, 0], 4e-2)
        agree("bodies, finite depth", f"damping, {name}", damping, wanted[:, 1], 4e-2)


def box(start: float, length: float, counts: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Wetted panels of a box from x = start, 10 m wide and 5 m deep."""

    def face(origin, first, second, cells):
        s, t = (np.linspace(0, 1, n + 1) for n in cells)
        corners = np.array([origin + a * first + b * second for a in s for b in t])
        row = cells[1] + 1
        return corners, [
            [i * row + j, (i + 1) * row + j, (i + 1) * row + j + 1, i * row + j + 1]
            for i in range(cells[0])
            for j in range(cells[1])
        ]

    x, y, z = np.diag([length, 10.0, 5.0])
    corner = np.array([start, -5.0, -5.0])
    nx, ny, nz = counts
    sides = [
        face(corner, y, x, (ny, nx)),
        face(corner, x, z, (nx, nz)),
        face(corner + y, z, x, (nz, nx)),
        face(corner, z, y, (nz, ny)),
        face(corner + x, y, z, (ny, nz)),
    ]
    starts = np.cumsum([0] + [len(corners) for corners, _ in sides])
    return np.concatenate([c for c, _ in sides]), np.vstack(
        [np.array(f) + n for (_, f), n in zip(sides, starts, strict=False)]
    )


@pytest.mark.parametrize("fields", ["of a file", "by name"])
def test_bending(fields, agree, command, tmp_path):
    """The shipped barge of 80 x 10 x 5 m: four bending modes and a hinge along the inextensible path."""
    barge = Path(__file__).parents[2] / "config" / "barge" / "barge.nc"
    raw = {"body": "barge", "mesh": str(barge), "modes": str(barge), "omega": [0.8], "wave_direction": [0.0], "lid": 0}
    if fields == "by name":
        raw["modes"] = {"rigid": ["Heave", "Pitch"], "bending": {"count": 4}, "hinge": {"at": [0.0, 0.0]}}
        raw |= {"mass": "displaced", "centre_of_mass": [0.0, 0.0, 0.0], "radii_of_gyration": [3.0, 23.1, 23.1]}
    raw["water"] = {"density": RHO, "depth": float("inf"), "gravity": G}
    (tmp_path / "barge.yaml").write_text(yaml.safe_dump(raw), encoding="utf-8")
    command("body", tmp_path / "barge.yaml", tmp_path / "barge")
    with xr.open_dataset(tmp_path / "barge" / "barge.nc") as found:
        stiff = found["hydrostatic_stiffness"].load()

    def hinge(s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.abs(s) / 20 - 1, np.sign(s) / 20

    shapes = {f"Bending{n}": (free_free(n, 80.0), [-40.0, 40.0]) for n in (1, 2, 3, 4)} | {
        "Hinge": (hinge, [-40.0, 0.0, 40.0])
    }
    for name, (shape, ends) in shapes.items():
        wanted = stiffness(shape, ends, 10.0, 5.0, 0.0, RHO * G)
        own = float(stiff.sel(influenced_dof=name, radiating_dof=name))
        agree(
            "hinges",
            f"still-water stiffness of {name} of a barge, {fields}",
            own,
            wanted,
            1e-6 if name == "Hinge" else 1e-4,
        )


def test_hinge(agree, command, tmp_path):
    """Two boxes hinged between: as a field of its own and as a combination of the parts' rigid motions.

    Newman (1994), Applied Ocean Research 16: each box turns by 0.05 about the middle of its waterplane, rho g (the
    waterplane's second moment - the volume times the depth of its centre), its mass centre lying in the waterplane.
    """
    (v1, f1), (v2, f2) = box(2.0, 38.0, (10, 4, 4)), box(-40.0, 38.0, (10, 4, 4))
    vertices, faces = np.concatenate([v1, v2]), np.concatenate([f1, f2 + len(v1)])
    fore = (np.arange(len(vertices)) < len(v1)).astype(float)
    x, _, z = vertices.T
    zero = np.zeros(len(vertices))

    def pitch(part, centre: float) -> np.ndarray:
        return np.transpose([part * z, zero, -part * (x - centre)])

    aft = 1 - fore
    shapes = {
        "fore__Heave": np.transpose([zero, zero, fore]),
        "aft__Heave": np.transpose([zero, zero, aft]),
        "fore__Pitch": pitch(fore, 21.0),
        "aft__Pitch": pitch(aft, -21.0),
        "Hinge": 0.05 * pitch(aft, -21.0) - 0.05 * pitch(fore, 21.0),
    }
    water = {"density": RHO, "depth": float("inf"), "gravity": G}
    centres = [[21.0, 0, 0], [-21.0, 0, 0]]
    found = database(command, tmp_path, "boxes", vertices, faces, shapes, centres, water=water, omega=[0.8], lid=0)
    stiff = found["hydrostatic_stiffness"].transpose("influenced_dof", "radiating_dof")
    one_box = RHO * G * (10 * 38**3 / 12 - 10 * 5 * 38 * 2.5)
    labels = [str(name) for name in found["influenced_dof"].values]
    mixed = np.array([{"fore__Pitch": -0.05, "aft__Pitch": 0.05}.get(name, 0.0) for name in labels])
    own = stiff.sel(influenced_dof="Hinge", radiating_dof="Hinge")
    agree("hinges", "stiffness by parts' rotations [N/m]", mixed @ stiff.values @ mixed, 2 * one_box * 0.05**2, 1e-6)
    agree("hinges", "stiffness of the hinge's own field [N/m]", float(own), 2 * one_box * 0.05**2, 1e-6)


def hull(low: tuple, high: tuple, counts: dict[str, tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    """Corners and panels of a closed box; every face in its own counts, so that neighbours need not meet."""
    faces, corners = [], []
    for axis, name in enumerate("xyz"):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        for side, outward in ((low, False), (high, True)):
            n, m = counts[name]
            s, t = np.linspace(low[first], high[first], n + 1), np.linspace(low[second], high[second], m + 1)
            points = np.zeros((n + 1, m + 1, 3))
            points[..., axis], points[..., first], points[..., second] = side[axis], s[:, None], t
            i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
            quads = np.stack(
                [i * (m + 1) + j, (i + 1) * (m + 1) + j, (i + 1) * (m + 1) + j + 1, i * (m + 1) + j + 1], -1
            )
            quads = quads.reshape(-1, 4) + sum(len(one) for one in corners)
            faces.append(quads if outward else quads[:, ::-1])
            corners.append(points.reshape(-1, 3))
    return np.concatenate(corners), np.concatenate(faces)


def rigid_database(command, folder: Path, name: str, mesh: tuple, **body) -> xr.Dataset:
    """What `vsb body` makes of a mesh file in rigid motions."""
    vertices, faces = mesh
    xr.Dataset({"vertices": (("vertex", "xyz"), vertices), "faces": (("panel", "corner"), faces)}).to_netcdf(
        folder / f"{name}.nc"
    )
    raw = {"body": name, "mesh": f"{name}.nc", "modes": "rigid", "mass": "displaced", **body}
    raw["water"] = {"density": RHO, "depth": float("inf"), "gravity": G}
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(raw), encoding="utf-8")
    command("body", folder / f"{name}.yaml", folder / name)
    with xr.open_dataset(folder / name / f"{name}.nc") as found:
        return found.load()


def test_closed_and_clipped_box(agree, command, tmp_path):
    """A box with its deck, off the axis, whose panels cross the water's surface and do not meet at the edges.

    By hand: C33 = rho g L B, C44 = rho g (L B^3/12 + V (z_B - z_G)), C55 likewise, C34 and C35 by the place of the
    centre of mass, V = L B T; inertia of mass m: m (b^2 + c^2)/12 of the box filled evenly.
    """
    low, high = np.array([-3.0, -1.5, -1.3]), np.array([5.0, 2.5, 0.9])
    counts = {"x": (5, 3), "y": (4, 9), "z": (10, 6)}
    found = rigid_database(command, tmp_path, "box", hull(low, high, counts), omega=[0.8], wave_direction=[0.0], lid=0)
    length, beam, draft, height = 8.0, 4.0, 1.3, 2.2
    volume, rise = length * beam * draft, -draft / 2 - (low + high)[2] / 2
    names = ["Heave", "Roll", "Pitch"]
    at = {"influenced_dof": names, "radiating_dof": names}
    pitch = RHO * G * (beam * length**3 / 12 + volume * rise)
    roll = RHO * G * (length * beam**3 / 12 + volume * rise)
    wanted = np.diag([RHO * G * length * beam, roll, pitch])
    agree("meshes", "stiffness of a box clipped at the water", found.hydrostatic_stiffness.sel(at), wanted, 1e-6)
    mass = RHO * volume
    wanted = np.diag([mass, mass * (beam**2 + height**2) / 12, mass * (length**2 + height**2) / 12])
    agree("meshes", "mass matrix of a box filled evenly", found.inertia_matrix.sel(at), wanted, 1e-6)


def test_phases_and_headings(agree, command, tmp_path):
    """Froude-Krylov forces of a box off the origin by hand, and the whole excitation in long waves.

    The wave a exp(i (k.x - omega t)) + k z presses with rho g: on the bottom, C1 of exp(i k.x - k T); on the ends,
    differences of it. In long waves the body is forced as the water it displaces, and its added mass, accelerate.
    """
    low, high = np.array([8.0, 1.0, -2.0]), np.array([14.0, 5.0, 0.5])
    directions, omega = [0.0, 50.0, 180.0, 270.0], [0.25, 1.2]
    mesh = hull(low, high, {"x": (8, 10), "y": (10, 12), "z": (12, 8)})
    found = rigid_database(command, tmp_path, "barge", mesh, omega=omega, wave_direction=directions, lid=0)
    high[2] = 0.0
    names, volume = ["Surge", "Sway", "Heave"], float(np.prod(high - low))
    froude = found.Froude_Krylov_force.sel(influenced_dof=names)
    total = froude + found.diffraction_force.sel(influenced_dof=names)
    froude, total = (each.sel(complex="re").values + 1j * each.sel(complex="im").values for each in (froude, total))
    by_hand = np.zeros((len(omega), len(directions), 3), dtype=complex)
    for i, w in enumerate(omega):
        k = w**2 / G
        for j, beta in enumerate(np.deg2rad(directions)):
            kx, ky = k * np.cos(beta), k * np.sin(beta)

            def along(wave: float, axis: int) -> complex:
                """Integral of exp(i k x) between the ends."""
                half, middle = (high - low)[axis] / 2, (high + low)[axis] / 2
                return 2 * half * np.sinc(wave * half / np.pi) * np.exp(1j * wave * middle)

            deep = (1 - np.exp(k * low[2])) / k
            ends = [np.exp(1j * q * high[a]) - np.exp(1j * q * low[a]) for a, q in ((0, kx), (1, ky))]
            by_hand[i, j] = (
                RHO
                * G
                * np.array(
                    [
                        -ends[0] * along(ky, 1) * deep,
                        -ends[1] * along(kx, 0) * deep,
                        np.exp(k * low[2]) * along(kx, 0) * along(ky, 1),
                    ]
                )
            )
    for i, name in enumerate(names):
        agree("phases", f"Froude-Krylov force of {name} by hand", froude[..., i], by_hand[..., i], 1e-3)
    k, middle = omega[0] ** 2 / G, (high + low) / 2
    added = [float(found.added_mass.sel(influenced_dof=n, radiating_dof=n).sel(omega=omega[0])) for n in names[:2]]
    for i, name in enumerate(names[:2]):
        beta = np.deg2rad(directions)
        part = (np.cos(beta), np.sin(beta))[i]
        phase = np.exp(1j * k * (middle[0] * np.cos(beta) + middle[1] * np.sin(beta)))
        wanted = -1j * G * k * part * (RHO * volume + added[i]) * phase
        agree("phases", f"excitation of {name} in long waves", total[0, :, i], wanted, 1.5e-2)


def test_gap_resonance(agree, command, tmp_path):
    """Two barges of 32 x 8 x 4 m, 0.8 m apart: damping of their heave is largest where the water between resonates.

    Molin (2001), Journal of Fluid Mechanics 430, in two dimensions: omega^2 = g/(T + (b/pi) (3/2 + ln(B/2b))).
    """
    length, beam, draft, gap = 32, 8, 4, 0.8
    counts = {"x": (beam, draft), "y": (draft, length), "z": (length, beam)}
    corners, panels = hull((-length / 2, gap / 2, -draft), (length / 2, gap / 2 + beam, 0.0), counts)
    panels = panels[: -length * beam]  # no deck
    vertices = np.concatenate([corners, corners * [1, -1, 1]])
    faces = np.concatenate([panels, panels[:, ::-1] + len(corners)])
    molin = np.sqrt(G / (draft + gap / np.pi * (1.5 + np.log(beam / (2 * gap)))))
    omega = [round(float(molin * (1 + share)), 4) for share in np.linspace(-0.06, 0.06, 9)]
    heave = {"Heave": np.transpose([np.zeros(len(vertices)), np.zeros(len(vertices)), np.ones(len(vertices))])}
    centres = [[0, (gap + beam) / 2, 0], [0, -(gap + beam) / 2, 0]]
    found = database(command, tmp_path, "barges", vertices, faces, heave, centres, omega=omega, lid=0)
    peak = float(found.omega[int(found.radiation_damping.values.ravel().argmax())])
    agree("gaps", "resonance of the water between two barges [rad/s]", peak, molin, 4e-2)
    warned = next(check for check in json.loads(found.attrs["quality"]) if check["name"] == "error_estimate")
    assert f"near {molin:.3g} rad/s the water resonates in a gap of 0.8 m" in warned["explanation"]


def test_elastic_disc_with_dampers_all_over_it(agree, command, tmp_path):
    """Radius 10 m, D = 2e-3 rho g a^4, dampers of 0.3 rho g/omega, water of 50 m; the reference has no draft.

    So the drafts 0.3 and 0.6 m are extrapolated to none, each over a reference of its own mass.
    """
    radius, depth, omega = 10.0, 50.0, np.array([0.6, 1.0, 1.4])
    disc = {"radius": radius, "depth": depth, "rigidity": 2e-3 * RHO * G * radius**4, "nu": 0.3, "rho": RHO, "g": G}
    damper, shares = 0.3 * RHO * G / omega, []
    for draft in (0.3, 0.6):
        raw = {
            "body": "disc",
            "mesh": {"kind": "cylinder", "radius": radius, "height": 2 * draft, "draft": draft, "panel": 1.0},
            "modes": {"rigid": ["Heave", "Pitch"], "plate": {"degree": 6, "stiffness": disc["rigidity"]}},
            "mass": "displaced",
            "omega": omega.tolist(),
            "lid": 0,
            "water": {"density": RHO, "depth": depth, "gravity": G},
        }
        (tmp_path / "disc.yaml").write_text(yaml.safe_dump(raw), encoding="utf-8")
        command("body", tmp_path / "disc.yaml", tmp_path / f"disc{draft}")
        with xr.open_dataset(tmp_path / f"disc{draft}" / "disc.nc") as found:
            ds = found.load()
        waves = ds.excitation_force.isel(wave_direction=0)
        force = (waves.sel(complex="re") + 1j * waves.sel(complex="im")).values
        stiff = ds.hydrostatic_stiffness.values + ds.structural_stiffness.values
        mode = {"Heave": (0, 0, 1.0), "Pitch": (1, 1, -radius)} | {
            label: (*(int(part) for part in label[5:].split("_")), 1.0)
            for label in map(str, ds.influenced_dof.values[2:])
        }
        squares = np.diag(
            [s**2 * np.pi * radius**2 * (1 if m else 2) / (2 * (n + 1)) for n, m, s in mode.values()]
        )  # int w w dA
        for i, w in enumerate(omega):
            c = damper[i] * squares
            whole = stiff - w**2 * (ds.inertia_matrix.values + ds.added_mass.values[i])
            moved = np.linalg.solve(whole - 1j * w * (ds.radiation_damping.values[i] + c), force[i])
            own = w**2 / 2 * float(np.real(moved.conj() @ c @ moved))
            wanted, lost = power(w, damper[i], mass=RHO * draft, highest=6, **disc)
            assert lost == pytest.approx(wanted, rel=1e-10)  # by the reference's waves far away
            shares.append(own / wanted)
    thin, thick = np.reshape(shares, (2, -1))
    agree("elastic disc", "power of dampers all over a disc of no draft", 2 * thin - thick, np.ones(3), 3e-3)


def test_flexible_barge_of_wec_sim(agree, command, tmp_path):
    """Coefficients of heave, pitch and four modes, and the motion of the free barge, against WAMIT's of 6800 panels."""
    vertices, faces = box(-40.0, 80.0, (64, 8, 8))
    x, _, z = vertices.T
    zero, one = np.zeros(len(x)), np.ones(len(x))
    place = np.linspace(-40.0, 0.0, 41)
    shapes = {"Heave": np.transpose([zero, zero, one]), "Pitch": np.transpose([z, zero, -x])}
    for n, w in enumerate(wamit.DEFLECTION.T, 1):
        side = 1.0 if n % 2 else np.where(x > 0, -1.0, 1.0)
        shapes[f"Mode{n}"] = np.transpose([zero, zero, side * np.interp(-np.abs(x), place, w)])
    omega = 2 * np.pi / np.array(wamit.PERIODS[::-1])
    water = {"density": 1000.0, "depth": float("inf"), "gravity": G}
    found = database(
        command, tmp_path, "barge", vertices, faces, shapes, [0, 0, 0], omega=omega.tolist(), water=water, lid=0
    ).isel(omega=slice(None, None, -1), wave_direction=0)
    added, damping = found.added_mass.values, found.radiation_damping.values
    waves = found.excitation_force
    force = (waves.sel(complex="re") + 1j * waves.sel(complex="im")).values
    mass = np.diag([4.0e6, wamit.PITCH_INERTIA, *wamit.MODAL_MASS])
    stiffness = found.hydrostatic_stiffness.values + np.diag([0.0, 0.0, *wamit.MODAL_STIFFNESS])
    w = omega[::-1, None, None]
    response = np.linalg.solve(-(w**2) * (mass + added) - 1j * w * damping + stiffness, force[..., None])[..., 0]
    size = np.sqrt(np.einsum("wii->wi", wamit.ADDED_MASS).max(axis=0))
    unit = 1000.0 * np.outer(size, size)
    agree("flexible barge", "added mass of WEC-Sim's barge", added / unit, 1000.0 * wamit.ADDED_MASS / unit, 2e-2)
    agree("flexible barge", "damping, likewise", damping / unit, 1000.0 * w * wamit.DAMPING / unit, 2e-2)
    agree("flexible barge", "wave forces, likewise", abs(force) / size, 1000.0 * G * wamit.FORCE / size, 2e-2)
    even = [0, 2, 4]  # in WAMIT's stiffness surge forces the odd modes in still water, which no barge feels
    largest = wamit.RESPONSE[:, even].max(axis=0)
    moved = wamit.RESPONSE[:, even] / largest
    agree("flexible barge", "heave and even modes, likewise", abs(response[:, even]) / largest, moved, 2e-2)
