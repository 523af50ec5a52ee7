"""Read the facts of a network capture, as `rcx judge` follows it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from rcx_harness.look.judge.judge import JudgeOptions, judge
from rcx_harness.look.why.facts import Facts
from rcx_harness.look.why.recorded import facts_of_trace
from structured_text.errors import InputError

__all__ = ["facts_of_capture"]


def facts_of_capture(
    file: Path, until_us: int | None, progress: Callable[[float], None] = lambda share: None
) -> Facts:
    """Read the facts of a capture up to a time; time 0 is the first packet.

    Raises:
        InputError: the file is not a capture, is damaged, or ends before that time.
    """
    with tempfile.TemporaryDirectory() as folder:
        trace = Path(folder) / "capture.jsonl"
        result = judge(JudgeOptions(file=file, trace=trace), lambda line: None, progress)
        if result.capture is not None and (trouble := result.capture.trouble()):
            raise trouble
        if until_us is not None and until_us > result.last_us:
            text = f"ends at {result.last_us / 1e6:.6g} s, before {until_us / 1e6:.6g} s"
            raise InputError(text, file=file, hint="use an earlier time")
        facts = facts_of_trace(trace, None if until_us is None else min(until_us, result.last_us))
    facts.last_us = result.last_us  # the trace ends with the last change
    return facts
