# Flexible against rigid wave-energy buoys: the whole chain, one `vsb` command per rule.
#   snakemake --configfile config/other.yaml      another study; without it, the seed study
from vsb.study.study import canonical, content_id
from vsb.study.plan import StudyPlan, figure_names, options

if "device" not in config:

    configfile: "config/seed.yaml"


PLAN = StudyPlan.of(config)
STUDY = PLAN.study
ROOT = PLAN.root
BLOCKS = PLAN.bem_blocks
WAVES = {wave.label: wave for wave in STUDY.waves}


rule all:
    input:
        PLAN.products,


include: "workflow/rules/mesh.smk"


if BLOCKS:

    include: "workflow/rules/hydro.smk"


include: "workflow/rules/simulate.smk"
include: "workflow/rules/compare.smk"
include: "workflow/rules/figures.smk"
