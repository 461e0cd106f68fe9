# Error against seconds and memory of hydrodynamic coefficients; of no study, and only when asked for.


rule hydro_precision:
    output:
        table=f"{ROOT}/hydro_precision/hydro_precision.csv",
        ratios=f"{ROOT}/hydro_precision/hydro_precision_ratios.csv",
        figure=f"{ROOT}/hydro_precision/hydro_precision.svg",
    log:
        f"{ROOT}/logs/hydro_precision.log",
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=4000,
        runtime=60,
    params:
        folder=subpath(output.table, parent=True),
    shell:
        "vsb hydro-precision {params.folder:q} > {log} 2>&1"
