"""A file with a recording, of whatever kind, as a page (`rcx view`)."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Collection
from dataclasses import dataclass
from pathlib import Path

from rcx_harness.errors import InputError
from rcx_harness.look.judge.judge import JudgeOptions, is_judged, judge
from rcx_harness.trace import CutOffError, read_trace
from rcx_harness.trace.view import View

__all__ = ["Seen", "view_file"]


@dataclass(frozen=True)
class Seen:
    """What came of a recording.

    Attributes:
        page: The page, as HTML.
        broken: How many rules were broken.
        cut: Why it ends too early; None where it does not. What comes before is in the page.
    """

    page: str
    broken: int
    cut: InputError | None


def view_file(
    file: Path,
    hosts: Collection[bytes] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> Seen:
    """Make the page of a recording: a trace, or a capture (pcapng, pcap).

    What nobody has judged yet, a capture or a trace of `rcx serve` or `rcx scan`, is judged first,
    so that the broken rules of both sides are in the page.

    Args:
        file: The recording.
        hosts: Of a capture: addresses of the controllers, four bytes each.
        progress: Is called with the share of the file that has been read.

    Raises:
        InputError: it cannot be read, or has nothing of a controller in it.
    """
    if is_judged(file):
        return _view(file, file, progress)
    with tempfile.TemporaryDirectory(prefix="rcx-") as folder:
        followed = Path(folder) / "trace.jsonl"
        options = JudgeOptions(file=file, hosts=hosts, trace=followed)
        cut: InputError | None = None
        try:
            result = judge(options, lambda line: None, progress)
        except CutOffError as error:
            cut = error
        else:
            if result.capture is not None and result.capture.damage:
                text = f"is cut off after packet {result.capture.packets}"
                cut = InputError(text, file=file, hint=result.capture.damage)
        if not followed.exists():
            raise cut or InputError("there is no area of a controller in it", file=file)
        return _view(followed, file, lambda share: None, cut)


def _view(
    trace: Path, file: Path, progress: Callable[[float], None], cut: InputError | None = None
) -> Seen:
    header, records = read_trace(trace, progress)
    try:
        view = View(header)
        for record in records:
            view.take(record)
    except CutOffError as error:
        cut = error
    except InputError as error:
        raise InputError(error.message, file=file, line=error.line, hint=error.hint) from None
    if view.is_empty:
        raise cut or InputError("there is no scan and no cycle in it", file=file)
    return Seen(view.page(file.name), view.broken, cut)
