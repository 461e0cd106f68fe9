# Frequency response of all designs, and one time-domain run per design and sea.


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
        "vsb response --spec {params.spec:q} --database {input} --out {output} > {log} 2>&1"


rule simulate:
    input:
        database=PLAN.database_path,
        radiation=PLAN.radiation_path,
    output:
        PLAN.trajectory_path("{design}", "{wave}"),
    log:
        f"{ROOT}/logs/simulate/{STUDY.study}/{{design}}-{{wave}}.log",
    benchmark:
        f"{ROOT}/benchmarks/simulate/{STUDY.study}/{{design}}-{{wave}}.tsv"
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=lambda wildcards: canonical(
            PLAN.simulation(wildcards.design, WAVES[wildcards.wave])
        ),
    shell:
        "vsb simulate --spec {params.spec:q} --database {input.database} --radiation {input.radiation}"
        " --out {output} > {log} 2>&1"
