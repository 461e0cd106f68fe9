"""The command as a shell starts it, `vsb` or `python -m vsb`."""

import sys

from vsb.tools.garbage import seldom_collected


def start() -> int:
    """Run the command line; imports only now, for they are what a search for garbage delays."""
    with seldom_collected():
        from vsb.cli import main

        return main()


if __name__ == "__main__":
    sys.exit(start())
