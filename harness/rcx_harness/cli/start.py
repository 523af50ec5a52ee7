"""The start of the command `rcx`: whenever Ctrl-C comes, it ends with one line."""

from __future__ import annotations

import gc
import os
import signal
import sys

__all__ = ["INTERRUPTED", "main"]

#: Exit code after Ctrl-C, as shells give it.
INTERRUPTED = 130


def main() -> int:
    """Load the command line and run it.

    Returns:
        The exit code: 0, 1 or 2; 130 after Ctrl-C, 143 after SIGTERM.
    """
    came: list[int] = []  # signals besides Ctrl-C
    try:
        gc.disable()  # what is imported stays: looking for what may go takes a tenth of the start
        from rcx_harness.output.console import spare_no_character

        spare_no_character()
        from rcx_harness.cli.app import main as command  # most of the first second
        from rcx_harness.output.system import end_as_by_ctrl_c

        came = end_as_by_ctrl_c()
        gc.enable()
        code = command()
        sys.stdout.flush()
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second one changes nothing
        code = INTERRUPTED
    except OSError as error:  # what is printed goes nowhere: a full disk, or nobody reads it
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        from rcx_harness.output.system import nobody_reads

        if nobody_reads(error):
            return 1
        print(f"rcx: standard output cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    if code == INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("rcx: interrupted", file=sys.stderr)
        return 128 + came[0] if came else code
    return code
