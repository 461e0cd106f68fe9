# Error against seconds of wet forces and integrators; of body-exact studies only, and only when asked for.


rule workprecision:
    output:
        table=f"{PLAN.folder}/workprecision.csv",
        quadrature=f"{PLAN.folder}/workprecision/quadrature.svg",
        integrators=f"{PLAN.folder}/workprecision/integrators.svg",
    log:
        f"{ROOT}/logs/workprecision/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    threads: 1
    resources:
        mem_mb=1000,
        runtime=30,
    params:
        spec=canonical(PLAN.comparison),
        folder=subpath(output.quadrature, parent=True),
    shell:
        "vsb workprecision --spec {params.spec:q} --out {output.table} --figures {params.folder} > {log} 2>&1"
