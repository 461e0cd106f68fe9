"""Shell."""

from vsb.shell import variables as variables
