"""Rule campaign: all members of a campaign together, as netCDF and as a table."""

from pathlib import Path

from vsb.results.campaign import as_csv, gathered, with_verification
from vsb.study.specs import CampaignSpec
from vsb.study.study import canonical, content_id
from vsb.tools.files import load, save, write_text
from vsb.tools.stamps import record


def run(spec: CampaignSpec, batches: str, verifications: str, out: str, table: str, manifest: str) -> None:
    """Write the results of a campaign from its batches and from what runs in time say."""
    found = gathered(spec, [load(Path(batches) / f"{batch}.nc", expected=batch) for batch in spec.batches])
    runs = [load(Path(verifications) / f"{one}.nc", expected=one) for one in spec.verifications]
    found = with_verification(spec, found, runs)
    identity = content_id(spec)
    save(found.assign_attrs(spec=canonical(spec), spec_id=identity), out)
    write_text(table, as_csv(spec, found))
    record(manifest, identity, [table])
