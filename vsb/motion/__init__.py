"""Motion."""

from vsb.motion import variables as variables
