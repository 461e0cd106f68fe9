"""Rule ladder: what each design takes of each sea, from the given damper up to the matched limit."""

import json

from vsb.results.ladder import as_csv, study_ladder
from vsb.stages.stage import stamp
from vsb.study.specs import BodyLadderSpec, LadderSpec
from vsb.tools.files import write_text
from vsb.tools.stamps import record


def run(spec: LadderSpec | BodyLadderSpec, database: str, out: str, rungs: str, manifest: str) -> None:
    """Write the ladder of a study for people, and all its digits, with notes, for the stages after it."""
    found = study_ladder(spec, database)
    write_text(out, as_csv(found))
    write_text(rungs, json.dumps([rung._asdict() for rung in found], indent=1, allow_nan=False) + "\n")
    record(manifest, stamp(spec, database)["spec_id"], [out, rungs])
