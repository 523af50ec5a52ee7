"""The start of the command `rcx`: its streams, its signals, and unexpected errors."""

from __future__ import annotations

import gc
import sys  # import little here, because Ctrl-C during an import shows a traceback

__all__ = ["INTERRUPTED", "main"]

#: The exit code that a shell reports after Ctrl-C.
INTERRUPTED = 130
_OWN_ERROR = 3
#: The exit code that a shell reports after SIGPIPE, when the reader of the output has ended.
_UNREAD = 141


def main() -> int:
    """Load the command line and run it.

    Returns:
        The exit code: 0, 1 or 2; 3 after an error of our own, 130 after Ctrl-C, 143 after SIGTERM,
        141 if the reader of the output has closed the pipe.
    """
    came: list[int] = []  # the received signals; each of them ends the command like Ctrl-C
    try:
        from structured_text.output.system import end_as_by_ctrl_c

        came = end_as_by_ctrl_c()
        code = _run()
    except KeyboardInterrupt:
        code = INTERRUPTED
    import signal

    if code == INTERRUPTED:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # a second Ctrl-C has no effect
        if came:
            return 128 + came[0]
        print("rcx: interrupted", file=sys.stderr)
    elif signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        # The command has finished, so Ctrl-C must no longer show a traceback.
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return code


def _run() -> int:
    from structured_text.errors import OutputError, UnreadError
    from structured_text.output import streams

    streams.prepare()
    try:
        # All imported objects stay. A garbage collection would only cost a tenth of the start time.
        gc.disable()
        try:
            from structured_text.output.console import spare_no_character

            spare_no_character()
            # this import takes most of the start time
            from rcx_harness.cli.app import main as command
        finally:
            gc.enable()
        code = command()
        sys.stdout.flush()
    except UnreadError:
        streams.discard_output()
        return _UNREAD
    except OutputError as error:  # for example, the disk is full
        streams.discard_output()
        print(f"rcx: standard output cannot be written: {error.strerror}", file=sys.stderr)
        return 2
    except Exception as error:
        if _was_interrupted(error):
            return INTERRUPTED
        from rcx_harness.cli.own_error import report

        report(error)
        return _OWN_ERROR
    return code


def _was_interrupted(error: BaseException | None) -> bool:
    """Return whether Ctrl-C caused an error; in some calls Python wraps KeyboardInterrupt."""
    seen = set[int]()
    while error is not None and id(error) not in seen:
        if isinstance(error, KeyboardInterrupt):
            return True
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return False
