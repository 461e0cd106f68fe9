"""One run at a time in a results folder."""

import os

import pytest

from vsb.errors import VsbError
from vsb.stages.locks import exclusive_lock


def test_second_run_in_a_folder_is_refused_until_the_first_ends(tmp_path):
    root = tmp_path / "results"
    with exclusive_lock(root) as handles:
        assert len(handles) == 1
        with pytest.raises(
            VsbError,
            match=rf"results: another run is at work in this folder \(process {os.getpid()} on .+\); wait for it to end$",
        ):
            exclusive_lock(root).__enter__()
    with exclusive_lock(root):
        pass
