"""How often garbage is looked for."""

import gc

from vsb.tools.garbage import NEW, collected_seldom


def test_the_youngest_objects_are_searched_a_hundred_times_less_often():
    before = gc.get_threshold()
    try:
        collected_seldom()
        assert gc.get_threshold()[0] == NEW >= 100 * 700
        assert gc.isenabled()  # a process that lasts long must not grow without bound
    finally:
        gc.set_threshold(*before)
