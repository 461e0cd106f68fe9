# Designs side by side: the comparison table and the validity ledger.
TRAJECTORIES = [
    PLAN.trajectory_path(design, wave) for wave in WAVES for design in STUDY.designs
]


rule compare:
    input:
        database=PLAN.database_path,
        radiation=PLAN.radiation_path,
        response=f"{PLAN.folder}/response.nc",
        trajectories=TRAJECTORIES,
    output:
        table=f"{PLAN.folder}/comparison.csv",
        validity=f"{PLAN.folder}/validity.json",
        study=f"{PLAN.folder}/study.json",
    log:
        f"{ROOT}/logs/compare/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        spec=canonical(PLAN.comparison),
    shell:
        "vsb compare --spec {params.spec:q} --database {input.database} --radiation {input.radiation}"
        " --response {input.response} --out {output.table} --validity {output.validity} --study {output.study}"
        " {input.trajectories} > {log} 2>&1"
