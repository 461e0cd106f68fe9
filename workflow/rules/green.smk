# The Green-function table of panels, once for all jobs.


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
