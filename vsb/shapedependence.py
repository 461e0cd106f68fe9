"""How much added mass, damping and excitation depend on the shape: their derivatives by heave and modal amplitudes.

A linear model takes its coefficients on one shape while the shell moves. Here they are solved on shapes around it,

    A(eta) = A + sum_k A_k eta_k + 1/2 sum_k A_kk eta_k^2 + ...,

always for displacements of material points, so a mode is the same motion on every shape; by heave, the draft changes.
A_k is a central difference at three steps, extrapolated twice; its error comes out of the same run.

When may it be ignored? A deformation eta of a sphere of radius a changes heave's coefficients, in terms of themselves,
by about max(4/a, 2K) eta, K = omega^2/g: its size counts, and in damping e^{-2Kd} with the draft d (the seed: at
2.51 rad/s 12 % in damping per 0.1 m of heave, 304 % at 12 rad/s). One percent needs eta < a/400 and K eta < 0.005, five
percent five times that. Varying with the waves' frequency, first-order changes leave the mean power alone up to
second order in eta; a lasting deformation does not: the shape at rest must be the one solved on.
"""

import io
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from vsb.canvas import grid_of_axes, legend_above
from vsb.config import RegularWave, Study
from vsb.database import in_modes, with_excitation, with_structure
from vsb.errors import ConfigError
from vsb.modes import design_motions
from vsb.pto import LinearPto
from vsb.reference import ReferenceShell, reference_shell
from vsb.response import LinearBuoy
from vsb.spectral import SpectralProblem
from vsb.surface import DeformedShell
from vsb.units import ComplexArray, FloatArray, save, write_text

COEFFICIENTS = {
    "added_mass": ("kg", "kg/m", "kg/m^2"),
    "radiation_damping": ("kg/s", "kg/(m s)", "kg/(m^2 s)"),
    "excitation_force": ("N/m", "N/m^2", "N/m^3"),
    "added_mass_inf": ("kg", "kg/m", "kg/m^2"),
}
"""What depends on the shape; units of it and of its first and second derivative."""
SIZES = (0.00625, 0.0125, 0.025, 0.05, 0.1)
"""Sizes of the deformations on which a study's expansion is put to the test, in radii."""
_CURVES = {
    "added_mass": ("added mass", "#000000"),
    "radiation_damping": ("damping", "#D55E00"),
    "excitation_force": ("excitation", "#0072B2"),
}
_EXPANSIONS = {
    "first": ("first order", "#000000", "o"),
    "second": ("second order, no mixed terms", "#D55E00", "s"),
    "single": ("second order, one mode at a time", "#0072B2", "^"),
}


def extrapolated(levels: Sequence[xr.Dataset]) -> tuple[xr.Dataset, xr.Dataset]:
    """Return the limit of values at steps h, h/2, h/4, ... whose errors are even in h, and its last correction."""
    table, power = list(levels), 4.0
    while len(table) > 1:
        best = table[-1]
        table = [fine + (fine - coarse) / (power - 1) for coarse, fine in itertools.pairwise(table)]
        power *= 4
    return table[0], table[0] - best


def misfit(value: xr.DataArray, exact: xr.DataArray) -> float:
    """Return the largest difference of any entry at any frequency in terms of the largest entry of all [-]."""
    return float(np.abs(value - exact).max() / np.abs(exact).max())


def haskind_slope(omega: FloatArray, x: ComplexArray, dx: ComplexArray, density: float, gravity: float) -> FloatArray:
    """Return dB = k (dX X^H + X dX^H)/(4 rho g v_g), shape (..., omega, dof, dof) [kg/(m s)].

    Of excitation `x`, (omega, dof) [N/m], and its derivative `dx`, (..., omega, dof) [N/m^2]; in deep water.
    """
    half = dx[..., :, None] * x[:, None, :].conj()
    scale = omega[:, None, None] ** 3 / (2 * density * gravity**3)
    return np.asarray((scale * (half + half.swapaxes(-1, -2).conj())).real)


@dataclass(frozen=True)
class ShapeFamily:
    """Coefficients of one shell in deep water on the shapes around a reference shape."""

    shape: DeformedShell
    omegas: tuple[float, ...]  # [rad/s]
    density: float  # of water [kg/m^3]
    gravity: float  # [m/s^2]
    nodes: int = 48
    step: float = 0.01  # largest step of the differences, in radii of the shell [-]

    @property
    def labels(self) -> list[str]:
        """Names of heave and modes."""
        return list(self.shape.basis.labels)

    def at(self, amplitudes: FloatArray) -> xr.Dataset:
        """Return `COEFFICIENTS` of heave and modes on the shape deformed further, dimensions as of a hydro database.

        `amplitudes`, shape (dof,) [m], count from the reference shape. `ConfigError` if they are not one for each
        degree of freedom, or if the shape does not cross the water once.
        """
        basis, dof = self.shape.basis, len(self.labels)
        if np.shape(amplitudes) != (dof,):
            raise ConfigError(f"amplitudes: received shape {np.shape(amplitudes)}; needs ({dof},), heave and all modes")
        start = self.shape.amplitudes if self.shape.amplitudes.size else np.zeros(dof)
        shell = replace(self.shape, amplitudes=start + amplitudes)
        degrees = sorted(set(basis.degrees))
        fields = (*(f"Radial{n}" for n in degrees), *(f"Meridional{n}" for n in degrees if n))
        problem = SpectralProblem(shell, fields, self.density, self.gravity, self.nodes)
        pair = ("influenced_dof", "radiating_dof")
        raw = problem.solve(list(self.omegas)).assign(added_mass_inf=(pair, problem.at_infinity()))
        return with_excitation(in_modes(raw, basis))[list(COEFFICIENTS)]

    @cached_property
    def centre(self) -> xr.Dataset:
        """Coefficients on the reference shape."""
        return self.at(np.zeros(len(self.labels)))

    def _along(self, dof: int) -> tuple[xr.Dataset, xr.Dataset, xr.Dataset]:
        """First and second derivative by one amplitude, and the last correction of the first."""
        slopes, curvatures = [], []
        for halved in (1, 2, 4):
            h = self.step * self.shape.basis.shell.radius / halved
            plus, minus = (self.at(sign * h * np.eye(len(self.labels))[dof]) for sign in (1, -1))
            slopes.append((plus - minus) / (2 * h))
            curvatures.append((plus - 2 * self.centre + minus) / h**2)
        slope, correction = extrapolated(slopes)
        return slope, extrapolated(curvatures)[0], correction

    @cached_property
    def _differences(self) -> tuple[xr.Dataset, ...]:
        """First and second derivatives by every amplitude, corrections of the first; `shape_dof` leads."""
        along = zip(*map(self._along, range(len(self.labels))), strict=True)
        dim = xr.DataArray(self.labels, dims="shape_dof", name="shape_dof")
        return tuple(xr.concat(each, dim, coords="minimal", compat="override", join="override") for each in along)

    @property
    def slopes(self) -> xr.Dataset:
        """First derivatives, (shape_dof, omega, influenced_dof, radiating_dof) and the like [unit per m]."""
        return self._differences[0]

    @property
    def curvatures(self) -> xr.Dataset:
        """Second derivatives, each by one amplitude twice, dimensions as of `slopes` [unit per m^2]."""
        return self._differences[1]

    def _missed(self, slope: xr.Dataset) -> dict[str, float]:
        """What the derivative by one amplitude misses of symmetry and of Haskind's relation, relative [-]."""
        turned = {"influenced_dof": "radiating_dof", "radiating_dof": "influenced_dof"}
        x, dx = (ds.excitation_force.values[:, 0] for ds in (self.centre, slope))
        haskind = haskind_slope(np.array(self.omegas), x, dx, self.density, self.gravity)
        damping = misfit(slope.radiation_damping.copy(data=haskind), slope.radiation_damping)
        even = {name: misfit(slope[name].rename(turned), slope[name]) for name in ("added_mass", "added_mass_inf")}
        return {**even, "radiation_damping": damping, "excitation_force": damping}

    @cached_property
    def slope_errors(self) -> xr.Dataset:
        """Estimated errors of the derivatives, relative to the largest entry of each over the band, (shape_dof,) [-].

        The last correction of the extrapolation; plus asymmetry, and damping against Haskind's: the discretization's.
        """
        slope, _, correction = self._differences
        missed = [self._missed(slope.sel(shape_dof=label)) for label in self.labels]
        errors = {
            name: [misfit(a + c, a) + m[name] for a, c, m in zip(slope[name], correction[name], missed, strict=True)]
            for name in COEFFICIENTS
        }
        return xr.Dataset({n: ("shape_dof", e) for n, e in errors.items()}, {"shape_dof": self.labels})

    @cached_property
    def derivatives(self) -> xr.Dataset:
        """Coefficients, `<name>_slope`, `<name>_curvature`, `<name>_slope_error`, with their units."""
        parts = {"": self.centre, "_slope": self.slopes, "_curvature": self.curvatures}
        named = {
            f"{name}{suffix}": ds[name].assign_attrs(units=unit)
            for name, units in COEFFICIENTS.items()
            for (suffix, ds), unit in zip(parts.items(), units, strict=True)
        }
        errors = {f"{name}_slope_error": e.assign_attrs(units="1") for name, e in self.slope_errors.items()}
        return xr.Dataset({**named, **errors})

    def expansion(self, amplitudes: FloatArray, order: int) -> xr.Dataset:
        """Return the coefficients at amplitudes (dof,) [m], to order 1 or with squares, 2; else `ConfigError`."""
        if order not in (1, 2):
            raise ConfigError(f"order: received {order}; needs 1 or 2")
        eta = xr.DataArray(amplitudes, coords={"shape_dof": self.labels}, dims="shape_dof")
        linear = self.centre + (eta * self.slopes).sum("shape_dof")
        return linear if order == 1 else linear + (eta**2 / 2 * self.curvatures).sum("shape_dof")

    def interpolation_error(
        self, amplitude: float, *, single: bool = False, samples: int = 8, seed: int = 0
    ) -> xr.Dataset:
        """Return the largest errors of `expansion` against direct solution, as of `misfit`, shape (order,) [-].

        Of `samples` deformations, the same for every `amplitude`, their root-sum-square [m] (`ConfigError` if not
        positive): along one degree of freedom at a time, of random sign (`single`), or in random directions.
        In these the second order, which has no mixed derivatives, is still wrong by O(amplitude^2).
        """
        if not amplitude > 0:
            raise ConfigError(f"amplitude: received {amplitude:g} m; needs a positive size of the deformation")
        errors = np.zeros((len(COEFFICIENTS), 2))
        for eta in amplitude * self._directions(single, samples, seed):
            direct, models = self.at(eta), [self.expansion(eta, order) for order in (1, 2)]
            errors = np.maximum(errors, [[misfit(m[name], direct[name]) for m in models] for name in COEFFICIENTS])
        return xr.Dataset({n: ("order", e) for n, e in zip(COEFFICIENTS, errors, strict=True)}, {"order": [1, 2]})

    def _directions(self, single: bool, samples: int, seed: int) -> FloatArray:
        """Unit vectors, shape (sample, dof)."""
        rng, dof = np.random.default_rng(seed), len(self.labels)
        if single:
            return np.asarray(np.eye(dof)[np.arange(samples) % dof] * rng.choice([-1.0, 1.0], (samples, 1)))
        vectors = rng.standard_normal((samples, dof))
        return np.asarray(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))


def power_slope(buoy: LinearBuoy, slopes: xr.Dataset, motions: FloatArray) -> FloatArray:
    """Return the derivative of absorbed power per squared wave amplitude by shape, shape (shape_dof, omega) [W/m^3].

    The database of the buoy is at the frequencies of `slopes`; `motions`, (dof, free), are those a design allows.
    Z q = X gives dq = Z^-1 (dX - dZ q) with dZ = -w^2 dA - i w dB; inertia and stiffness stay.
    """
    omega = buoy.database.omega.values
    c, w, q = buoy.coefficients(omega), omega[:, None, None], buoy.rao(omega, motions)
    impedance = -(w**2) * (buoy.mass + c.added_mass) - 1j * w * (c.damping + buoy.damping) + buoy.stiffness
    change = -(w**2) * slopes.added_mass.values - 1j * w * slopes.radiation_damping.values
    load = slopes.excitation_force.values[:, :, 0] - np.einsum("kwij,wj->kwi", change, q)
    response = np.linalg.solve(motions.T @ impedance @ motions, (load @ motions)[..., None])[..., 0] @ motions.T
    return np.asarray(buoy.pto.damping * omega**2 * (q[:, 0].conj() * response[..., 0]).real)


def power_changes(study: Study, reference: ReferenceShell, family: ShapeFamily) -> xr.Dataset:
    """Return how the power of every design depends to first order on the shape its coefficients are taken on.

    `absorbed_power` (design, omega) [W/m^2] per squared wave amplitude; its `power_slope` (design, shape_dof, omega)
    [W/m^3]; `power_swing` (design, omega) [W/m^3], max over t of sum_k P_k Re q_k e^{-i w t} per wave amplitude, with
    coefficients of the shape at that instant; `power_undeformed` (design, omega) [W/m^2], with those of the sphere.
    """
    basis, omega = reference.basis, np.array(family.omegas)
    buoy = LinearBuoy(with_structure(family.centre, reference), basis.damping, LinearPto(study.pto.damping))
    motions = [design_motions(study, basis, design) for design in study.designs]
    raos = np.array([buoy.rao(omega, free) for free in motions])
    slope = np.array([power_slope(buoy, family.slopes, free) for free in motions])
    wave, swing = ("design", "omega"), np.abs(np.einsum("dkw,dwk->dw", slope, raos))
    undeformed = -np.einsum("dkw,k->dw", slope, reference.amplitudes)
    return xr.Dataset(
        {
            "absorbed_power": (wave, [buoy.absorbed_power(omega, rao) for rao in raos], {"units": "W/m^2"}),
            "power_slope": (("design", "shape_dof", "omega"), slope, {"units": "W/m^3"}),
            "power_swing": (wave, swing, {"units": "W/m^3"}),
            "power_undeformed": (wave, undeformed, {"units": "W/m^2"}),
        },
        {"design": list(study.designs), "shape_dof": family.labels, "omega": omega},
    )


def study_family(study: Study, reference: ReferenceShell, frequencies: int = 60) -> ShapeFamily:
    """Return the shapes around that of a study, frequencies its waves' too; `ConfigError` unless the water is deep."""
    if np.isfinite(study.water.depth):
        raise ConfigError(f"water.depth: received {study.water.depth:g} m; shape dependence needs deep water, .inf")
    highest = study.hydro.omega_max
    grid = {round(highest * (i + 1) / frequencies, 10) for i in range(frequencies)}
    waves = {wave.omega for wave in study.waves if isinstance(wave, RegularWave)}
    return ShapeFamily(reference.shape, tuple(sorted(grid | waves)), study.water.density, study.water.gravity)


def shape_dataset(study: Study, family: ShapeFamily | None = None, samples: int = 8) -> xr.Dataset:
    """Return all of it for a study: derivatives, what they mean for power, errors of expansions.

    `interpolation_error`, dimensions (expansion, deformation): of first and second order in random directions (`first`,
    `second`) and of second order along one amplitude at a time (`single`); `deformation` is its size [m].
    """
    reference = reference_shell(study)
    family = family or study_family(study, reference)
    sizes = study.device.radius * np.array(SIZES)
    worst = np.array([
        [family.interpolation_error(size, single=single, samples=samples).to_array().max("variable") for size in sizes]
        for single in (False, True)
    ])  # fmt: skip
    rows = np.stack([worst[0, :, 0], worst[0, :, 1], worst[1, :, 1]])
    table = xr.Dataset(
        {"interpolation_error": (("expansion", "deformation"), rows, {"units": "1"})},
        {"expansion": list(_EXPANSIONS), "deformation": ("deformation", sizes, {"units": "m"})},
    )
    return xr.Dataset({**family.derivatives, **power_changes(study, reference, family), **table})


def relative_slope(ds: xr.Dataset, name: str) -> xr.DataArray:
    """Return the derivative of the logarithm of heave's coefficient `name` (of |X|), (shape_dof, omega) [1/m]."""
    heave = {dim: 0 for dim in ds[name].dims if dim != "omega"}
    relative: xr.DataArray = (ds[f"{name}_slope"].isel(heave, drop=True) / ds[name].isel(heave, drop=True)).real
    return relative


def largest_mode(ds: xr.Dataset) -> str | None:
    """Return the mode that changes heave's added mass most, relative, in the band; none of a rigid buoy."""
    change = abs(relative_slope(ds, "added_mass")).max("omega").values
    return str(ds.shape_dof.values[1 + change[1:].argmax()]) if len(change) > 1 else None


def _draw_slopes(ax: Axes, ds: xr.Dataset) -> None:
    """Relative changes of heave's coefficients by heave and by the largest mode, linear near zero."""
    shown = [str(ds.shape_dof.values[0]), largest_mode(ds)]
    for shape_dof, line in zip(shown, ("-", "--"), strict=True):
        for name, (symbol, colour) in _CURVES.items() if shape_dof else ():
            change = relative_slope(ds, name).sel(shape_dof=shape_dof)
            ax.plot(ds.omega, change, color=colour, linestyle=line, label=f"{symbol} by {shape_dof}")
    ax.set_yscale("asinh", linear_width=0.5)
    ax.yaxis.set_major_locator(FixedLocator([-30, -10, -3, -1, 0, 1, 3, 10, 30]))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.set(xlabel="angular frequency [rad/s]", ylabel="relative change [1/m]", xlim=(0, float(ds.omega[-1])))


def _draw_errors(ax: Axes, table: xr.DataArray) -> None:
    """Errors of the expansions against the size of the deformation, and what is of order 2 and 3."""
    size = table.deformation.values
    for kind, (label, colour, marker) in _EXPANSIONS.items():
        ax.loglog(size, table.sel(expansion=kind), color=colour, marker=marker, markersize=4, label=label)
    for order, kind in ((2, "second"), (3, "single")):
        guide = 0.5 * float(table.sel(expansion=kind)[0]) * (size / size[0]) ** order
        ax.loglog(size, guide, color="#999999", linestyle=":", linewidth=1.0)
        ax.annotate(f"size$^{order}$", (size[1], guide[1]), (4, -10), textcoords="offset points", fontsize=8)
    ax.set_xticks(size, [f"{x:.3g}" for x in size])
    ax.set_xticks([], minor=True)
    ax.set(xlabel="size of the deformation [m]", ylabel="largest relative error [-]")
    ax.legend(fontsize=8, loc="upper left")


def shape_figure(ds: xr.Dataset) -> Figure:
    """Draw relative changes of heave's coefficients per metre of heave and of a mode, and errors of expansions."""
    figure, axes = grid_of_axes(6.0, 2, 1)
    _draw_slopes(axes[0, 0], ds)
    _draw_errors(axes[1, 0], ds.interpolation_error)
    legend_above(figure, axes[0, 0])
    return figure


def shape_dependence(study: Study, out_nc: str, out_figure: str) -> None:
    """Write the shape dependence of a study as netCDF and its figure as SVG."""
    ds = shape_dataset(study)
    text = io.StringIO()
    shape_figure(ds).savefig(text, format="svg", metadata={"Date": None})
    save(ds, out_nc)
    write_text(out_figure, text.getvalue())
