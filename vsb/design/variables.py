"""Variables of design problems in files: starts, fronts, and the buoys compared."""

from vsb.tools.variables import Variable, register

_SI = "SI unit of each"

register(
    {
        "start_value": Variable(("...", "variable"), _SI, "values of the variables where a start began"),
        "best_value": Variable(("...", "variable"), _SI, "values of the variables of the best buoy"),
        "objective": Variable(("...",), _SI, "what was maximised"),
        "quantity_value": Variable(("...", "quantity"), _SI, "quantities of the best buoy"),
        "quantity_gradient": Variable(("...", "quantity", "variable"), _SI, "derivatives of them by the variables"),
        "kkt": Variable(("...",), "1", "residual of the first-order conditions of an optimum"),
        "violation": Variable(("...",), "1", "largest excess over a limit, relative to it"),
        "limit_value": Variable(("limit_value",), _SI, "value of the limit that is varied"),
        "outline_x": Variable(("buoy", "colatitude"), "m", "radius of the hull at rest"),
        "outline_z": Variable(("buoy", "colatitude"), "m", "height of the hull at rest above still water"),
        "buoy_value": Variable(("buoy", "quantity"), _SI, "quantities of the buoys compared"),
    }
)
