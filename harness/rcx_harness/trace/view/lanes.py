"""The lanes of a recording with names and groups, made record by record."""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rcx_harness.spec import signals
from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.wire import DEDICATED_AT, RESERVED_AT, SIZE
from rcx_harness.trace.view.pack import Bits, Numbers, Packed, Reals, Texts
from rcx_harness.watch.wire import word
from structured_text.language.displayed import Changed, literal, typed, value_text
from structured_text.language.types import ElementaryType, Type

__all__ = ["Group", "Lane", "Lanes", "Variables", "Wire"]

_WORDS = 16
_PORTS = range(DEDICATED_AT + 2, RESERVED_AT)
#: Types that are shown as numbers. Types of 64 bits are missing, because JavaScript cannot
#: represent them.
_WHOLE = ("SINT", "USINT", "INT", "UINT", "DINT", "UDINT")
_DIGITS = {"BYTE": 2, "WORD": 4, "DWORD": 8}
_PRECISION = {"REAL": 7, "LREAL": 15}
_STRINGS = ("STRING", "WSTRING", "CHAR", "WCHAR")
#: Pins of the PLCopen rules. Lanes are the pins of a block if at least one name is in each of the
#: two sets.
_ASKS, _ANSWERS = {"Execute", "Enable"}, {"Busy", "Done", "Error", "Valid"}


@dataclass
class Lane:
    """One lane of the page: a signal, a variable or a task over time.

    Attributes:
        name: The text beside the lane.
        colour: Its kind: `input`, `output`, `command`, `status`, `task`, `variable`, `curve` or
            `rule`.
        short: Short name in the text of a change, such as `SI(01)` for `SI(01) Servo ON input`.
        idle: Number of the text that is drawn as a line without text.
        show: Format of a number, by one of the keys `digits` (number of hexadecimal digits),
            `precision` (significant digits) and `fine` (stored values are divided by this number).
        is_curve: Whether the lane is drawn as a line from value to value.
        rests: Whether a curve is constant between two changes. It then reaches the next value
            within a cycle.
        speed_of: For a lane with a speed, the lane with the position. A speed has no changes of its
            own.
    """

    name: str
    packed: Packed
    colour: str
    short: str = ""
    idle: int | None = None
    show: dict[str, int] = field(default_factory=dict)
    is_curve: bool = False
    rests: bool = False
    speed_of: Lane | None = None


@dataclass
class Group:
    """A group of lanes that belong together. If `open` is True, the lanes are visible at first."""

    title: str
    lanes: list[Lane]
    open: bool = True


class Lanes:
    """All lanes of a page, the table of their texts, and the order of their changes."""

    def __init__(self) -> None:
        self.every: list[Lane] = []
        self.texts: dict[str, int] = {}
        self.order = array("I")
        """The number of the lane of each change, from the first to the last change."""
        self._numbers: dict[int, int] = {}

    def new(self, name: str, packed: Packed, colour: str, **more: Any) -> Lane:
        """Create a lane, add it to the page, and return it."""
        lane = Lane(name, packed, colour, **more)
        self._numbers[id(lane)] = len(self.every)
        self.every.append(lane)
        return lane

    def number(self, lane: Lane) -> int:
        """Return the index of a lane in the list of all lanes."""
        return self._numbers[id(lane)]

    def text(self, text: str) -> int:
        """Return the number of a text in the table; add the text if it is new."""
        return self.texts.setdefault(text, len(self.texts))

    def note(self, lane: Lane, t_us: int, value: float, *, told: bool = True) -> None:
        """Record the value of a lane from `t_us` on.

        If `told` is True, a change is listed as an event.
        """
        if lane.packed.note(t_us, value) and told:
            self.order.append(self.number(lane))

    def add(self, lane: Lane, t_us: int, value: float) -> None:
        """Record a change of a lane, even if the value stays the same."""
        lane.packed.add(t_us, value)
        self.order.append(self.number(lane))


class Wire:
    """The areas of one controller, as the PLC or the controller sees them.

    Args:
        plain: Whether the areas are those of the main side. Only changes of the main side are
            events.
        reads_outputs_first: Whether this is the PLC's side. A scan reads the controller's outputs
            and then writes the controller's inputs. A controller cycle has the opposite order.
    """

    def __init__(
        self, lanes: Lanes, who: str, *, plain: bool = True, reads_outputs_first: bool = False
    ) -> None:
        self._lanes, self._who, self._plain = lanes, who, plain
        self._reads_outputs_first = reads_outputs_first
        table = signals()
        self._connection = lanes.new("Connection", Bits(), "status", short="Connection")
        self._bits = {
            "si": [
                (one.byte, one.bit, self._bit(one.signal, one.title, "input"))
                for one in table.input
            ],
            "so": [
                (one.byte, one.bit, self._bit(one.signal, one.title, "output"))
                for one in table.output
            ],
        }
        self._reset, self._ready = lanes.text("status reset"), lanes.text("ready")
        self._command = lanes.new(
            "Remote command", Texts(), "command", short="PLC:", idle=self._reset
        )
        self._status = lanes.new(
            "Remote status", Texts(), "status", short="Controller:", idle=self._ready
        )
        self._ports: dict[str, Lane] = {}
        self._request = 0
        self._si = self._so = b""
        self._connected: bool | None = None

    def _bit(self, signal: str, title: str, colour: str) -> Lane:
        return self._lanes.new(f"{signal} {title}", Bits(), colour, short=signal)

    def take(self, t_us: int, si: bytes, so: bytes) -> None:
        """Record the areas from `t_us` on. An empty area was not sent."""
        connected = bool(si and so)
        if connected != self._connected:
            self._connected = connected
            self._note(self._connection, t_us, connected)
        # The first record has no changes, and the text of its status depends on the command.
        if self._reads_outputs_first and self._si:
            self._take_outputs(t_us, so)
            self._take_inputs(t_us, si)
        else:
            self._take_inputs(t_us, si)
            self._take_outputs(t_us, so)

    def _take_inputs(self, t_us: int, si: bytes) -> None:
        """Record the controller's inputs, which the PLC writes."""
        if si and si != self._si:
            if si[:2] != self._si[:2]:
                self._take_code(t_us, si)
            self._take_area(t_us, "si", self._si, si)
            self._si = si

    def _take_outputs(self, t_us: int, so: bytes) -> None:
        """Record the controller's outputs, which the PLC reads."""
        if so and so != self._so:
            if so[:2] != self._so[:2]:
                self._take_status(t_us, so)
            self._take_area(t_us, "so", self._so, so)
            self._so = so

    def _note(self, lane: Lane, t_us: int, value: int) -> None:
        self._lanes.note(lane, t_us, value, told=self._plain)

    def _take_code(self, t_us: int, si: bytes) -> None:
        code = word(si, 0)
        text = self._reset
        if code:
            self._request = code
            text = self._lanes.text(request_text([word(si, 2 * k) for k in range(_WORDS)]))
        self._note(self._command, t_us, text)

    def _take_status(self, t_us: int, so: bytes) -> None:
        text = self._ready
        if word(so, 0):
            words = [word(so, 2 * k) for k in range(_WORDS)]
            text = self._lanes.text(response_text(self._request, words))
        self._note(self._status, t_us, text)

    def _take_area(self, t_us: int, kind: str, before: bytes, area: bytes) -> None:
        """Record the changed bits and ports of an area."""
        end = DEDICATED_AT + 2
        if before[DEDICATED_AT:end] != area[DEDICATED_AT:end]:
            for byte, bit, lane in self._bits[kind]:
                self._note(lane, t_us, area[byte] >> bit & 1)
        if before[end:] != area[end:]:
            for name, digits, value in _general(kind, area):
                lane = self._ports.get(name) or self._port(name, digits, kind)
                self._note(lane, t_us, value)

    def _port(self, name: str, digits: int, kind: str) -> Lane:
        colour = "input" if kind == "si" else "output"
        show = {"digits": digits}
        lane = self._lanes.new(name, Numbers(), colour, short=name, show=show)
        self._ports[name] = lane
        return lane

    def groups(self) -> Iterator[Group]:
        """Yield the groups of lanes, from top to bottom."""
        inputs, outputs = ([lane for *_, lane in self._bits[kind]] for kind in ("si", "so"))
        ports = [lane for _, lane in sorted(self._ports.items()) if _tells(lane)]
        wire = [self._connection, self._command, self._status]
        if not self._plain:
            yield Group(f"{self._who}As the controller sees it", wire + inputs + outputs, False)
            return
        yield Group(f"{self._who}Remote commands", wire)
        yield Group(f"{self._who}Dedicated inputs", inputs)
        yield Group(f"{self._who}Dedicated outputs", outputs)
        if ports:
            yield Group(f"{self._who}General-purpose ports and words", ports)


def _tells(lane: Lane) -> bool:
    return lane.packed.count > 0 or bool(lane.packed.first)


def _general(kind: str, area: bytes) -> Iterator[tuple[str, int, int]]:
    """Yield name, digits and value of general-purpose bytes and of words beyond 48 bytes."""
    letter = kind[1].upper()
    for at in _PORTS:
        yield f"S{letter}{at - DEDICATED_AT:o}()", 2, area[at]
    for at in range(SIZE, len(area), 2):
        yield f"S{letter}W({at // 2})", 4, word(area, at)


class Variables:
    """The lanes of the watched variables. Structures and arrays have a lane for each element."""

    def __init__(self, lanes: Lanes, watched: Mapping[str, Any]) -> None:
        self._lanes = lanes
        self._changed = Changed({path: typed(kind) for path, kind in watched.items()})
        self._made: dict[str, Lane] = {}

    def take(self, t_us: int, values: Mapping[str, Any]) -> None:
        """Record the values of all watched variables after a scan."""
        for part, value in self._changed.take(values):
            lane = self._made.get(part.path)
            if lane is None:
                lane = self._made[part.path] = self._new(part.path, part.type)
            self._lanes.note(lane, t_us, self._number(lane, part.type, value))

    def _new(self, path: str, kind: Type) -> Lane:
        name = kind.name if isinstance(kind, ElementaryType) else ""
        packed: Packed = Texts()
        show: dict[str, int] = {}
        if name == "BOOL":
            packed = Bits()
        elif name in _WHOLE:
            packed = Numbers()
        elif name in _DIGITS:
            packed, show = Numbers(), {"digits": _DIGITS[name]}
        elif name in _PRECISION:
            packed, show = Reals(), {"precision": _PRECISION[name]}
        return self._lanes.new(path, packed, "variable", short=path, show=show)

    def _number(self, lane: Lane, kind: Type, value: Any) -> float:
        """Convert the value of a variable to the number that its lane stores."""
        if not isinstance(lane.packed, Texts):
            return float(value) if isinstance(lane.packed, Reals) else int(value)
        written = literal(value)
        name = kind.name if isinstance(kind, ElementaryType) else ""
        plain = isinstance(written, str) and name not in _STRINGS
        return self._lanes.text(written if plain else value_text(kind, value))

    def table(self, places: Mapping[int, int]) -> dict[str, int]:
        """Return the number of each variable's lane in the page by its path in upper case."""
        return {path.upper(): places[id(lane)] for path, lane in self._made.items()}

    def groups(self) -> Iterator[Group]:
        """Yield the groups: program variables, pins of each block, members of each structure."""
        found: dict[str, list[Lane]] = {}
        for path, lane in self._made.items():
            found.setdefault(path.rpartition(".")[0], []).append(lane)
        pins = {parent for parent, lanes in found.items() if _is_block(lanes)}
        least = min((parent.count(".") for parent in found), default=0)
        for parent in sorted(found, key=lambda one: (one.count(".") > least, one not in pins)):
            title = f"Block {parent}" if parent in pins else f"Variables of {parent}"
            is_first = parent.count(".") == least or parent in pins
            yield Group(title if parent else "Variables", found[parent], is_first)


def _is_block(lanes: list[Lane]) -> bool:
    """Return whether these lanes are the pins of a block."""
    names = {lane.name.rpartition(".")[2] for lane in lanes}
    return bool(names & _ASKS and names & _ANSWERS)
