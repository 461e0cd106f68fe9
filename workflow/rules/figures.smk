# Figures and the self-contained report.
FIGURES = [f"{PLAN.folder}/figures/{name}.svg" for name in figure_names(STUDY)]


rule figures:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        **PLAN.witness_files,
        modes=f"{PLAN.folder}/modes.nc",
        study=f"{PLAN.folder}/study.json",
        trajectories=TRAJECTORIES,
    output:
        FIGURES,
    log:
        f"{ROOT}/logs/figures/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=PLAN.study_megabytes,
    params:
        folder=subpath(output[0], parent=True),
        hydro=HYDRO,
        trajectories=subpath(
            lambda wildcards, input: input.trajectories[0], parent=True
        ),
    shell:
        "vsb figures --modes {input.modes} {params.hydro} --trajectories {params.trajectories} --out {params.folder}"
        " < {input.study} > {log} 2>&1"


rule report:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        **PLAN.witness_files,
        study=f"{PLAN.folder}/study.json",
        table=f"{PLAN.folder}/comparison.csv",
        statistics=f"{PLAN.folder}/statistics.csv",
        validity=f"{PLAN.folder}/validity.json",
        trajectories=TRAJECTORIES,
        figures=FIGURES,
    output:
        f"{PLAN.folder}/report.html",
    log:
        f"{ROOT}/logs/report/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=PLAN.study_megabytes,
    params:
        hydro=HYDRO,
        trajectories=subpath(
            lambda wildcards, input: input.trajectories[0], parent=True
        ),
        figures=subpath(lambda wildcards, input: input.figures[0], parent=True),
    shell:
        "vsb report --table {input.table} --statistics {input.statistics} --validity {input.validity} {params.hydro}"
        " --trajectories {params.trajectories} --figures {params.figures} --out {output}"
        " < {input.study} > {log} 2>&1"
