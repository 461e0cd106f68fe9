# Panels: mean wetted mesh, BEM blocks on an absolute frequency grid.
MESHES = {content_id(block.mesh): block.mesh for block in BLOCKS.values()}


localrules:
    mesh,


rule mesh:
    output:
        f"{ROOT}/hydro/mesh/{{id}}/mean.nc",
    log:
        f"{ROOT}/logs/mesh/{{id}}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=lambda wildcards: canonical(MESHES[wildcards.id]),
    shell:
        "vsb mesh --out {output} <<< {params.spec:q} > {log} 2>&1"


rule panels:
    input:
        mesh=lambda wildcards: PLAN.mesh_path(BLOCKS[wildcards.id].mesh),
        green=f"{PLAN.green_folder}.done",
    output:
        f"{ROOT}/hydro/blocks/{{id}}.nc",
    log:
        f"{ROOT}/logs/panels/{{id}}.log",
    benchmark:
        f"{ROOT}/benchmarks/panels/{{id}}.tsv"
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
        "vsb panels --mesh {input.mesh} --green {params.green:q} --out {output} <<< {params.spec:q} > {log} 2>&1"
