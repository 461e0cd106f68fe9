"""Hydro."""

from vsb.hydro import variables as variables
