"""Generator of the lines in plc/lib that split or join a word of dedicated bits.

The blocks are handwritten, except the lines between two comments.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from pathlib import Path

from rcx_harness import spec
from rcx_harness.spec import Signal
from rcx_tools.library.st import word
from structured_text.errors import InputError

__all__ = ["signal_files"]

BEGIN = "  (* Each bit, generated from spec/signals.toml by `make docs`. *)\n"
END = "  (* End of the generated lines. *)\n"


def signal_files() -> dict[str, Callable[[], str]]:
    """Return the generators of the files with generated lines, by the path in the repository."""
    signals = spec.signals()
    lines = {
        "plc/lib/core/FB_RcxTakeHead.st": _apart("SO", "Shown", signals.output),
        "plc/lib/core/FB_RcxDedicatedInputs.st": _apart("SI", "Robot.Inner.Applied", signals.input),
        "plc/lib/diagnosis/FB_DedicatedBits.st": [
            *_together("SI", "Inputs", signals.input),
            *_together("SO", "Outputs", signals.output),
        ],
    }
    return {path: partial(_written, path, made) for path, made in lines.items()}


def _place(signal: Signal) -> int:
    """Return the number of the bit in the word that consists of bytes 32 (low) and 33 (high)."""
    return 8 * (signal.byte - 32) + signal.bit


def _apart(side: str, source: str, signals: Iterable[Signal]) -> list[str]:
    return [
        f"Robot.{side}.{one.name} := ({source} AND {word(1 << _place(one))}) <> {word(0)};"
        for one in signals
    ]


def _together(side: str, target: str, signals: Iterable[Signal]) -> Iterator[str]:
    before = ""
    for one in signals:
        bit = f"BOOL_TO_WORD(Robot.{side}.{one.name})"
        place = _place(one)
        yield f"{target} := {before}{f'SHL({bit}, {place})' if place else bit};"
        before = f"{target} OR "


def _written(path: str, lines: Iterable[str]) -> str:
    """Return the text of a file with new lines between the two comments.

    Raises:
        InputError: the comments are missing, repeated or not in this order.
    """
    file = Path(spec.folder().parent, path)
    text = file.read_text(encoding="utf-8")
    before, begin, rest = text.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not (begin and end) or BEGIN in after or END in after:
        raise InputError(
            "the comments around the generated lines are missing, repeated or in the wrong order",
            file=file,
            hint=f"put {BEGIN.strip()} before them and {END.strip()} behind them",
        )
    return "".join([before, begin, *(f"  {line}\n" for line in lines), end, after])
