# Coefficients of the water: added mass, radiation damping, excitation.

if "green" in RULES:

    rule green:
        """Capytaine's table of the Green function, once per machine: 20 s."""
        input:
            RULES["green"].needs,
        output:
            made(RULES["green"]),
        log:
            RULES["green"].record("logs"),
        benchmark:
            RULES["green"].record("benchmarks")
        wildcard_constraints:
            job=RULES["green"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["green"].megabytes,
            runtime=RULES["green"].minutes,
        params:
            ids=RULES["green"].ids,
            tasks=RULES["green"].text,
        shell:
            "vsb stage green <<< {params.tasks:q} > {log} 2>&1"


if "mesh" in RULES:

    rule mesh:
        """Mean wetted meshes, as fine as each block of frequencies needs."""
        input:
            RULES["mesh"].needs,
        output:
            made(RULES["mesh"]),
        log:
            RULES["mesh"].record("logs"),
        benchmark:
            RULES["mesh"].record("benchmarks")
        wildcard_constraints:
            job=RULES["mesh"].names,
        localrule: True
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["mesh"].megabytes,
            runtime=RULES["mesh"].minutes,
        params:
            ids=RULES["mesh"].ids,
            tasks=RULES["mesh"].text,
        shell:
            "vsb stage mesh <<< {params.tasks:q} > {log} 2>&1"


if "panels" in RULES:

    rule panels:
        """A block of frequencies by capytaine, in all displacements of the shell; a coarser mesh gives the error."""
        input:
            RULES["panels"].needs,
        output:
            made(RULES["panels"]),
        log:
            RULES["panels"].record("logs"),
        benchmark:
            RULES["panels"].record("benchmarks")
        wildcard_constraints:
            job=RULES["panels"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["panels"].megabytes,
            runtime=RULES["panels"].minutes,
        params:
            ids=RULES["panels"].ids,
            tasks=RULES["panels"].text,
        shell:
            "vsb stage panels <<< {params.tasks:q} > {log} 2>&1"


if "spectral" in RULES:

    rule spectral:
        """All frequencies of an axisymmetric shell by the spectral solver, which needs no mesh."""
        input:
            RULES["spectral"].needs,
        output:
            made(RULES["spectral"]),
        log:
            RULES["spectral"].record("logs"),
        benchmark:
            RULES["spectral"].record("benchmarks")
        wildcard_constraints:
            job=RULES["spectral"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["spectral"].megabytes,
            runtime=RULES["spectral"].minutes,
        params:
            ids=RULES["spectral"].ids,
            tasks=RULES["spectral"].text,
        shell:
            "vsb stage spectral <<< {params.tasks:q} > {log} 2>&1"


if "cross_check" in RULES:

    rule cross_check:
        """Meshes of the shell deformed by each mode and sign, solved by capytaine and by the spectral solver."""
        input:
            RULES["cross_check"].needs,
        output:
            made(RULES["cross_check"]),
        log:
            RULES["cross_check"].record("logs"),
        benchmark:
            RULES["cross_check"].record("benchmarks")
        wildcard_constraints:
            job=RULES["cross_check"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["cross_check"].megabytes,
            runtime=RULES["cross_check"].minutes,
        params:
            ids=RULES["cross_check"].ids,
            tasks=RULES["cross_check"].text,
        shell:
            "vsb stage cross_check <<< {params.tasks:q} > {log} 2>&1"


if "database" in RULES:

    rule database:
        """The blocks in terms of the shell modes, checked: the hydro database; and its radiation memory."""
        input:
            RULES["database"].needs,
        output:
            made(RULES["database"]),
        log:
            RULES["database"].record("logs"),
        benchmark:
            RULES["database"].record("benchmarks")
        wildcard_constraints:
            job=RULES["database"].names,
        conda:
            "../envs/vsb.yaml"
        threads: 1
        resources:
            mem_mb=RULES["database"].megabytes,
            runtime=RULES["database"].minutes,
        params:
            ids=RULES["database"].ids,
            tasks=RULES["database"].text,
        shell:
            "vsb stage database <<< {params.tasks:q} > {log} 2>&1"


for one in batches("frequencies"):

    rule:
        """Frequencies of a body by capytaine, where they take long."""
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
            "vsb stage frequencies <<< {params.tasks:q} > {log} 2>&1"


for one in batches("coefficients"):

    rule:
        """The hydro database of any body, solved by capytaine or read, checked; and its radiation memory."""
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
            "vsb stage coefficients <<< {params.tasks:q} > {log} 2>&1"
