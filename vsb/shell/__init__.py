"""The elastic shell: shape, modes, deformation in still water, load, equilibrium and buckling.

Knows nothing of waves or motion in time.
May import errors, tools and study.
"""

from vsb.shell import variables as variables
