"""Sixdof."""
