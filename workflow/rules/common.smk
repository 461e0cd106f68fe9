# The study, campaign or design problem, and its rules by name.
from snakemake.exceptions import WorkflowError
from vsb.pipeline.jobs import rules, shown
from vsb.pipeline.plans import planned

if not {"campaign", "design", "body", "device"} & set(config):

    configfile: "config/paper.yaml"


try:
    PLAN = planned(config, workflow.configfiles[-1])
except ModuleNotFoundError as missing:
    raise WorkflowError(
        f"{missing.name} is not installed: the rules follow from the study, so vsb must be "
        "installed in the environment of Snakemake itself: pip install ."
    ) from None
RULES = {one.name: one for one in rules(PLAN)}


def batches(stem):
    """Return what does a stage whose tasks share jobs, one or several with numbers."""
    return [one for one in RULES.values() if one.stem == stem]


def made(one):
    """Return its files with their place in Snakemake's report; what other studies share, or took long, stays there."""
    described = {path: shown(path, PLAN) for path in one.makes}
    files = [report(path, **how) if how else path for path, how in described.items()]
    return [update(file) if one.keeps(file) else file for file in files]
