"""Snakemake as a run starts it, `python -m vsb.tools.launcher OPTIONS`: it ends when its work does.

A timer by which Snakemake looks for more jobs a second later goes on when there are none, and Python waits for it.
"""

import logging
import os
import sys

from vsb.tools.garbage import seldom_collected


def launch() -> None:
    """Run Snakemake with the options of the command line, and end with its exit code."""
    try:
        with seldom_collected():
            from snakemake.cli import main

            main()
    except SystemExit as stop:
        logging.shutdown()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(stop.code if isinstance(stop.code, int) else bool(stop.code))  # words are a failure, as to Python


if __name__ == "__main__":
    launch()
