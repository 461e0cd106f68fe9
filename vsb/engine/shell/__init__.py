"""The elastic shell: shape, material, modes, deformation in still water, load, equilibrium and buckling.

Knows no waves and no motion in time. `device` and `material` are what a file says of a buoy, `shell` is the wall.

Examples
--------
The two natural frequencies of a sphere's ovalling, degree 2, in vacuum [rad/s]:

>>> from vsb.engine.shell.shell import Shell, natural_frequencies
>>> shell = Shell(radius=2.0, thickness=0.01, young_modulus=1e7, poisson_ratio=0.3, density=2700.0)
>>> [round(float(omega), 2) for omega in natural_frequencies(shell, 2)]
[22.36, 86.82]
"""

from vsb.engine.shell import variables as variables
