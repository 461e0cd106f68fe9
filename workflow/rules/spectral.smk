# Coefficients of an axisymmetric shell in deep water without panels.


rule spectral:
    output:
        f"{ROOT}/hydro/blocks/{{id}}.nc",
    log:
        f"{ROOT}/logs/spectral/{{id}}.log",
    benchmark:
        f"{ROOT}/benchmarks/spectral/{{id}}.tsv"
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=lambda wildcards: canonical(BLOCKS[wildcards.id]),
    shell:
        "vsb spectral --out {output} <<< {params.spec:q} > {log} 2>&1"
