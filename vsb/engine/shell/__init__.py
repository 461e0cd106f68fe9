"""The elastic shell: shape, material, modes, deformation in still water, load, equilibrium and buckling.

Knows no waves and no motion in time. `device` and `material` are what a file says of a buoy, `shell` is the wall.

Examples
--------
The two natural frequencies of a sphere's ovalling, degree 2, in vacuum [rad/s]:

>>> from vsb.engine.shell.shell import Shell, natural_frequencies
>>> shell = Shell(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0)
>>> [round(float(omega), 2) for omega in natural_frequencies(shell, 2)]
[22.36, 86.82]
"""

from vsb.tools.variables import Variable, register

# variables of files
_SHAPE = ("mode", "colatitude")

register(
    {
        "colatitude": Variable(("colatitude",), "rad", "colatitude from the top pole"),
        "radial": Variable(_SHAPE, "1", "radial displacement per unit modal amplitude"),
        "meridional": Variable(_SHAPE, "1", "meridional displacement per unit modal amplitude"),
        "degree": Variable(("mode",), "1", "Legendre degree of the mode"),
        "order": Variable(("mode",), "1", "azimuthal order m of the mode, proportional to cos(m theta)"),
        "rest_radial": Variable(("colatitude",), "m", "radial displacement from the sphere to the shape at rest"),
        "rest_meridional": Variable(
            ("colatitude",), "m", "meridional displacement from the sphere to the shape at rest"
        ),
        "static_amplitude": Variable(("mode",), "m", "modal amplitude of the shape at rest"),
        "dry_frequency": Variable(("mode",), "rad/s", "natural angular frequency in vacuum"),
        "volume": Variable(("time",), "m^3", "volume the shell encloses"),
        "area": Variable(("time",), "m^2", "surface area of the shell"),
    }
)
