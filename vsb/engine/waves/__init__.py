"""Waves: dispersion, kinds of seas and their realisations, a site's climate and the files it is read from.

Knows no device. A kind of sea is one class with its keys, words, spectral density and components, most in `kinds`.

Examples
--------
A storm's significant height, energy period, and power per metre of crest [m, s, kW/m]:

>>> from vsb.engine.waves.kinds import Jonswap
>>> from vsb.engine.waves.water import Water
>>> height, period, flux = Jonswap(kind="jonswap", hs=4.0, tp=10.0).energy(Water())
>>> height, round(period, 2), round(flux / 1000, 1)
(4.0, 9.03, 70.9)
"""
