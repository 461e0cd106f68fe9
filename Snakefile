# Flexible against rigid wave-energy buoys: the whole chain, one `vsb` command per rule.
#   snakemake --configfile config/other.yaml      another study; without it, the seed study
import vsb.config
from vsb.config import canonical, content_id
from vsb.specs import StudyPlan, figure_names

if "device" not in config:

    configfile: "config/seed.yaml"


STUDY = vsb.config.parse(
    {key: value for key, value in config.items() if key != "root"}, source="study file"
)
PLAN = StudyPlan(STUDY, root=config.get("root", "results"))
ROOT = PLAN.root
BLOCKS = {
    content_id(block): block for block in PLAN.sweep_blocks + PLAN.tabulated_blocks
}
MESHES = {content_id(block["mesh"]): block["mesh"] for block in BLOCKS.values()}
WAVES = {wave.label: wave for wave in STUDY.waves}


wildcard_constraints:
    id="[0-9a-f]{16}",
    design="[A-Za-z0-9_]+",


rule all:
    input:
        PLAN.products,


include: "workflow/rules/mesh.smk"
include: "workflow/rules/hydro.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/compare.smk"
include: "workflow/rules/figures.smk"
