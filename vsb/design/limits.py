"""What limits a design: the size of its hull, the strain of its shell at rest, its distance from buckling."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import minimize_scalar

from vsb.design.resting import OF_DAMPING, RestingBuoy, Stepped, with_variable
from vsb.engine.shell.loaded import LoadedShell, PencilSlopes, buckling_pencil
from vsb.engine.shell.lobes import LobedShell, Lobes
from vsb.engine.shell.meridian import length, meridian_rule
from vsb.engine.shell.modes import rigid_basis
from vsb.models.rest import complete_loaded_shell, loaded_shell
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray

FACTORS = 4
"""Largest inverse load factors that are given: those of several buckling modes may cross."""
NO_MATTER = ("device.density", *(f"device.{name}" for name in OF_DAMPING))
"""Variables without effect on buckling: the load is the mass of the whole buoy."""
Slopes = tuple[float, list[float]]
"""A value and its derivatives by the variables of the device."""


def hull(buoy: RestingBuoy, stepped: Sequence[Stepped]) -> dict[str, Slopes]:
    """Return beam and draft [m], surface [m^2] and volume [m^3] of the hull at rest, and mass [kg], with derivatives.

    Where the hull is widest and deepest does not matter for derivatives: both are extrema along the meridian.
    """
    widest, deepest = (
        _highest(lambda phi: buoy.shape.curve(phi).x, buoy),
        _highest(lambda phi: -buoy.shape.curve(phi).z, buoy),
    )
    functions: dict[str, Callable[[RestingBuoy], AnyArray]] = {
        "beam": lambda b: 2 * b.shape.curve(widest).x[0],
        "draft": lambda b: -b.shape.curve(deepest).z[0],
        "surface": _surface,
        "volume": lambda b: np.asarray(b.loaded.elastic.volume(b.modal_amplitude)),
        "mass": lambda b: np.asarray(b.loaded.basis.total_mass),
    }
    return {
        name: (float(function(buoy)), [float(one.derivative(function)) for one in stepped])
        for name, function in functions.items()
    }


def _surface(buoy: RestingBuoy) -> AnyArray:
    """Area of the hull, int 2 pi x ds."""
    basis = buoy.loaded.basis
    phi, weight = meridian_rule(basis.shell.meridian.junctions, 8 * basis.turns + 48)
    at = buoy.shape.curve(phi)
    return np.asarray(2 * np.pi * (at.x * length(at.dx, at.dz)) @ weight)


def _highest(function: Callable[[FloatArray], FloatArray], buoy: RestingBuoy) -> FloatArray:
    """Colatitude where a function of it is largest, shape (1,) [rad]."""
    grid = colatitudes(buoy)
    at = int(np.argmax(function(grid)))
    bounds = grid[max(at - 1, 0)], grid[min(at + 1, len(grid) - 1)]
    found = minimize_scalar(lambda phi: -float(function(np.array([phi]))[0]), bounds=bounds, options={"xatol": 1e-10})
    return np.array([found.x if -found.fun > function(grid[at : at + 1])[0] else grid[at]])


def colatitudes(buoy: RestingBuoy, per_turn: int = 40) -> FloatArray:
    """Return colatitudes that resolve the shape [rad], from pole to pole; on other meridians than the sphere's between.

    There strains are not computed at the poles, where their slope is zero.
    """
    aside = 1e-4 if buoy.loaded.basis.shell.rest else 0.0
    return np.linspace(aside, np.pi - aside, per_turn * (buoy.loaded.basis.turns + 1) + 1)


def static_strain(buoy: RestingBuoy, stepped: Sequence[Stepped]) -> Slopes:
    """Return the largest Green-Lagrange membrane strain of the shell at rest [-], with derivatives.

    Of the linear static solution about a shell that is taken as undeformed.
    """

    def displaced(b: RestingBuoy) -> FloatArray:
        return b.modal_amplitude if b.study.at_equilibrium else b.linear_rest

    def strains(b: RestingBuoy, q: FloatArray, phi: FloatArray) -> AnyArray:
        return np.array(b.loaded.elastic.strains(q, phi))

    q = displaced(buoy)
    which = int(np.abs(strains(buoy, q, colatitudes(buoy))).max(axis=1).argmax())
    at = _highest(lambda phi: np.abs(strains(buoy, q, phi)[which]), buoy)
    value = float(strains(buoy, q, at)[which, 0])
    slopes = [one.derivative(lambda b: strains(b, displaced(b), at)[which, 0]) for one in stepped]
    return abs(value), [float(np.sign(value) * slope) for slope in slopes]


def inverse_load_factors(study: Study, keys: Sequence[str]) -> list[Slopes]:
    """Return the largest inverse load factors of linear buckling [-], descending, with derivatives by keys of a device.

    Eigenvalues kappa of -K_1 x = kappa K_0 x (`vsb.engine.shell.loaded.buckling_pencil`): 1 buckles under its load, 0
    and less under no load. They are smooth where load factors leap to infinity. With x^T K_0 x = 1
    dkappa = -x^T (dK_1 + kappa dK_0) x. On other meridians than the sphere's those of lobes around the axis are among
    them (`vsb.engine.shell.lobes`).
    """
    loaded = complete_loaded_shell(study)
    elastic, load = buckling_pencil(loaded)
    kappa, x = eigh(-load, elastic, subset_by_index=[len(load) - FACTORS, len(load) - 1])
    found = [Lobes(float(k), 0, shape) for k, shape in zip(kappa, x.T, strict=True)]
    if loaded.basis.shell.rest is not None:
        found += LobedShell.of(loaded).buckling(FACTORS)
    found = sorted(found, key=lambda one: -one.inverse_load_factor)[:FACTORS]
    axisymmetric = PencilSlopes(loaded, np.array([one.shape for one in found if one.order == 0]).T)
    rigid = RestingBuoy(study, loaded_shell(study, rigid_basis(study.device)), np.zeros(1))  # it floats undeformed
    slopes = []
    for key in keys:
        if key in NO_MATTER:
            slopes.append([0.0] * FACTORS)
            continue
        step = rigid.with_step(key)
        changed = with_variable(loaded, key, 1j * step.size, study.device)
        changed = replace(changed, centre_height=step.buoy.loaded.centre_height)
        slopes.append([change / step.size for change in _changes(changed, found, axisymmetric)])
    return [(one.inverse_load_factor, [change[j] for change in slopes]) for j, one in enumerate(found)]


def _changes(changed: LoadedShell, shapes: Sequence[Lobes], axisymmetric: PencilSlopes) -> list[float]:
    """Imaginary parts of inverse load factors of a shell with an imaginary step, by the shapes of the one without."""
    lobed, found = LobedShell.of(changed), []
    without = iter(zip(*axisymmetric.of(changed), strict=True)) if axisymmetric.shapes.size else iter(())
    for kappa, order, x in shapes:
        pencil = lobed.pencil(order, x[:, None]) if order else next(without)
        elastic, load = (np.imag(one).item() for one in pencil) if order else pencil
        found.append(-float(load + kappa * elastic))
    return found
