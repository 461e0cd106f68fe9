"""The files a user writes: a study of a buoy or a body, a campaign, a design problem; and what stages read of them.

Sections that the engine computes with are with it (a sea in `engine/waves/kinds`, a buoy in `engine/shell/device`, a
take-off in `engine/motion/take_off`); the others are here. `vsb.keys.meanings` explains every key.
"""

from vsb.study.body import BodyStudy as BodyStudy  # so that `Study` knows both kinds of it
