"""Rule ladder: what each design takes of each sea, from the given damper up to the matched limit."""

from vsb.motion.port import port_direction
from vsb.results.ladder import Given, as_csv, frequencies, ladder
from vsb.scenes.build import linear_buoy
from vsb.shell.deformed import DeformedShell
from vsb.shell.modes import design_motions
from vsb.stages.stage import partial_study, stamp
from vsb.study.specs import LadderSpec
from vsb.study.study import IrregularSea, StillWater
from vsb.tools.files import write_text
from vsb.tools.stamps import record
from vsb.waves.seas import sea


def run(spec: LadderSpec, database: str, out: str, manifest: str) -> None:
    """Write the ladder of a study; still water has no rungs."""
    study = partial_study(spec)
    buoy, basis = linear_buoy(study, database)
    waves = [wave for wave in study.waves if not isinstance(wave, StillWater)]
    seas = {wave.label: sea(wave, study.hydro.omega_max, study.simulation.duration) for wave in waves}
    names = [wave.family if isinstance(wave, IrregularSea) else wave.label for wave in waves]
    families = [names.index(name) for name in dict.fromkeys(names)]
    direction = port_direction("heave", DeformedShell(basis, study.centre_height))
    omega = frequencies(list(seas.values())) if seas else None
    ports = {
        d: buoy.port(omega, design_motions(study, basis, d), direction) for d in study.designs if omega is not None
    }
    given = {design: Given(study.pto.damping) for design in study.designs}
    write_text(out, as_csv(ladder(ports, seas, families, given, study.simulation.duration)))
    record(manifest, stamp(spec, database)["spec_id"], [out])
