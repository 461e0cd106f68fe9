"""Rule ladder: what each design takes of each sea, from the given damper up to the matched limit."""

from vsb.results.ladder import as_csv, study_ladder
from vsb.stages.stage import partial_study, stamp
from vsb.study.specs import LadderSpec
from vsb.tools.files import write_text
from vsb.tools.stamps import record


def run(spec: LadderSpec, database: str, out: str, manifest: str) -> None:
    """Write the ladder of a study, for people: the report's comes with its other data."""
    write_text(out, as_csv(study_ladder(partial_study(spec), database)))
    record(manifest, stamp(spec, database)["spec_id"], [out])
