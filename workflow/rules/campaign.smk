# A campaign: batches of members, then all of them together, then the answer.


report: "../report/campaign_workflow.rst"


rule members:
    input:
        PLAN.loaded.climate_path,
    output:
        PLAN.batch_path("{batch}"),
    log:
        f"{ROOT}/logs/members/{PLAN.name}-{{batch}}.log",
    benchmark:
        f"{ROOT}/benchmarks/members/{PLAN.name}-{{batch}}.tsv"
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=2000,
        runtime=PLAN.batch_minutes,
    params:
        spec=lambda wildcards: canonical(PLAN.batches[wildcards.batch]),
        folder=f"{PLAN.folder}/members",
        root=ROOT,
    shell:
        "vsb members --climate {input:q} --folder {params.folder} --root {params.root} --out {output}"
        " <<< {params.spec:q} > {log} 2>&1"


rule verification:
    input:
        PLAN.loaded.climate_path,
    output:
        PLAN.verification_path("{verification}"),
    log:
        f"{ROOT}/logs/verification/{PLAN.name}-{{verification}}.log",
    benchmark:
        f"{ROOT}/benchmarks/verification/{PLAN.name}-{{verification}}.tsv"
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=2000,
        runtime=240,
    params:
        spec=lambda wildcards: canonical(PLAN.verifications[wildcards.verification]),
        root=ROOT,
    shell:
        "vsb verification --climate {input:q} --root {params.root} --out {output}"
        " <<< {params.spec:q} > {log} 2>&1"


rule campaign:
    input:
        PLAN.batch_paths,
        PLAN.verification_paths,
    output:
        data=PLAN.data_path,
        table=report(
            PLAN.table_path,
            caption="../report/campaign_table.rst",
            category="Numbers",
            labels={"table": "every point, design and tuning"},
        ),
    log:
        f"{ROOT}/logs/campaign/{PLAN.name}.log",
    conda:
        "../envs/vsb.yaml"
    resources:
        mem_mb=4000,
    params:
        spec=canonical(PLAN.campaign),
        batches=f"{PLAN.folder}/batches",
        verifications=f"{PLAN.folder}/verification",
        manifest=PLAN.manifest,
    shell:
        "vsb campaign --batches {params.batches} --verifications {params.verifications} --out {output.data} --table {output.table}"
        " --manifest {params.manifest} <<< {params.spec:q} > {log} 2>&1"


DRAWN = {
    path.rpartition("/")[2].removesuffix(".svg"): path
    for path in PLAN.figure_paths
    if path.endswith(".svg")
}


rule answer:
    input:
        data=PLAN.data_path,
        climate=PLAN.loaded.climate_path,
    output:
        report=report(
            f"{PLAN.folder}/report.html",
            caption="../report/campaign_report.rst",
            category="The answer",
            labels={"page": "report"},
        ),
        drawn=[
            report(
                path,
                caption="../report/campaign_figures.rst",
                category="Figures",
                labels={"figure": name.replace("_", " ")},
            )
            for name, path in DRAWN.items()
        ],
        others=[path for path in PLAN.figure_paths if path not in DRAWN.values()],
    log:
        f"{ROOT}/logs/answer/{PLAN.name}.log",
    conda:
        "../envs/vsb.yaml"
    threads: 2  # half of the figures are drawn aside
    resources:
        mem_mb=4000,
    params:
        spec=canonical(PLAN.campaign),
        figures=f"{PLAN.folder}/figures",
        manifest=PLAN.manifest,
        root=ROOT,
    shell:
        "vsb answer --data {input.data} --climate {input.climate:q} --root {params.root} --figures {params.figures} --out {output.report} --manifest {params.manifest}"
        " <<< {params.spec:q} > {log} 2>&1"
