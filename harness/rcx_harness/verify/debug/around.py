"""The areas and telegrams of each controller, which the debugger shows next to the program."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness import spec
from rcx_harness.cell.image import Image, store
from rcx_harness.spec.wire import DEDICATED_AT, STATUS_NAMES
from rcx_harness.verify.debug.telegrams import Telegram, Telegrams
from structured_text.debug.machine import Scope
from structured_text.debug.values import Item, Text
from structured_text.engines.base import Program
from structured_text.output.units import format_us, format_word

__all__ = ["live_input", "scopes"]


def scopes(
    program: Program, images: Sequence[Image], telegrams: Sequence[Telegrams]
) -> list[Scope]:
    """Return the debugger's scopes of a cell: areas and telegrams of each controller."""
    return [
        ("Areas", lambda: _areas(program, images)),
        ("Telegrams", lambda: _telegrams(telegrams)),
    ]


def live_input(image: Image, program: Program, size: int) -> bytes:
    """Return the area from the controller as the process image contains it now."""
    area = bytearray(size)
    for slot in image.slots:
        store(area, slot, program.read(slot.path))
    return bytes(area)


def _areas(program: Program, images: Sequence[Image]) -> list[Item]:
    """Return the current areas of each controller in the process image."""
    found: list[Item] = []
    several = len(images) > 1
    for number, image in enumerate(images, 1):
        of = f" {number}" if several else ""
        si = image.get()
        so = live_input(image, program, len(si))
        found.append(_area(f"From robot{of}", so, spec.signals().output, "status"))
        found.append(_area(f"To robot{of}", si, spec.signals().input, "command"))
    return found


def _telegrams(every: Sequence[Telegrams]) -> list[Item]:
    """Return the last telegrams of each controller, the newest first."""
    found: list[Item] = []
    several = len(every) > 1
    for number, of in enumerate(every, 1):
        prefix = f"robot {number}, " if several else ""
        found += [_telegram(prefix, one) for one in of.last]
    return found or [Text("none", "no remote command has been sent yet")]


def _area(name: str, area: bytes, signals: Sequence[spec.Signal], word: str) -> Text:
    first = int.from_bytes(area[:2], "little")
    if word == "status":
        shown = STATUS_NAMES.get(first, "unknown status")
    else:
        shown = spec.command_name(first) if first else "no command"
    on = [one.short for one in signals if area[one.byte] >> one.bit & 1]
    text = f"{format_word(first)} {shown}; {', '.join(on) or 'no dedicated bit'}"

    def below() -> list[Item]:
        items: list[Item] = [Text(word, f"{format_word(first)} {shown}", "WORD")]
        for one in signals:
            value = "TRUE" if area[one.byte] >> one.bit & 1 else "FALSE"
            items.append(Text(f"{one.short} {one.title}", value, "BOOL"))
        items.append(Text("data words", "", "", lambda: _words(area, 2, DEDICATED_AT)))
        items.append(Text("bytes", "", "", lambda: _bytes(area)))
        return items

    return Text(name, text, "", below)


def _words(area: bytes, first: int, end: int) -> list[Item]:
    words = range(first, end, 2)
    return [
        Text(f"+{k}", format_word(int.from_bytes(area[k : k + 2], "little")), "WORD") for k in words
    ]


def _bytes(area: bytes) -> list[Item]:
    return [Text(f"+{k}", f"16#{one:02X}", "BYTE") for k, one in enumerate(area)]


def _telegram(prefix: str, one: Telegram) -> Text:
    end = f", {format_us(one.ended_us - one.t_us)}" if one.ended_us >= 0 else ""

    def below() -> list[Item]:
        return [
            Text("request", one.request_text, "", lambda: _shown(one.request)),
            Text("answer", one.answer_text, "", lambda: _shown(one.answer)),
            Text("sent at", format_us(one.t_us)),
            Text("ended at", format_us(one.ended_us) if one.ended_us >= 0 else "not yet"),
        ]

    return Text(
        f"{prefix}{format_us(one.t_us)}", f"{one.request_text}: {one.answer_text}{end}", "", below
    )


def _shown(words: Sequence[int]) -> list[Item]:
    return [Text(f"word {k}", format_word(one), "WORD") for k, one in enumerate(words)]
