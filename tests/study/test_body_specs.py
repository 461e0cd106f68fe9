"""What the stages of a study of a body compute from."""

from vsb.study.body import BodyDesign
from vsb.study.body_specs import BodyResponseSpec
from vsb.study.sections import Water
from vsb.study.take_off import Pto


def test_the_reference_is_the_first_rigid_design_by_name():
    designs = {"b": BodyDesign(dofs="rigid"), "c": BodyDesign(), "a": BodyDesign(dofs="rigid")}
    spec = BodyResponseSpec(designs=designs, water=Water(), pto=Pto(), directions=(0.0,), omega=())
    assert spec.reference_design == "a"
    assert spec.model_copy(update={"designs": {"c": designs["c"]}}).reference_design is None
