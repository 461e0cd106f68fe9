"""Waves: dispersion, kinds of seas and their realisations, a site's climate and the files it is read from.

Knows no device. A sea is one class of `kinds` with its keys, words and spectral density; `seas` makes components of it.

Examples
--------
A storm's significant height, energy period, and power per metre of crest [m, s, kW/m]:

>>> from vsb.engine.waves.kinds import Jonswap
>>> from vsb.engine.waves.seas import sea_energy
>>> from vsb.engine.waves.water import Water
>>> height, period, flux = sea_energy(Jonswap(kind="jonswap", hs=4.0, tp=10.0), Water())
>>> height, round(period, 2), round(flux / 1000, 1)
(4.0, 9.03, 70.9)
"""
