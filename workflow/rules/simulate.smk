# One time-domain run per design and sea.


rule simulate:
    input:
        **PLAN.hydro_files,
    output:
        PLAN.trajectory_path("{design}", "{wave}"),
    log:
        f"{ROOT}/logs/simulate/{STUDY.study}/{{design}}-{{wave}}.log",
    benchmark:
        f"{ROOT}/benchmarks/simulate/{STUDY.study}/{{design}}-{{wave}}.tsv"
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=lambda wildcards: PLAN.simulation_megabytes(WAVES[wildcards.wave]),
        runtime=30,
    params:
        spec=lambda wildcards: canonical(
            PLAN.simulation(wildcards.design, WAVES[wildcards.wave])
        ),
        hydro=options(PLAN.hydro_files),
    shell:
        "vsb simulate {params.hydro} --out {output} <<< {params.spec:q} > {log} 2>&1"
