# Figures and the self-contained report.
import os

FIGURES = [f"{PLAN.folder}/figures/{name}.svg" for name in figure_names(STUDY)]


rule figures:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        modes=f"{PLAN.folder}/modes.nc",
        study=f"{PLAN.folder}/study.json",
        trajectories=TRAJECTORIES,
    output:
        FIGURES,
    log:
        f"{ROOT}/logs/figures/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    params:
        folder=subpath(output[0], parent=True),
        hydro=HYDRO,
    shell:
        "vsb figures --study {input.study} --modes {input.modes} {params.hydro} --out {params.folder}"
        " {input.trajectories} > {log} 2>&1"


rule report:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
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
    params:
        figures=lambda wildcards, input: os.path.dirname(input.figures[0]),
        hydro=HYDRO,
    shell:
        "vsb report --study {input.study} --table {input.table} --statistics {input.statistics} --validity {input.validity} {params.hydro}"
        " --figures {params.figures} --out {output} {input.trajectories} > {log} 2>&1"
