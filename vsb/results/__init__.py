"""Results of studies and campaigns: control levels, comparisons, the validity ledger, statistics, a site's year."""

from vsb.results import variables as variables
