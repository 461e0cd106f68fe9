# Motion in the frequency domain and in time.

if "response" in RULES:

    rule response:
        """Frequency response of all designs, and their mean power at every control level."""
        input:
            RULES["response"].needs,
        output:
            made(RULES["response"]),
        log:
            RULES["response"].record("logs"),
        benchmark:
            RULES["response"].record("benchmarks")
        wildcard_constraints:
            job=RULES["response"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["response"].megabytes,
            runtime=RULES["response"].minutes,
        params:
            ids=RULES["response"].ids,
            tasks=RULES["response"].text,
        shell:
            "vsb stage response <<< {params.tasks:q} > {log} 2>&1"


for one in batches("simulate"):

    rule:
        """Designs in seas, followed in time: a run of ten seconds or more alone, shorter ones together."""
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
            "vsb stage simulate <<< {params.tasks:q} > {log} 2>&1"
