# Green-function table, BEM blocks on an absolute frequency grid, hydro database, radiation model, response.


rule green:
    output:
        f"{PLAN.green_folder}.done",
    log:
        f"{ROOT}/logs/green.log",
    benchmark:
        f"{ROOT}/benchmarks/green.tsv"
    conda:
        "../envs/vsb.yaml"
    params:
        folder=subpath(output[0], strip_suffix=".done"),
    shell:
        "vsb green --folder {params.folder:q} --out {output} > {log} 2>&1"


rule bem:
    input:
        mesh=lambda wildcards: PLAN.mesh_path(BLOCKS[wildcards.id]["mesh"]),
        green=f"{PLAN.green_folder}.done",
    output:
        f"{ROOT}/hydro/blocks/{{id}}.nc",
    log:
        f"{ROOT}/logs/bem/{{id}}.log",
    benchmark:
        f"{ROOT}/benchmarks/bem/{{id}}.tsv"
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=lambda wildcards: canonical(BLOCKS[wildcards.id]),
        green=subpath(input.green, strip_suffix=".done"),
    shell:
        "vsb bem --spec {params.spec:q} --mesh {input.mesh} --green {params.green:q} --out {output} > {log} 2>&1"


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
    shell:
        "vsb database --spec {params.spec:q} --out {output} {input} > {log} 2>&1"


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
        "vsb radiation --spec {params.spec:q} --database {input} --out {output} > {log} 2>&1"


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
