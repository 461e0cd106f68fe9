# What a study says.

if "results" in RULES:

    rule results:
        """Comparison of the designs, statistics, ledger of doubts; all figures; the page."""
        input:
            RULES["results"].needs,
        output:
            made(RULES["results"]),
        log:
            RULES["results"].record("logs"),
        benchmark:
            RULES["results"].record("benchmarks")
        wildcard_constraints:
            job=RULES["results"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["results"].megabytes,
            runtime=RULES["results"].minutes,
        params:
            ids=RULES["results"].ids,
            tasks=RULES["results"].text,
        shell:
            "vsb stage results <<< {params.tasks:q} > {log} 2>&1"
