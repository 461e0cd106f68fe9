"""The command line, as `vsb` and as `python -m vsb`."""

import sys

from vsb.errors import INTERRUPTED


def main() -> int:
    """Run one command; Ctrl-C ends it in one line while its modules are loading, too."""
    try:
        from vsb.cli import main as command

        return command()
    except KeyboardInterrupt:
        print(INTERRUPTED, file=sys.stderr)
        return 130


if __name__ == "__main__":
    sys.exit(main())
