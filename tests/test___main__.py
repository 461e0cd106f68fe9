"""The command as a shell starts it."""

import subprocess
import sys

from vsb import __version__


def test_the_package_is_a_command():
    told = subprocess.run([sys.executable, "-m", "vsb", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == f"vsb {__version__}"
