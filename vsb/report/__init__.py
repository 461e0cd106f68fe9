"""Figures, pages and answers in words, made from results alone.

Imports every room except stages and cli.
"""
