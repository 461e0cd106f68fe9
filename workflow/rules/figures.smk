# Figures and the self-contained report.
import os

FIGURES = [f"{PLAN.folder}/figures/{name}.svg" for name in figure_names(list(WAVES))]


rule figures:
    input:
        modes=f"{PLAN.folder}/modes.nc",
        database=PLAN.database_path,
        radiation=PLAN.radiation_path,
        response=f"{PLAN.folder}/response.nc",
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
    shell:
        "vsb figures --study {input.study} --modes {input.modes} --database {input.database}"
        " --radiation {input.radiation} --response {input.response} --out {params.folder}"
        " {input.trajectories} > {log} 2>&1"


rule report:
    input:
        study=f"{PLAN.folder}/study.json",
        table=f"{PLAN.folder}/comparison.csv",
        validity=f"{PLAN.folder}/validity.json",
        response=f"{PLAN.folder}/response.nc",
        database=PLAN.database_path,
        radiation=PLAN.radiation_path,
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
    shell:
        "vsb report --study {input.study} --table {input.table} --validity {input.validity}"
        " --response {input.response} --database {input.database} --radiation {input.radiation}"
        " --figures {params.figures} --out {output} {input.trajectories} > {log} 2>&1"
