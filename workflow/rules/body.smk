# Hydro database of a body, solved of its mesh or read from its files.
if PLAN.solves:

    include: "green.smk"


rule coefficients:
    input:
        PLAN.inputs,
    output:
        PLAN.database_path,
    log:
        f"{ROOT}/logs/coefficients/{content_id(PLAN.database)}.log",
    benchmark:
        f"{ROOT}/benchmarks/coefficients/{content_id(PLAN.database)}.tsv"
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=600,
    params:
        spec=canonical(PLAN.database),
        hydro=quoted(PLAN.sources),
    shell:
        "vsb coefficients {params.hydro} --out {output} <<< {params.spec:q} > {log} 2>&1"
