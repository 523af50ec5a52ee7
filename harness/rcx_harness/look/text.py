"""Identity and areas of a controller in words, as `rcx scan` prints them."""

from __future__ import annotations

import struct
from collections.abc import Iterator

from rcx_harness import spec
from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.wire import DEDICATED_AT, READY, RESERVED_AT, SIZE
from structured_text.output.console import escaped
from structured_text.output.units import format_word

__all__ = [
    "area_lines",
    "byte_change_lines",
    "byte_lines",
    "change_lines",
    "identity_lines",
    "telegram_lines",
]

_WORDS = struct.Struct("<16H")
_FREE_BITS = range(DEDICATED_AT + 2, RESERVED_AT)
_IDENTITY = struct.Struct("<HHHBBHI")
_BYTES_A_LINE = 16
# Identity status word, bits 4 to 7: extended device status.
_DEVICE_STATES = {
    2: "an I/O connection has timed out",
    3: "no I/O connection",
    6: "an I/O connection is in run",
    7: "I/O connections are idle",
}


def identity_lines(attributes: bytes) -> Iterator[str]:
    """Return the lines about the identity of the device.

    `attributes` is the reply to Get_Attributes_All.
    """
    if len(attributes) <= _IDENTITY.size:
        yield f"identity: {attributes.hex(' ')}"
        return
    vendor, kind, product, major, minor, status, serial = _IDENTITY.unpack_from(attributes)
    name = attributes[_IDENTITY.size + 1 :][: attributes[_IDENTITY.size]]
    yield (
        f"{escaped(name.decode('latin-1')) or '(no name)'}: vendor {vendor}, device type {kind}, "
        f"product code {product}, revision {major}.{minor}, serial number 16#{serial:08X}"
    )
    owned = "owned by a master" if status & 1 else "owned by no master"
    state = _DEVICE_STATES.get(status >> 4 & 0xF)
    yield f"status {format_word(status)}: {owned}{f', {state}' if state else ''}"


def area_lines(area: bytes, letter: str) -> Iterator[str]:
    """Yield the lines about an area: all dedicated bits, and all other values except zeros.

    `letter` is `O` for the robot's outputs (assembly 100), `I` for its inputs (assembly 150).
    """
    for signal in _dedicated(letter):
        yield f"  {signal.signal:<6} {_level(area, signal):<3}  {signal.title}"
    others = [
        f"{name} = {value}"
        for name, value in _others(area, letter)
        if value not in ("0", format_word(0))
    ]
    yield f"  not 0: {', '.join(others)}" if others else "  all others 0"


def byte_lines(area: bytes) -> Iterator[str]:
    """Yield an assembly in hexadecimal: 16 bytes per line, with the number of the first byte."""
    for at in range(0, len(area), _BYTES_A_LINE):
        yield f"  {at:>4}  {area[at : at + _BYTES_A_LINE].hex(' ')}"


def byte_change_lines(before: bytes, after: bytes) -> Iterator[str]:
    """Yield a line for each byte in which two assemblies differ."""
    for at, (old, new) in enumerate(zip(before, after, strict=True)):
        if old != new:
            yield f"byte {at} = 0x{new:02X}"


def telegram_lines(to_master: bytes, to_robot: bytes | None) -> Iterator[str]:
    """Yield the lines about the last telegram in plain language."""
    answer = _WORDS.unpack_from(to_master)
    request = _WORDS.unpack_from(to_robot) if to_robot is not None else None
    if request is None:
        yield f"  remote status {format_word(answer[0])}: {response_text(0, answer)}"
    elif request[0]:
        yield f"  {request_text(request)}"
        yield f"  {response_text(request[0], answer) if answer[0] else 'not taken yet'}"
    elif answer[0] != READY:
        yield f"  no command; remote status {format_word(answer[0])}: {response_text(0, answer)}"
    else:
        yield "  no command, ready for a command"


def change_lines(before: bytes, after: bytes, letter: str) -> Iterator[str]:
    """Yield a line for each change between two consecutive areas of the same length."""
    for signal in _dedicated(letter):
        if _level(before, signal) != _level(after, signal):
            yield f"{signal.signal} {_level(after, signal)}  {signal.title}"
    old = dict(_others(before, letter))
    for name, value in _others(after, letter):
        if old[name] != value:
            yield f"{name} = {value}"


def _dedicated(letter: str) -> tuple[spec.Signal, ...]:
    return spec.signals().output if letter == "O" else spec.signals().input


def _level(area: bytes, signal: spec.Signal) -> str:
    return "ON" if area[signal.byte] >> signal.bit & 1 else "off"


def _others(area: bytes, letter: str) -> Iterator[tuple[str, str]]:
    """Yield name and value of all words and general-purpose bits, with the manual's names."""
    words = [*range(0, DEDICATED_AT, 2), *range(SIZE, len(area), 2)]
    for at in words:
        yield f"S{letter}W({at // 2})", format_word(area[at] | area[at + 1] << 8)
    for at in _FREE_BITS:
        for bit in range(8):
            yield f"S{letter}({at - DEDICATED_AT:o}{bit})", str(area[at] >> bit & 1)
