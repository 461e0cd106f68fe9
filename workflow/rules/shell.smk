# Shell modes.

if "modes" in RULES:

    rule modes:
        """Modes of the shell at rest, of every design: shapes, dry frequencies, elastic stiffness."""
        input:
            RULES["modes"].needs,
        output:
            made(RULES["modes"]),
        log:
            RULES["modes"].record("logs"),
        benchmark:
            RULES["modes"].record("benchmarks")
        wildcard_constraints:
            job=RULES["modes"].names,
        localrule: True
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["modes"].megabytes,
            runtime=RULES["modes"].minutes,
        params:
            ids=RULES["modes"].ids,
            tasks=RULES["modes"].text,
        shell:
            "vsb stage modes <<< {params.tasks:q} > {log} 2>&1"


if "meshes" in RULES:

    rule meshes:
        """The shell at rest with the displacement of each mode, as a mesh to look at."""
        input:
            RULES["meshes"].needs,
        output:
            made(RULES["meshes"]),
        log:
            RULES["meshes"].record("logs"),
        benchmark:
            RULES["meshes"].record("benchmarks")
        wildcard_constraints:
            job=RULES["meshes"].names,
        localrule: True
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["meshes"].megabytes,
            runtime=RULES["meshes"].minutes,
        params:
            ids=RULES["meshes"].ids,
            tasks=RULES["meshes"].text,
        shell:
            "vsb stage meshes <<< {params.tasks:q} > {log} 2>&1"
