"""The command as a shell starts it."""

import subprocess
import sys

from vsb import __version__


def test_the_package_is_a_command():
    told = subprocess.run([sys.executable, "-m", "vsb", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == f"vsb {__version__}"


def test_garbage_is_looked_for_seldom_before_anything_is_imported():
    code = (
        "import gc, sys; from vsb.__main__ import start; assert 'vsb.cli' not in sys.modules; sys.argv = ['vsb', 'x']\n"
        "try: start()\n"
        "except SystemExit as stop: print(stop.code, gc.get_threshold()[0], gc.get_freeze_count() > 10000)"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert told.stdout.split() == ["2", "100000", "True"]  # nor looks through them at its end
    assert "invalid choice" in told.stderr
