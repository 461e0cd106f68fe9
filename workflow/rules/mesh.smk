# Shell modes, and viewable deformed meshes.


wildcard_constraints:
    id="[0-9a-f]{16}",
    design="[A-Za-z0-9_]+",


localrules:  # of a second or less: no queue, no second snakemake
    modes,
    display,


rule modes:
    output:
        f"{PLAN.folder}/modes.nc",
    log:
        f"{ROOT}/logs/modes/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.modes),
    shell:
        "vsb modes --out {output} <<< {params.spec:q} > {log} 2>&1"


rule display:
    output:
        PLAN.display_paths,
    log:
        f"{ROOT}/logs/display/{content_id(PLAN.display)}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.display),
        manifest=lambda wildcards, output: PLAN.manifest,  # not compared between runs: studies share these meshes
        folder=subpath(output[0], parent=True),
    shell:
        "vsb display --out {params.folder} --manifest {params.manifest} <<< {params.spec:q} > {log} 2>&1"
