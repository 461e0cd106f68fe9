# Campaigns: many points of a study over the year of a site.

if "members" in RULES:

    rule members:
        """Some points of a campaign, every design and tuning over the year; finished points are kept."""
        input:
            RULES["members"].needs,
        output:
            made(RULES["members"]),
        log:
            RULES["members"].record("logs"),
        benchmark:
            RULES["members"].record("benchmarks")
        wildcard_constraints:
            job=RULES["members"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["members"].megabytes,
            runtime=RULES["members"].minutes,
        params:
            ids=RULES["members"].ids,
            tasks=RULES["members"].text,
        shell:
            "vsb stage members <<< {params.tasks:q} > {log} 2>&1"


for one in batches("verification"):

    rule:
        """Points of a campaign in seas drawn from the year, followed in time."""
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
            "vsb stage verification <<< {params.tasks:q} > {log} 2>&1"


if "campaign" in RULES:

    rule campaign:
        """All points together: data, table, figures, page."""
        input:
            RULES["campaign"].needs,
        output:
            made(RULES["campaign"]),
        log:
            RULES["campaign"].record("logs"),
        benchmark:
            RULES["campaign"].record("benchmarks")
        wildcard_constraints:
            job=RULES["campaign"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["campaign"].megabytes,
            runtime=RULES["campaign"].minutes,
        params:
            ids=RULES["campaign"].ids,
            tasks=RULES["campaign"].text,
        shell:
            "vsb stage campaign <<< {params.tasks:q} > {log} 2>&1"
