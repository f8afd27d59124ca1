"""The program `symplint` of the command line."""

import signal
import sys

from . import _native

__all__ = ["main"]


def main() -> None:
    """Run the command line of this process, and exit with the status of the program."""
    # Ctrl-C ends the program, which reports how to continue. Python would only notice it afterwards.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(_native.program(["symplint", *sys.argv[1:]]))
