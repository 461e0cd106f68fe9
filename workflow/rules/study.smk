# A study: what is solved or read of its water, runs in time, tables, figures and report.
STUDY = PLAN.study
WAVES = {wave.label: wave for wave in STUDY.waves}


report: "../report/workflow.rst"


wildcard_constraints:
    id="[0-9a-f]{16}",
    design="[A-Za-z0-9_]+",


if "body" in config:

    include: "body.smk"
    include: "response.smk"

else:
    BLOCKS = PLAN.bem_blocks

    include: "mesh.smk"

    if BLOCKS:

        include: "hydro.smk"
        include: "response.smk"


include: "simulate.smk"
include: "compare.smk"
include: "figures.smk"
