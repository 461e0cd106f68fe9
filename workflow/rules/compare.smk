# Designs side by side: the comparison table and the validity ledger.
TRAJECTORIES = [
    PLAN.trajectory_path(design, wave) for wave in WAVES for design in STUDY.designs
]


HYDRO = options({**PLAN.hydro_files, **PLAN.response_files, **PLAN.witness_files})


rule compare:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        **PLAN.witness_files,
        **PLAN.ladder_files,
        trajectories=TRAJECTORIES,
    output:
        table=report(
            f"{PLAN.folder}/comparison.csv",
            caption="../report/comparison.rst",
            category="Numbers",
            labels={"table": "designs side by side"},
        ),
        statistics=report(
            f"{PLAN.folder}/statistics.csv",
            caption="../report/statistics.rst",
            category="Numbers",
            labels={"table": "irregular seas"},
        ),
        validity=report(
            f"{PLAN.folder}/validity.json",
            caption="../report/validity.rst",
            category="What to doubt",
            labels={"table": "ledger"},
        ),
        study=f"{PLAN.folder}/study.json",
        tables=f"{PLAN.folder}/tables.json",
    log:
        f"{ROOT}/logs/compare/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=PLAN.study_megabytes,
    params:
        spec=canonical(PLAN.comparison),
        hydro=" ".join([HYDRO, options(PLAN.ladder_files)]),
        manifest=PLAN.manifest,
        trajectories=subpath(
            lambda wildcards, input: input.trajectories[0], parent=True
        ),
    shell:
        "vsb compare {params.hydro} --trajectories {params.trajectories}"
        " --out {output.table} --statistics {output.statistics} --validity {output.validity} --study {output.study}"
        " --tables {output.tables} --manifest {params.manifest}"
        " <<< {params.spec:q} > {log} 2>&1"
