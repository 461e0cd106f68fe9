# A second solver: meshes of the mean and of deformed shells, and both solvers on them.


localrules:
    deformed,


rule deformed:
    output:
        PLAN.deformed_paths,
    log:
        f"{ROOT}/logs/deformed/{content_id(PLAN.witness.meshes)}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.witness.meshes),
        folder=subpath(output[0], parent=True),
    shell:
        "vsb deformed --out {params.folder} <<< {params.spec:q} > {log} 2>&1"


rule witness:
    input:
        meshes=PLAN.deformed_paths,
        green=f"{PLAN.green_folder}.done",
    output:
        PLAN.witness_files["witness"],
    log:
        f"{ROOT}/logs/witness/{content_id(PLAN.witness)}.log",
    benchmark:
        f"{ROOT}/benchmarks/witness/{content_id(PLAN.witness)}.tsv"
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=canonical(PLAN.witness),
        meshes=subpath(lambda wildcards, input: input.meshes[0], parent=True),
        green=subpath(input.green, strip_suffix=".done"),
    shell:
        "vsb witness --meshes {params.meshes} --green {params.green:q} --out {output} <<< {params.spec:q} > {log} 2>&1"
