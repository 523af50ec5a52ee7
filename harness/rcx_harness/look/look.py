"""The observation of a controller over a cyclic connection like that of a PLC (`rcx scan`)."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness import spec
from rcx_harness.enip.codec.cip import ClassId, Service, encode_path
from rcx_harness.enip.cyclic.connections import ConnectionKind
from rcx_harness.enip.errors import CipError, ProcessDiedError
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.opening import refusal_hint
from rcx_harness.enip.originator.scanner import Assemblies, Received, Scanner, no_packet
from rcx_harness.look.text import (
    area_lines,
    byte_change_lines,
    byte_lines,
    change_lines,
    identity_lines,
    telegram_lines,
)
from rcx_harness.robot.ports import port
from rcx_harness.spec.wire import AREA_SIZES
from rcx_harness.trace import Scan, Trace
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["ScanOptions", "output_image", "scan"]

_IDENTITY = encode_path(ClassId.IDENTITY, 1)
_LOOK_S = 0.01
_WRITE = "write SI00=1, SI(20)=1 or SIW(2)=5"
_WRITE_BYTES = "write 3=0x12, by the number of the byte"
_WORDS_HINT = (
    "words are SIW(0) to SIW(15), with --size 256 also SIW(24) to SIW(127); double words SID(2), "
    "SID(4) ..."
)
_FIRST_S = 10.0
_DIGITS = 5
#: Options of `rcx scan` that the hint for a refused connection may name.
_OPTIONS = (
    *("--write", "--listen-only", "--heartbeat", "--input-instance"),
    *("--config-data", "--config-instance"),
)


@dataclass(frozen=True)
class ScanOptions:
    """The options of `rcx scan`.

    Attributes:
        assemblies: Assemblies to exchange; assemblies of 48 or 256 bytes are shown as the
            controller's areas.
        duration_us: Time to observe after the first packet, in microseconds.
        kind: The kind of connection. An exclusive owner drives the robot; the other kinds send no
            data.
        writes: What an exclusive owner sends, as `NAME=VALUE`; everything else is 0.
        address: Address of this machine to send from; empty: the system chooses.
        trace: File for a trace; None: no file.
    """

    host: str
    assemblies: Assemblies = field(default_factory=Assemblies)
    rpi_us: int = 10_000
    duration_us: int = 5_000_000
    kind: ConnectionKind = ConnectionKind.INPUT_ONLY
    writes: Sequence[str] = ()
    port: int = PORT
    address: str = ""
    trace: Path | None = None


def output_image(writes: Sequence[str], size: int) -> bytes:
    """Return assembly 150 with the given values; everything else is 0.

    A write is `SI00=1` for a dedicated input (by any of its names), `SI(20)=1` for a general
    purpose bit, or `SIW(2)=0x1234` for a word. `SIW(0)` is the code of a remote command. Areas of
    other devices are written by byte, for example `3=0x12`.
    """
    image = bytearray(size)
    for entry in writes:
        name, equals, text = entry.partition("=")
        try:
            value = int(text, 0)
        except ValueError:
            value = -1
        if not equals or value < 0:
            hint = _WRITE if size in AREA_SIZES else _WRITE_BYTES
            raise InputError(f"not a value to write: {entry!r}", hint=hint)
        at, bit, width = _place(name.strip(), size)
        longest = 1 if bit is not None else 8 * width
        if value >> longest:
            hint = f"use 0 to {(1 << longest) - 1}"
            raise InputError(f"{value} does not fit {name.strip()}", hint=hint)
        if bit is not None:
            image[at] = image[at] & ~(1 << bit) | value << bit
        else:
            image[at : at + width] = value.to_bytes(width, "little")
    return bytes(image)


def scan(options: ScanOptions, tell: Callable[[str], None]) -> bool:
    """Connect, print identity and areas, then every change.

    `tell` is called with each line of the output.

    Returns:
        True if the connection existed until the end; False if it was lost.

    Raises:
        InputError: the options are wrong, or the controller does not answer, refuses or sends
            nothing.
    """
    asked = options.assemblies
    image = output_image(options.writes, asked.output_size)
    with Scanner(
        options.host,
        asked,
        options.rpi_us,
        kind=options.kind,
        multiplier=3,
        address=options.address,
        port=options.port,
    ) as scanner:
        for line in identity_lines(scanner.client.request(Service.GET_ATTRIBUTES_ALL, _IDENTITY)):
            tell(line)
        scanner.write(image, run=True)
        _open(scanner, options)
        assert scanner.connection is not None
        interval = format_us(scanner.connection.t_to_o_api_us)
        tell(f"{options.kind.value} connection, {asked.input_size} bytes, packets every {interval}")
        first = _first(scanner)
        written = image if scanner.connection.is_owner else _written(scanner, asked)
        _tell_areas(asked, first.image, written, tell)
        seen = _Seen(options, image if scanner.connection.is_owner else b"")
        try:
            held = _watch(scanner, first.image, options.duration_us, tell, seen)
        except KeyboardInterrupt:  # after Ctrl-C the changes so far are shown
            held = True
        finally:
            seen.close()
        _tell_packets(scanner, tell)
    return held


def _open(scanner: Scanner, options: ScanOptions) -> None:
    """Open the connection; if it is refused, add the usual remedy as a hint."""
    try:
        scanner.open()
    except CipError as error:
        hint = refusal_hint(error, options.assemblies.input_size, _OPTIONS)
        raise InputError(str(error), hint=hint) from None


def _first(scanner: Scanner) -> Received:
    deadline = time.monotonic() + _FIRST_S
    while (received := scanner.read()).age_us is None:
        if failure := scanner.failure:
            raise ProcessDiedError(failure)
        if time.monotonic() > deadline:
            raise no_packet(scanner.drops(), _FIRST_S)
        time.sleep(_LOOK_S)
    return received


def _written(scanner: Scanner, asked: Assemblies) -> bytes | None:
    """Return the data of the master; None if they cannot be read or are empty."""
    try:
        return scanner.client.get_assembly(asked.output_instance) or None
    except CipError:
        return None


def _tell_areas(
    asked: Assemblies,
    to_master: bytes,
    to_robot: bytes | None,
    tell: Callable[[str], None],
) -> None:
    tell("")
    tell(f"robot to master (assembly {asked.input_instance}{_area_text(to_master, 'm')})")
    for line in _content(to_master, "O"):
        tell(line)
    tell("")
    tell(f"master to robot (assembly {asked.output_instance}{_area_text(to_robot, 'n')})")
    for line in ["  cannot be read"] if to_robot is None else _content(to_robot, "I"):
        tell(line)
    seen = [area for area in (to_master, to_robot) if area is not None]
    if any(len(area) not in AREA_SIZES for area in seen):
        return
    tell("")
    tell("remote command")
    for line in telegram_lines(to_master, to_robot):
        tell(line)


def _area_text(area: bytes | None, letter: str) -> str:
    is_area = area is None or len(area) in AREA_SIZES
    return f", the area from {letter}" if is_area else ""


def _content(area: bytes, letter: str) -> Iterator[str]:
    """Return the content as lines; an area of another size is shown as bytes."""
    return area_lines(area, letter) if len(area) in AREA_SIZES else byte_lines(area)


class _Seen:
    """The trace of `rcx scan`: the areas at each change."""

    def __init__(self, options: ScanOptions, written: bytes) -> None:
        self._written, self._looks = written, 0
        self._t_us, self._last = 0, b""
        self._trace: Trace | None = None
        if options.trace is not None:
            size = options.assemblies.input_size
            header = {"by": "rcx scan", "of": options.host, "size": size, "only": "changes"}
            self._trace = Trace(header, options.trace, keep=0)

    def take(self, t_us: int, image: bytes) -> None:
        """Write the areas to the trace if they have changed."""
        changed = image != self._last
        self._t_us, self._last = t_us, image
        if changed:
            self._note()
        self._looks += 1

    def close(self) -> None:
        """Write the last sample and close the file."""
        self._note()
        if self._trace is not None:
            self._trace.close()

    def _note(self) -> None:
        if self._trace is not None:
            self._trace.add(Scan(self._t_us, self._looks, self._last, self._written))
            self._trace.flush()


def _watch(
    scanner: Scanner,
    image: bytes,
    duration_us: int,
    tell: Callable[[str], None],
    seen: _Seen,
) -> bool:
    """Print changes until the time is over or the connection is lost.

    Return False if the connection was lost.
    """
    start = time.monotonic()
    seen.take(0, image)
    if duration_us:
        tell("")
        tell(f"changes in the next {duration_us / 1e6:g} s:")
    while (passed := time.monotonic() - start) * 1e6 < duration_us:
        received = scanner.read()
        for line in _changes(image, received.image):
            tell(f"  {passed:7.3f} s  {line}")
        image = received.image
        seen.take(round(passed * 1e6), image)
        if not received.connected:
            reason = scanner.failure or "no packets arrive any more"
            tell(f"  {passed:7.3f} s  the connection is lost: {reason}")
            return False
        time.sleep(_LOOK_S)
    return True


def _changes(before: bytes, after: bytes) -> Iterator[str]:
    if len(after) in AREA_SIZES:
        return change_lines(before, after, "O")
    return byte_change_lines(before, after)


def _tell_packets(scanner: Scanner, tell: Callable[[str], None]) -> None:
    seen = scanner.statistics()
    tell("")
    tell(
        f"{seen.received} packets received, {seen.missing} missing, {seen.sent} sent; between two "
        f"packets {format_us(seen.gap_median_us)} (median), {format_us(seen.gap_max_us)} (longest)"
    )


def _place(name: str, size: int) -> tuple[int, int | None, int]:
    """Return byte, bit and width in bytes of the input with this name."""
    if size not in AREA_SIZES:
        if not name.isdecimal() or len(name) > _DIGITS or int(name) >= size:
            raise InputError(f"{name:.40} is not one of the {size} bytes", hint=_WRITE_BYTES)
        return int(name), None, 1
    inputs = spec.signals().input
    for signal in inputs:
        if name in (signal.name, signal.short, signal.signal):
            return signal.byte, signal.bit, 1
    if name.upper().replace(" ", "") in ("SIW(0)", "SIW(1)"):
        return 2 * int(name.strip(" )")[-1]), None, 2
    try:
        place = port(name)
    except InputError:  # `port` has a message about outputs; this is an input
        place = None
    if place is None or place.output or place.bank:
        hint = _WORDS_HINT if name.upper().startswith(("SIW", "SID")) else _WRITE
        raise InputError(f"{name} is not an input of the robot that can be written", hint=hint)
    if place.at + place.size > size:
        raise InputError(f"{name} needs the extended area", hint="add --size 256")
    return place.at, place.bit, place.size
