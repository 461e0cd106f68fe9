"""Flexible (variable-shape) against rigid (fixed-shape) wave-energy buoys, from shell modes to absorbed power."""

__version__ = "0.1.0"
