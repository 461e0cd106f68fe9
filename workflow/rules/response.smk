# What follows from the hydro database alone: radiation model, frequency response, tuning ladder.


rule radiation:
    input:
        PLAN.database_path,
    output:
        PLAN.radiation_path,
    log:
        f"{ROOT}/logs/radiation/{content_id(PLAN.radiation)}.log",
    benchmark:
        f"{ROOT}/benchmarks/radiation/{content_id(PLAN.radiation)}.tsv"
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=canonical(PLAN.radiation),
    shell:
        "vsb radiation --database {input} --out {output} <<< {params.spec:q} > {log} 2>&1"


rule response:
    input:
        PLAN.database_path,
    output:
        f"{PLAN.folder}/response.nc",
    log:
        f"{ROOT}/logs/response/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.response),
    shell:
        "vsb response --database {input} --out {output} <<< {params.spec:q} > {log} 2>&1"


rule ladder:
    input:
        PLAN.database_path,
    output:
        **PLAN.ladder_files,
        table=report(
            f"{PLAN.folder}/ladder.csv",
            caption="../report/ladder.rst",
            category="Numbers",
            labels={"table": "tuning ladder"},
        ),
    log:
        f"{ROOT}/logs/ladder/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.ladder),
        manifest=PLAN.manifest,
    shell:
        "vsb ladder --database {input} --out {output.table} --rungs {output.rungs} --manifest {params.manifest}"
        " <<< {params.spec:q} > {log} 2>&1"
