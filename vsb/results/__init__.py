"""Results of studies and campaigns: control levels, comparisons, the validity ledger, statistics, a site's year.

May import from all rooms below: errors, tools, study, shell, waves, hydro, motion, integrators, scenes.
"""

from vsb.results import variables as variables
