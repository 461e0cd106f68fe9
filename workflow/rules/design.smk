# Design problems: the best flexible buoy beside the best rigid one.

for one in batches("design_start"):

    rule:
        """Searches for the best buoy from one start, or from several where these are short."""
        name:
            one.name
        input:
            one.needs,
        output:
            made(one),
        log:
            one.record("logs"),
        benchmark:
            one.record("benchmarks")
        wildcard_constraints:
            job=one.names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=one.megabytes,
            runtime=one.minutes,
        params:
            ids=one.ids,
            tasks=one.text,
        shell:
            "vsb stage design_start <<< {params.tasks:q} > {log} 2>&1"


if "design_front" in RULES:

    rule design_front:
        """The best buoys over the values of one limit."""
        input:
            RULES["design_front"].needs,
        output:
            made(RULES["design_front"]),
        log:
            RULES["design_front"].record("logs"),
        benchmark:
            RULES["design_front"].record("benchmarks")
        wildcard_constraints:
            job=RULES["design_front"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["design_front"].megabytes,
            runtime=RULES["design_front"].minutes,
        params:
            ids=RULES["design_front"].ids,
            tasks=RULES["design_front"].text,
        shell:
            "vsb stage design_front <<< {params.tasks:q} > {log} 2>&1"


if "design_verification" in RULES:

    rule design_verification:
        """The best flexible and the best rigid buoy in the same seas, in time."""
        input:
            RULES["design_verification"].needs,
        output:
            made(RULES["design_verification"]),
        log:
            RULES["design_verification"].record("logs"),
        benchmark:
            RULES["design_verification"].record("benchmarks")
        wildcard_constraints:
            job=RULES["design_verification"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["design_verification"].megabytes,
            runtime=RULES["design_verification"].minutes,
        params:
            ids=RULES["design_verification"].ids,
            tasks=RULES["design_verification"].text,
        shell:
            "vsb stage design_verification <<< {params.tasks:q} > {log} 2>&1"


if "design_results" in RULES:

    rule design_results:
        """The best buoys, their gain and its uncertainty; figures, page."""
        input:
            RULES["design_results"].needs,
        output:
            made(RULES["design_results"]),
        log:
            RULES["design_results"].record("logs"),
        benchmark:
            RULES["design_results"].record("benchmarks")
        wildcard_constraints:
            job=RULES["design_results"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["design_results"].megabytes,
            runtime=RULES["design_results"].minutes,
        params:
            ids=RULES["design_results"].ids,
            tasks=RULES["design_results"].text,
        shell:
            "vsb stage design_results <<< {params.tasks:q} > {log} 2>&1"
