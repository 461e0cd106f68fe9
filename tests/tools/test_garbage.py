"""How often garbage is looked for."""

import gc

import pytest

from vsb.tools.garbage import NEW, seldom_collected


def fails_at_its_end(frozen):
    """A command that says how garbage is looked for while it runs."""
    with seldom_collected():
        assert gc.get_threshold()[0] == NEW >= 100 * 700
        assert gc.isenabled()  # a process that lasts long must not grow without bound
        assert gc.get_freeze_count() == frozen
        raise ValueError("as it ends")


def test_the_youngest_objects_are_searched_a_hundred_times_less_often_and_the_last_never():
    before, frozen = gc.get_threshold(), gc.get_freeze_count()  # Python 3.12 begins with some
    try:
        with pytest.raises(ValueError, match="as it ends"):
            fails_at_its_end(frozen)
        assert gc.get_freeze_count() > frozen
    finally:
        gc.unfreeze()
        gc.set_threshold(*before)


def test_it_is_looked_for_seldom_also_where_a_command_ends_well():
    before, frozen = gc.get_threshold(), gc.get_freeze_count()
    try:
        with seldom_collected():
            assert gc.get_threshold()[0] == NEW
            assert gc.get_freeze_count() == frozen
        assert gc.get_freeze_count() > frozen
    finally:
        gc.unfreeze()
        gc.set_threshold(*before)
