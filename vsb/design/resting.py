"""A buoy where it rests, its matrices there, and how both change with a variable of its design.

Derivatives are by the complex step: with a function that is analytic, df/dx = Im f(x + i h)/h without any subtraction,
exact to round-off for a tiny h (Squire and Trapp, SIAM Review 40, 1998). Shell theory and hydrostatics are evaluated
with such numbers by the same code as with real ones, so there is no second copy of the model.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import block_diag

from vsb.engine.shell.deformed import DeformedShell
from vsb.engine.shell.device import Device
from vsb.engine.shell.loaded import LoadedShell, complete_basis, equilibrium, equilibrium_near
from vsb.engine.shell.meridian import ClosedMeridian, Curve, capsule, series, spheroid, through
from vsb.engine.shell.modes import ModeBasis, rigid_basis
from vsb.engine.shell.rings import AttachmentModes, Load
from vsb.engine.shell.shell import Shell
from vsb.errors import ConfigError
from vsb.keys.quantities import at_key
from vsb.models.rest import (
    attachment_modes,
    loaded_shell,
    ring_loads,
    stiffness_about,
    tension_at,
)
from vsb.study.resolution import loaded_at_ring
from vsb.study.study import Study
from vsb.tools.arrays import AnyArray, FloatArray

STEP = 1e-20
"""Imaginary step, in terms of the variable or of one unit of it if it is zero: its square vanishes in round-off."""
OF_SHELL = ("radius", "thickness", "young_modulus", "poisson_ratio", "density")
"""Variables of a device that are those of its shell."""
OF_MATERIAL = ("material.mu", "material.c1", "material.c2", "material.jm")
"""Those of laws of rubber."""
OF_DAMPING = ("damping.alpha", "damping.beta")
"""Those of structural damping."""
CLOSE = 1e-3
"""Distance between the rest that a close buoy foretells and that found, over the radius, beyond which the load is made
to grow from nothing: a shell past its buckling may come to rest elsewhere [-]."""
HEIGHT, LENGTH = "shape.spheroid.height", "shape.capsule.length"
OF_SHAPE, SERIES = ("radius", HEIGHT, LENGTH), "shape.series."
"""Those that a meridian other than the sphere's depends on, and how those of terms of one begin."""


class Matrices(NamedTuple):
    """Mass [kg], structural damping [N s/m] and stiffness [N/m] about the shape at rest, each (dof, dof)."""

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray


@dataclass(frozen=True)
class RestingBuoy:
    """The loaded shell of a study at rest, in heave and separate radial and meridional functions.

    These do not depend on thickness or material, as natural modes do: derivatives are taken at fixed functions.
    """

    study: Study
    loaded: LoadedShell
    modal_amplitude: FloatArray  # heave and functions at rest (dof,) [m]; zero about the undeformed shell
    loads: tuple[Load, ...] = ()  # at rings, which all higher degrees answer
    stepped_from: AttachmentModes | None = None  # their modes of the buoy this one is a step of

    @classmethod
    def of(cls, study: Study, degree: int, design: str | None = None, near: FloatArray | None = None) -> "RestingBuoy":
        """Return the buoy of a study at rest, its shell in functions to a degree.

        Beside these stands what all higher ones do under loads at rings, if they load a `design`. The equilibrium is
        sought `near` amplitudes (dof,) [m], if given. Raises `ConvergenceError` if the shell buckles before it carries
        its load.
        """
        device = study.device
        basis = complete_basis(Shell.of(device), degree, device.mass) if study.flexible else rigid_basis(device)
        loaded = loaded_shell(study, replace(basis, alpha=device.damping.alpha, beta=device.damping.beta))
        at_rest: FloatArray = np.zeros(len(basis.labels))
        if study.at_equilibrium:
            within = CLOSE * device.radius
            at_rest = equilibrium(loaded) if near is None else equilibrium_near(loaded, near, within)
        answered = design and study.designs[design].flexible and loaded_at_ring(study, design)
        return cls(study, loaded, at_rest, ring_loads(study) if answered else ())

    @cached_property
    def shape(self) -> DeformedShell:
        """The shape at rest."""
        return DeformedShell(self.loaded.basis, self.loaded.centre_height, self.modal_amplitude)

    @cached_property
    def rings(self) -> AttachmentModes | None:
        """What all degrees above those of the functions do under loads at rings; None without any."""
        if not self.loads:
            return None
        shell, at_rest = self.loaded.basis.shell, self.modal_amplitude if self.study.at_equilibrium else None
        stretched = "prestress" in self._stiffness
        tension = tension_at(self.loads, self.loaded, at_rest) if stretched else (0.0,) * len(self.loads)
        if known := self.stepped_from:
            return replace(known, shell=shell, loads=self.loads, tension=tension, stepped_from=known)
        return attachment_modes(shell, self.loaded.basis.highest_degree, self.loads, tension)

    @cached_property
    def basis(self) -> ModeBasis:
        """All it moves in: heave, the functions of its shell, and the modes of rings."""
        return replace(self.loaded.basis, rings=self.rings)

    @cached_property
    def moving_shape(self) -> DeformedShell:
        """The shape at rest with the modes of rings, which are at rest."""
        more = len(self.basis.labels) - len(self.modal_amplitude)
        return DeformedShell(self.basis, self.loaded.centre_height, np.pad(self.modal_amplitude, (0, more)))

    @cached_property
    def matrices(self) -> Matrices:
        """Mass, damping and stiffness about the shape at rest over all it moves in."""
        if self.rings is None:
            return self.of_functions
        pairs = zip(self.of_functions, self.of_rings, strict=True)
        return Matrices(*(block_diag(of_functions, of_rings) for of_functions, of_rings in pairs))

    @property
    def of_rings(self) -> Matrices:
        """The same of the modes of rings alone, which couple with no function."""
        assert self.rings is not None
        mass, stiffness, basis = self.rings.inertia, self.rings.stiffness, self.loaded.basis
        return Matrices(mass, basis.alpha * mass + basis.beta * stiffness, stiffness + self.rings.prestress)

    @cached_property
    def of_functions(self) -> Matrices:
        """The same of heave and functions of the shell alone."""
        basis, frame = self.loaded.basis, self.frame
        stiffness = sum(matrix for name, matrix in self._stiffness.items() if name != "gas" or not self._opened)
        if frame is None:
            return Matrices(basis.inertia, basis.damping, np.asarray(stiffness))
        mass = frame.T @ basis.integrated("mass") @ frame
        mass = mass.astype(np.result_type(mass, basis.total_mass))
        mass[0], mass[:, 0] = 0.0, 0.0  # but for the whole buoy's own: modes have no momentum
        damping = basis.alpha * mass + basis.beta * basis.stiffness
        mass[0, 0] = basis.total_mass
        return Matrices(mass, damping, frame.T @ stiffness @ frame)

    @cached_property
    def _stiffness(self) -> dict[str, FloatArray]:
        """Stiffness about the shape at rest by its parts, shape (dof, dof) [N/m]."""
        return stiffness_about(self.study, self.loaded, self.modal_amplitude)

    @property
    def _opened(self) -> bool:
        """Whether the take-off lets trapped gas out: it is in series with it, and no longer holds the shell."""
        return self.study.opens_chamber and "gas" in self._stiffness

    @cached_property
    def chamber(self) -> FloatArray:
        """Compliance C of the gas before the take-off, from its stiffness b b^T/C, shape () [m^3/Pa]; 0 without it."""
        if not self._opened:
            return np.zeros(())
        b = self.loaded.elastic.volume_gradient(self.modal_amplitude)
        return np.asarray((b @ b) ** 2 / (b @ self._stiffness["gas"] @ b))

    @cached_property
    def frame(self) -> FloatArray | None:
        """Functions of the shell, one a row, in the motions of frame and modes, shape (dof, dof) [-]; None of a sphere.

        The frame with the ballast moves as the shell does in the mean. Functions with momentum, which the sphere's have
        not, are therefore less its heave: s_0 = q_0 - sum (m_j/m_0) q_j, m the first row of the shell's mass.
        """
        basis = self.loaded.basis
        if basis.shell.rest is None or not basis.modes:
            return None
        momentum = basis.integrated("mass")[0]
        found = np.eye(len(momentum), dtype=momentum.dtype)
        found[0, 1:] = -momentum[1:] / momentum[0]
        return found

    def framed(self, rows: AnyArray) -> AnyArray:
        """Return rows over heave and functions of the shell, and modes of rings, in the motions of frame and modes."""
        if self.frame is None:
            return rows
        count = len(self.frame)
        return np.concatenate([rows[..., :count] @ self.frame, rows[..., count:]], axis=-1)

    @property
    def linear_rest(self) -> FloatArray:
        """Static displacement about the undeformed shell by linear theory, shape (dof,) [m]."""
        load, frame = self.loaded.force(self.modal_amplitude), self.frame
        if frame is None:
            return np.linalg.solve(self.of_functions.stiffness, load)
        return frame @ np.linalg.solve(self.of_functions.stiffness, frame.T @ load)

    def with_step(self, key: str) -> "Stepped":
        """Return the buoy at rest with an imaginary step of a variable of its device, floating freely.

        The forces at rest stay in balance, so the shape changes by K^-1 df/dx, f the force and K its tangent
        stiffness; an undeformed shell only floats higher or lower.
        """
        size = step_of(self.study, key)
        changed = with_variable(self.loaded, key, 1j * size, self.study.device)
        same = changed.basis.shell.rest is self.loaded.basis.shell.rest and not np.imag(changed.basis.shell.radius)
        force = changed.force(self.modal_amplitude, self._water_force if same else None)
        rate = self.compliance @ np.imag(force) / size
        stepped = replace(changed, centre_height=changed.centre_height + 1j * size * rate[0])
        shell = rate * (np.arange(len(rate)) > 0)
        amplitude = self.modal_amplitude + 1j * size * shell if shell.any() else self.modal_amplitude
        changed_buoy = replace(self, loaded=stepped, modal_amplitude=amplitude, stepped_from=self.rings)
        return Stepped(changed_buoy, size)

    def turned(self, key: str, degrees: float) -> "RestingBuoy":
        """Return the buoy with a colatitude of a clamp or a port turned, the modes of rings combined as they are."""
        key = f"{key}.0" if key.endswith(".clamp") else key
        study = with_values(self.study, {key: value_of(self.study, key) + degrees})
        return replace(self, study=study, loads=ring_loads(study), stepped_from=self.rings)

    @cached_property
    def _water_force(self) -> FloatArray:
        """The force of the water on the buoy at rest, which no variable changes but those of its hull, (dof,) [N]."""
        return self.loaded.water_force(self.modal_amplitude)

    @cached_property
    def compliance(self) -> FloatArray:
        """Displacement at rest per steady force on the shell as it comes to rest, shape (dof, dof) [m/N]."""
        stiffness, found = self.loaded.stiffness(self.modal_amplitude), np.zeros((len(self.modal_amplitude),) * 2)
        free = len(found) if self.study.at_equilibrium else 1
        found[:free, :free] = np.linalg.inv(stiffness[:free, :free])
        return found


@dataclass(frozen=True)
class Stepped:
    """A buoy with an imaginary step of one variable."""

    buoy: RestingBuoy
    size: float  # of the step

    def derivative(self, of: Callable[[RestingBuoy], AnyArray]) -> FloatArray:
        """Return the derivative by the variable of an analytic function of the buoy."""
        return np.asarray(np.imag(of(self.buoy)) / self.size)

    def displacement(self, colatitude: FloatArray) -> Curve:
        """Return how points of the meridian move per unit of the variable."""
        return Curve(*(np.asarray(np.imag(part) / self.size) for part in self.buoy.shape.curve(colatitude)))


def step_of(study: Study, key: str) -> float:
    """Return the size of the imaginary step of a variable of the device."""
    return STEP * (abs(value_of(study, key)) or 1.0)


def value_of(study: Study, key: str) -> float:
    """Return the value of a key of a study, such as device.damping.beta; raises `ConfigError` if it has none."""
    if (found := at_key(study, key)) is None:
        raise ConfigError(f"variables: received {key}, which the study has not; needs a key of it")
    return float(found)


def with_values(study: Study, values: Mapping[str, float]) -> Study:
    """Return a study with values of keys, of what bounds a buoy unchecked."""
    for key, value in values.items():
        study = _with(study, key.split("."), value)
    device = study.device
    if device.material.rubber:  # moduli are those of small strains
        device = device.model_copy(update={"young_modulus": device.material.young_modulus})
    return study.model_copy(update={"device": device})


def _with(part: Any, path: Sequence[str], value: float) -> Any:
    """A section, a mapping of sections or a list with the value of a key."""
    first, *rest = path
    if isinstance(part, tuple):
        place = int(first)
        return (*part[:place], _with(part[place], rest, value) if rest else value, *part[place + 1 :])
    if isinstance(part, Mapping):
        return {**part, first: _with(part[first], rest, value)}
    if not rest:
        return part.model_copy(update={first: (value,) if first == "clamp" else value})
    return part.model_copy(update={first: _with(getattr(part, first), rest, value)})


def _reshaped(device: Device, name: str, step: complex) -> ClosedMeridian:
    """The meridian of a device at rest with a step of its radius or of a number of its shape."""
    steps: dict[str, Any] = {name: step}
    shape, radius = device.shape, device.radius + steps.get("radius", 0.0)
    assert shape is not None
    if shape.spheroid:
        return spheroid(radius, shape.spheroid.height + steps.get(HEIGHT, 0.0))
    if shape.capsule:
        return capsule(radius, shape.capsule.length + steps.get(LENGTH, 0.0))
    if terms := shape.series:
        if name.startswith(SERIES):
            terms = _with(terms, name.split(".")[2:], at_key(device, name) + step)
        return series(terms.radial, terms.axial, radius)
    factor = radius / device.radius  # a profile is scaled to its radius
    return through(shape.profile or (), device.radius).scaled(factor, factor)


def with_variable(loaded: LoadedShell, key: str, step: complex, device: Device) -> LoadedShell:
    """Return a loaded shell with a step of a variable of its device, at the same height of the centre.

    Raises `ConfigError` if it is not a variable of the shell.
    """
    name, basis = key.removeprefix("device."), loaded.basis
    changed: dict[str, Any]
    if name == "internal_pressure":
        changed = {name: loaded.internal_pressure + step}
        return replace(loaded, **changed)
    if name == "mass":
        changed = {"total_mass": basis.total_mass + step}
    elif name in OF_DAMPING:
        of_damping = name.removeprefix("damping.")
        changed = {of_damping: getattr(basis, of_damping) + step}
    elif name in OF_MATERIAL and basis.shell.rubber is not None:
        of_law = name.removeprefix("material.")
        changed = {of_law: getattr(basis.shell.rubber, of_law) + step}
        rubber = replace(basis.shell.rubber, **changed)  # type: ignore[type-var]  # all laws are dataclasses
        changed = {"shell": replace(basis.shell, rubber=rubber, young_modulus=rubber.young_modulus)}
    elif name in OF_SHELL or name in OF_SHAPE or name.startswith(SERIES):
        changed = {name: getattr(basis.shell, name) + step} if name in OF_SHELL else {}
        if basis.shell.rest is not None and (name in OF_SHAPE or name.startswith(SERIES)):
            changed["rest"] = _reshaped(device, name, step)
        changed = {"shell": replace(basis.shell, **changed)}
    else:
        raise ConfigError(f"variables: received {key}; this shell has no such quantity")
    return replace(loaded, elastic=replace(loaded.elastic, basis=replace(basis, **changed)))
