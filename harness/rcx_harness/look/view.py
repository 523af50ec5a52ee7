"""A recording (trace or capture) as a page (`rcx view`)."""

from __future__ import annotations

import heapq
import tempfile
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rcx_harness.cell.sources import blame_lib, source_files
from rcx_harness.look.judge.judge import JudgeOptions, is_capture, is_judged, judge
from rcx_harness.trace import CutOffError, Record, Violation, read_trace
from rcx_harness.trace.view.page import View
from structured_text.errors import InputError

__all__ = ["Seen", "drawn_networks", "view_file"]

#: Entries in the header of a trace with records of positions and programs, which `judge` drops.
_OWN = {"positions", "programs"}


@dataclass(frozen=True)
class Seen:
    """The result of reading a recording.

    Attributes:
        broken: Number of broken rules.
        cut: The error at which the recording ends too early, or None. The page shows the part
            before the error.
    """

    page: str
    broken: int
    cut: InputError | None


def view_file(
    file: Path,
    hosts: Collection[bytes] = (),
    progress: Callable[[float], None] = lambda share: None,
    networks: Sequence[Mapping[str, Any]] = (),
) -> Seen:
    """Return the page of a recording: a trace, or a capture (pcapng, pcap).

    A capture or a trace of `rcx serve` or `rcx scan` is judged first, so that the page contains the
    broken rules of both sides. If a trace has positions or robot programs, the page shows its own
    records, with the broken rules among them.

    `hosts` are addresses of the controllers in a capture, four bytes each. `progress` is called
    with the part of the file that has been read. `networks` are those of `drawn_networks`.
    """
    if is_judged(file):
        return _view(read_trace(file, progress), file, networks=networks)
    with tempfile.TemporaryDirectory(prefix="rcx-") as folder:
        followed = Path(folder) / "trace.jsonl"
        options = JudgeOptions(file=file, hosts=hosts, trace=followed)
        cut: InputError | None = None
        try:
            result = judge(options, lambda line: None, progress)
        except CutOffError as error:
            cut = error
        else:
            if result.capture is not None:
                cut = result.capture.trouble("taken")
        if not followed.exists():
            raise cut or InputError("contains no area of a controller", file=file)
        if not is_capture(file) and _OWN & (own := read_trace(file))[0].keys():
            rules = (one for one in read_trace(followed)[1] if isinstance(one, Violation))
            moves = (one for one in own[1] if not isinstance(one, Violation))
            both = heapq.merge(moves, rules, key=lambda one: one.t_us)
            return _view((own[0], both), file, cut, networks)
        return _view(read_trace(followed), file, cut, networks)


def drawn_networks(program: Sequence[Path], lib: Path | None) -> Sequence[Mapping[str, Any]]:
    """Return the networks of a program for a page; raise InputError if it has none."""
    # Imported here, because reading a trace needs no compiler.
    from rcx_harness.trace.view.networks import DrawnProgram
    from structured_text.engines.builtin import BuiltinProgram
    from structured_text.language.load import load

    files = source_files(list(program), lib)
    try:
        built = BuiltinProgram.build(load(files.all))
    except InputError as error:
        raise blame_lib(error, lib) from None
    networks = DrawnProgram(built, files.own).groups
    if not networks:
        hint = "leave --program out; it is for ladder and function block diagrams"
        raise InputError("the program has no networks", file=program[0], hint=hint)
    return networks


def _view(
    trace: tuple[Mapping[str, Any], Iterable[Record]],
    file: Path,
    cut: InputError | None = None,
    networks: Sequence[Mapping[str, Any]] = (),
) -> Seen:
    header, records = trace
    if networks and not header.get("watch"):
        hint = "record it with rcx run --trace FILE --watch 'Main.*,Main.*.*'"
        raise InputError("has no variables that the networks can show", file=file, hint=hint)
    try:
        view = View(header, networks)
        for record in records:
            view.take(record)
    except CutOffError as error:
        cut = error
    except InputError as error:
        raise InputError(error.message, file=file, line=error.line, hint=error.hint) from None
    if view.is_empty:
        raise cut or InputError("contains no scan and no cycle", file=file)
    return Seen(view.page(file.name), view.broken, cut)
