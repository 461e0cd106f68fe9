"""Results."""

from vsb.results import variables as variables
