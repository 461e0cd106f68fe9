"""The command as a shell starts it, `vsb` or `python -m vsb`."""

import sys

from vsb.cli import main as start

if __name__ == "__main__":
    sys.exit(start())
