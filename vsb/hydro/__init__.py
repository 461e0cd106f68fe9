"""Hydro."""
