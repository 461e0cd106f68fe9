# Hydro database of a buoy; coefficients from panels or from the spectral solver.
include: "panels.smk" if STUDY.uses_panels else "spectral.smk"


if STUDY.uses_panels or PLAN.witness:

    include: "green.smk"


if PLAN.witness:

    include: "witness.smk"


rule database:
    input:
        [PLAN.block_path(block) for block in BLOCKS.values()],
    output:
        PLAN.database_path,
    log:
        f"{ROOT}/logs/database/{content_id(PLAN.database)}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.database),
        blocks=subpath(input[0], parent=True),
    shell:
        "vsb database --blocks {params.blocks} --out {output} <<< {params.spec:q} > {log} 2>&1"
