"""The command line as `python -m vsb`."""

import sys

from vsb.cli import main

if __name__ == "__main__":
    sys.exit(main())
