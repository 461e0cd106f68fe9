# Figures and the self-contained report.
FIGURES = figure_paths(PLAN.folder, PLAN.figures)
DRAWN = {name: f"{PLAN.folder}/figures/{name}.svg" for name in PLAN.figures}


rule figures:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        **PLAN.witness_files,
        **PLAN.modes_files,
        trajectories=TRAJECTORIES,
    output:
        [
            report(
                path,
                caption="../report/figures.rst",
                category="Figures",
                subcategory=name.partition("-")[2] or "the whole band",
                labels={"figure": name.partition("-")[0].replace("_", " ")},
            )
            for name, path in DRAWN.items()
        ],
        [path for path in FIGURES if path not in DRAWN.values()],
    log:
        f"{ROOT}/logs/figures/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=PLAN.study_megabytes,
    params:
        spec=canonical(STUDY),
        manifest=PLAN.manifest,
        folder=subpath(output[0], parent=True),
        hydro=" ".join([options(PLAN.modes_files), HYDRO]),
        trajectories=subpath(
            lambda wildcards, input: input.trajectories[0], parent=True
        ),
    shell:
        "vsb figures {params.hydro} --trajectories {params.trajectories} --out {params.folder}"
        " --manifest {params.manifest} <<< {params.spec:q} > {log} 2>&1"


rule report:
    input:
        **PLAN.hydro_files,
        **PLAN.response_files,
        **PLAN.witness_files,
        **PLAN.modes_files,
        tables=f"{PLAN.folder}/tables.json",
        trajectories=TRAJECTORIES,
        figures=FIGURES,
    output:
        report(
            f"{PLAN.folder}/report.html",
            caption="../report/report.rst",
            category="The answer",
            labels={"page": "report"},
        ),
    log:
        f"{ROOT}/logs/report/{STUDY.study}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=PLAN.study_megabytes,
    params:
        spec=canonical(STUDY),
        manifest=PLAN.manifest,
        hydro=" ".join([options(PLAN.modes_files), HYDRO]),
        trajectories=subpath(
            lambda wildcards, input: input.trajectories[0], parent=True
        ),
        figures=subpath(lambda wildcards, input: input.figures[0], parent=True),
    shell:
        "vsb report --tables {input.tables} {params.hydro}"
        " --trajectories {params.trajectories} --figures {params.figures} --out {output}"
        " --manifest {params.manifest} <<< {params.spec:q} > {log} 2>&1"
