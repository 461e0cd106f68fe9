# A study: what is solved of its water, runs in time, tables, figures and report.
STUDY = PLAN.study
BLOCKS = PLAN.bem_blocks
WAVES = {wave.label: wave for wave in STUDY.waves}


report: "../report/workflow.rst"


include: "mesh.smk"


if BLOCKS:

    include: "hydro.smk"


include: "simulate.smk"
include: "compare.smk"
include: "figures.smk"
