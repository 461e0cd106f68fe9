"""Waves: dispersion, regular and irregular seas, a site's climate and the files it is read from.

Knows nothing of devices.
May import errors, tools and study.
"""
