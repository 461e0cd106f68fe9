"""Variables of the shell in files: modes, shape at rest, enclosed volume and area."""

from vsb.tools.variables import Variable, register

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
