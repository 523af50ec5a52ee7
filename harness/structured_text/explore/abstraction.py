"""The abstraction of a running program: its state as a few bytes, and back.

Two states get the same bytes only if no later scan can distinguish them:

* Time: all scans of a model have the same interval, or one of a few that the environment chooses.
  A TON compares the time since its start with PT and does nothing else with the time. So only the
  ticks since its start count, and all numbers above the longest PT of the model are equal. ET is
  read by `Tables.clock` only, which restarts its TON in every scan: there it is 0 before the first
  scan, and then the time since the last one. Waits that are counted in milliseconds are ordinary
  numbers; none exceeds its limit.
* Tickets: blocks compare tickets with the channel's Serving, by differences modulo 65536, and
  count them up. Adding a number to all tickets of a channel therefore changes nothing else. In a
  state Serving is 0, and the tickets are differences. A ticket that has been passed remains passed
  for at least 32767 further turns; all such tickets get the same code.
* Numbers of scans: only whether a number is that of the last scan counts.
* Words without a later effect are omitted, as the tables of `omitted` say.

For an unknown program (`exact`) all variables that it can name are stored unchanged, pins too. Of
`omitted` this mode uses tickets, numbers of scans, variables that are read only under a condition,
and private variables of the library's blocks. Each timer counts up to its own PT. Such a state
contains the values themselves, so it means the same in every process with the program. Other states
contain an index for each value, in the order of first occurrence.
"""

from __future__ import annotations

import marshal
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from random import Random
from struct import Struct
from typing import Any, NamedTuple

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.blocks import CLASSES
from structured_text.engines.builtin.storage import address_slot, is_scalar
from structured_text.errors import InputError
from structured_text.explore.omitted import Omitted, Tables
from structured_text.language import tree as t
from structured_text.language.printer import expression_text
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.language.values import describe
from structured_text.language.walk import calls_of

__all__ = ["NOW_US", "Abstraction", "Part"]

#: PLC time of every scan. Only the starts of the timers differ between states.
NOW_US = 1_000_000_000

_EXPIRED = 255
#: The members of a channel that count.
_TURNS = ("SERVING", "NEXTTICKET", "LOWEST")
#: The tables of an unknown library.
_NONE = Tables()
_TIMERS = tuple(name for name in CLASSES if "start" in CLASSES[name].__slots__)
_MEMORY = {"phase": ElementaryType("USINT")}
#: Pins that the monitor of the contract reads, of any block.
_JUDGED = {"EXECUTE", "ENABLE", "BUSY", "DONE", "VALID", "ACTIVE", "ERROR", "ERRORID"}
_BYTES = (ElementaryType("BYTE"), ElementaryType("USINT"))
#: The size code of a slot of variable size; and the version of `marshal` that encodes equal values
#: as equal bytes, whether or not they are one object.
_OPEN, _MARSHAL = "", 2
#: Pattern of the robot's members that the code of a slot uses.
_ROBOT = re.compile(r"\brobot\.([A-Z0-9_.]+)")
_WIDE = ("WORD", "INT", "UINT", "DINT", "TIME", "REAL", "UDINT", "DWORD")


class _Slot:
    """One stored variable: code that reads, writes and disturbs its number.

    `size` is the format of the number for `struct`; `_OPEN`: any value. `part` is the variable of
    the program that contains it.
    """

    def __init__(
        self, get: str, put: str, condition: str = "", junk: str = "", size: str = "B"
    ) -> None:
        self.size, self.part = size, ""
        self.get = f"({get}) if {condition} else 0" if condition else get
        self.put = put
        self.junk = f"if not ({condition}): {junk}" if condition else ""


class Part(NamedTuple):
    """The part of a state that covers some variables of the program; see `Abstraction.parts`."""

    robot: tuple[str, ...]
    """What else it looks at: of what the library's blocks share."""
    freeze: Callable[[], bytes]
    """Its bytes of the state after a scan at `NOW_US`."""
    thaw: Callable[[bytes, int], None]
    """Put its variables into a state, so many ticks later; the robot's have been put there."""


class Abstraction:
    """The encoder and decoder of the states of one program.

    Args:
        program: The program, in its initial state.
        tick_us: Time of one count of a timer.
        ticks: The longest time of any timer of the program, in ticks.
        free: Variables of the program itself that are written before each scan.
        exact: Store all variables, of any program; `ticks` has no effect then.
        tables: The knowledge of the library.

    Raises:
        InputError: a variable of a type that states cannot hold, or more than one robot.
    """

    def __init__(
        self,
        program: BuiltinProgram,
        tick_us: int,
        ticks: int,
        free: set[str],
        *,
        exact: bool = False,
        tables: Tables = _NONE,
    ) -> None:
        assert ticks < _EXPIRED - 1
        self._exact, self._tables = exact, tables
        self._project = program.module.project
        self.root: Any = program.holder(next(iter(program.instances())))
        self._now = NOW_US * 1000
        self._tick, self._cap = tick_us * 1000, ticks
        self._objects: dict[str, Any] = {}
        self._slots: list[_Slot] = []
        self._junk: list[str] = []
        self._fixed: list[tuple[Any, str, str]] = []
        self._wide: list[Any] = [0]
        self._index: dict[Any, int] = {0: 0}
        if exact:
            self._robot = self._only_robot(program)
            for name, kind in program.instances().items():
                assert isinstance(kind, BlockType)
                self._walk(kind, program.holder(name), Omitted(), "", "")
            self._globals(program)
        else:
            self._robot = getattr(getattr(self.root, tables.variable), tables.member)
            kind = next(iter(program.instances().values()))
            assert isinstance(kind, BlockType)
            self._walk(kind, self.root, Omitted(dropped=" ".join(free)), "", "")
        self._compile()

    def _only_robot(self, program: BuiltinProgram) -> Any:
        """Return the structure that the library's blocks share in this program, or None."""
        tables = self._tables
        found = [
            path
            for path, kind in program.walk()
            if isinstance(kind, StructType) and kind.name.upper() == tables.reference
        ]
        if len(found) > 1:
            told = f"the program has {len(found)} {tables.devices}: {', '.join(found)}"
            raise InputError(told, hint="explored are programs with one")
        return getattr(program.holder(found[0]), tables.member) if found else None

    def _globals(self, program: BuiltinProgram) -> None:
        """Plan the global and located variables."""
        project = self._project
        located = [
            symbol
            for pou in project.pous.values()
            for symbol in pou.symbols.values()
            if symbol.address is not None
        ]
        held = program._globals  # noqa: SLF001 - there is no path to all of them
        self._objects["shared"] = held
        for symbol in [*project.global_symbols.values(), *located]:
            slot = address_slot(symbol.address) if symbol.address else symbol.name.upper()
            if not symbol.constant:
                self._part(f"shared.{slot}", symbol.type, getattr(held, slot))

    @property
    def size(self) -> int:
        """Return the number of bytes of a state that is not exact."""
        return self._packed.size

    def differences(self, one: bytes, other: bytes) -> list[str]:
        """Return the code of the slots in which two states differ, for messages."""
        pairs = zip(self._values(one), self._values(other), strict=True)
        return [slot.get for slot, (a, b) in zip(self._ordered(), pairs, strict=True) if a != b]

    def _ordered(self) -> list[_Slot]:
        """Return the slots in their order in a state: those of variable size last."""
        return sorted(self._slots, key=lambda one: one.size == _OPEN)

    def _values(self, state: bytes) -> tuple[Any, ...]:
        values = self._packed.unpack_from(state)
        return (*values, *marshal.loads(state[self.size :])) if self._exact else values

    def parts(self, groups: Sequence[Sequence[str]]) -> list[Part]:
        """Split the state into parts; from now on a state is the concatenation of their bytes.

        Args:
            groups: The program's variables in each part, in upper case. The variable of the robot
                is in
                the first part, and every stored variable is in exactly one part.
        """
        places = {name: place for place, names in enumerate(groups) for name in names}
        self._slots.sort(key=lambda one: places[one.part])
        self._compile()
        found = []
        for group in groups:
            slots = [slot for slot in self._slots if slot.part in group]
            robot = {one for slot in slots for one in _ROBOT.findall(f"{slot.get} {slot.put}")}
            names = self._functions(slots)
            freeze = partial(self._freeze_part, names["freeze"])
            thaw = partial(self._thaw_part, names["thaw"])
            found.append(Part(tuple(sorted(robot)), freeze, thaw))
        return found

    def freeze(self) -> bytes:
        """Return the program's state after a scan."""
        return self._freeze()  # type: ignore[no-any-return]

    def thaw(self, state: bytes, ticks: int = 1) -> None:
        """Put the program into a state, `ticks` after the scan that led to it."""
        self._now = NOW_US * 1000
        self._thaw(state, self._now - ticks * self._tick, 0)

    def _freeze_part(self, freeze: Callable[[], bytes]) -> bytes:
        self._now = NOW_US * 1000
        return freeze()

    def _thaw_part(self, thaw: Callable[[bytes, int, int], None], state: bytes, ticks: int) -> None:
        self._now = NOW_US * 1000
        thaw(state, self._now - ticks * self._tick, 0)

    def disturb(self, state: bytes, ticks: int, random: Random) -> int:
        """Call `thaw` with arbitrary values in omitted variables; return the scan's time [us]."""
        now_us = NOW_US + random.randrange(1_000_000)
        self._now = now_us * 1000
        self._thaw(state, self._now - ticks * self._tick, random.randrange(1, 65536))
        self._spoil(random)
        return now_us

    def check_fixed(self) -> None:
        """Check, after a scan, that the variables that the tables call fixed have not changed."""
        for holder, slot, before in self._fixed:
            if repr(_held(getattr(holder, slot))) != before:
                raise AssertionError(f"{type(holder).__name__}.{slot} is not fixed")

    # --- what the generated code calls ---

    def _wide_index(self, value: Any) -> int:
        key = tuple(value) if isinstance(value, list) else value
        found = self._index.get(key)
        if found is None:
            found = self._index[key] = len(self._wide)
            self._wide.append(key)
        return found

    def _ton(self, timer: Any) -> int:
        """Return the code of a TON: 0 idle, 255 expired, else 1 plus the elapsed ticks (capped)."""
        if timer.phase == 0:
            return 0
        if timer.phase == 2:
            return _EXPIRED
        elapsed = (self._now - timer.start) // self._tick
        return 1 + min(int(elapsed), self._cap)

    def _set_ton(self, timer: Any, code: int, now: int) -> None:
        timer.phase = timer.before = timer.Q = 0
        if code == _EXPIRED:
            timer.phase, timer.before, timer.Q = 2, True, True
        elif code:
            timer.phase, timer.before = 1, True
            timer.start = now - (code - 1) * self._tick

    # --- the plan ---

    def _walk(self, kind: Type, held: Any, kept: Omitted, owner: str, channel: str) -> None:
        """Plan all variables of a structure or block."""
        tables = self._tables
        name = f"o{len(self._objects)}"
        self._objects[name] = held
        type_name = kind.name.upper() if not isinstance(kind, ElementaryType) else ""
        texts = ("", "", "") if self._exact else (kept.dropped, kept.fixed, kept.flags)
        dropped, fixed, flags = (set(text.upper().split()) for text in texts)
        if self._exact and isinstance(kind, BlockType):
            own = {one.name.upper() for one in kind.variables if one.section == "VAR"}
            dropped = set(kept.dropped.upper().split()) - _JUDGED
            dropped &= own | self._passed(owner, kind.name)
        elif self._exact and type_name == tables.shared:
            dropped = set(kept.dropped.upper().split())  # no program reads it
            dropped -= {one for one, pou in tables.unless.items() if pou in self._project.pous}
        conditional = kept.while_true
        if self._exact and not type_name.startswith(tables.core):
            conditional = {}  # unread values can be passed on
        conditions = {
            variable: condition.replace("o.", f"{name}.")
            for condition, variables in conditional.items()
            for variable in variables.upper().split()
        }
        if type_name in tables.own:
            channel = "own"
            self._objects[f"own_{name}"] = held.OWN
        jobs = self._jobs(type_name) if self._exact else {}
        for slot, part in _parts(kind):
            code = f"{name}.{slot}"
            ticket = {key.upper(): to for key, to in kept.tickets.items()}.get(slot)
            if slot in fixed and not (type_name == tables.channel and channel == "own"):
                self._fixed.append((held, slot, repr(_held(getattr(held, slot)))))
            elif slot in dropped or slot in fixed:
                self._junk += _spoiling(code, part)
            elif ticket is not None:
                self._ticket(
                    code, self._channel(ticket, type_name, owner, channel), conditions[slot]
                )
            elif type_name == tables.channel and slot in _TURNS:
                self._turn(code, name, slot, own=channel == "own")
            elif slot in kept.scans.upper().split():
                self._number(code, conditions.get(slot, ""))
            elif slot in flags:
                self._slots.append(_Slot(f"{code} != 0", f"{code} = {{v}} * 0x8001"))
            elif self._exact and type_name in _TIMERS and slot == "start":
                self._elapsed(name)
            elif isinstance(part, BlockType) and part.name == "TON" and not self._exact:
                self._timer(code, conditions.get(slot, ""), reads_et=type_name == tables.clock)
            elif isinstance(part, (BlockType, StructType)):
                assert self._exact or slot not in conditions
                inner = tables.types.get(part.name.upper(), Omitted())
                below = jobs.get(slot) or self._below(slot, channel, name)
                self._walk(part, getattr(held, slot), inner, type_name, below)
            elif self._exact and slot not in conditions:
                self._part(code, part, getattr(held, slot))
            else:
                self._plain(code, part, conditions.get(slot, ""))
            if held is self.root:
                for one in self._slots:
                    one.part = one.part or slot

    def _part(self, code: str, kind: Type, held: Any) -> None:
        """Plan a variable of any type."""
        if isinstance(kind, (ReferenceType, InterfaceType)):
            told = f"a variable of type {describe(kind)} cannot be told apart"
            raise InputError(told, hint="explored are programs without pointers and references")
        if isinstance(kind, (BlockType, StructType)):
            self._walk(kind, held, self._tables.types.get(kind.name.upper(), Omitted()), "", "")
        elif isinstance(kind, ArrayType) and not is_scalar(kind.element):
            for place, one in enumerate(held):
                self._part(f"{code}[{place}]", kind.element, one)
        else:
            self._plain(code, kind, "")

    def _passed(self, owner: str, name: str) -> set[str]:
        """Return the pins of an internal block that all of its calls in the owner block write."""
        pou = self._project.pous.get(owner)
        if pou is None or not name.upper().startswith(self._tables.core):
            return set()
        calls = [one for one in calls_of(pou.body) if one.block.name.upper() == name.upper()]
        pins = [{pin.upper() for pin, _ in one.inputs} for one in calls]
        return set.intersection(*pins) if pins else set()

    def _jobs(self, type_name: str) -> dict[str, str]:
        """Return the channels of a block's jobs, by their slots, from the calls in its body."""
        pou = self._project.pous.get(type_name)
        found = {}
        for call in calls_of(pou.body) if pou else ():
            if call.block.name.upper() == self._tables.job and isinstance(call.instance, t.Use):
                pins = {pin.upper(): value for pin, value in call.in_outs}
                channel = expression_text(pins["CHANNEL"]).upper()
                if channel.endswith((".COMMAND", ".SEQUENCE")):
                    found[call.instance.symbol.name.upper()] = channel.rpartition(".")[2].lower()
        return found

    def _below(self, slot: str, channel: str, name: str) -> str:
        """Return the private channel of a block for its Job and its Own; else an empty text."""
        if channel == "own":
            return f"own_{name}" if slot == "JOB" else "own" if slot == "OWN" else ""
        return ""

    def _channel(self, ticket: str, type_name: str, owner: str, channel: str) -> str:
        if channel.startswith("own_"):
            return channel
        if channel in ("command", "sequence"):
            return f"robot.{channel.upper()}"
        if type_name == self._tables.job:
            return f"robot.{self._tables.owners.get(owner, 'sequence').upper()}"
        return f"robot.{ticket.upper()}"

    def _ticket(self, code: str, channel: str, condition: str) -> None:
        """Plan a ticket as its distance from the channel's Serving.

        Tickets count modulo 65536, and blocks only compare differences. A difference below 32768
        is a ticket that waits, or that is served now (0). All other tickets have been passed. They
        behave alike and share the code 255; decoding chooses any passed number for them.
        """
        ahead = f"{code} - {channel}.SERVING & 65535"
        self._slots.append(
            _Slot(
                f"min({ahead}, 254) if ({ahead}) < 32768 else 255",
                f"{code} = ({channel}.SERVING + ({{v}} if {{v}} < 255 else -1 - shift % 32767))"
                " & 65535",
                condition,
                f"{code} = random.randrange(65536)",
            )
        )

    def _number(self, code: str, condition: str) -> None:
        """Plan a number of a scan: a state stores only whether it is that of the last scan."""
        if code.endswith(".SCAN"):
            self._slots.insert(0, _Slot("0", f"{code} = shift"))
            return
        self._slots.append(
            _Slot(
                f"{code} == robot.SCAN",
                f"{code} = robot.SCAN - (0 if {{v}} else 1 + shift % 65000) & 65535",
                condition,
                f"{code} = random.randrange(65536)",
            )
        )

    def _turn(self, code: str, name: str, slot: str, *, own: bool) -> None:
        """Plan a counter of a channel relative to its Serving, which is 0 in every state.

        `shift` is 0 in a normal run. `disturb` sets it to another number, which shifts all tickets
        and must change nothing.
        """
        if slot == "SERVING":
            self._slots.insert(0, _Slot("0", f"{code} = shift"))
        elif slot == "LOWEST" and own:
            self._junk.append(f"{code} = random.randrange(65536)")
        elif slot == "LOWEST" and self._exact:
            get = f"min({code} - {name}.SERVING & 65535, 255)"
            self._slots.append(_Slot(get, f"{code} = shift + {{v}} & 65535"))
        elif slot == "LOWEST":
            # At the end of a scan the library sets LOWEST to NextTicket, since no ticket has been
            # seen yet.
            self._slots.append(_Slot(f"{code} != {name}.NEXTTICKET", f"{code} = {name}.NEXTTICKET"))
        else:
            get = f"min({code} - {name}.SERVING & 65535, 255)"
            self._slots.append(_Slot(get, f"{code} = shift + {{v}} & 65535"))

    def _timer(self, code: str, condition: str, *, reads_et: bool) -> None:
        junk = f"set_ton({code}, random.choice((0, 1, 2, 255)), now)"
        self._slots.append(_Slot(f"ton({code})", f"set_ton({code}, {{v}}, now)", condition, junk))
        et = "0" if reads_et else "random.randrange(10**9)"
        self._junk += [f"{code}.ET = {et}"]

    def _elapsed(self, name: str) -> None:
        """Plan the time that a timer has been running, in ticks, at most its PT."""
        get = f"elapsed({name})"
        self._slots.append(_Slot(get, f"{name}.start = now - {{v}} * {self._tick}", size="I"))

    def _running(self, timer: Any) -> int:
        if timer.phase != 1:
            return 0
        most = -(-max(timer.PT, 0) // self._tick)
        return int(min((self._now - timer.start) // self._tick, most))

    def _plain(self, code: str, kind: Type, condition: str) -> None:
        junk = "; ".join(_spoiling(code, kind))
        get, put, wide = f"index({code})", "wide[{v}]", "B"
        if self._exact:
            get, put, wide = code, "{v}", _OPEN
        if isinstance(kind, ArrayType):
            if self._exact:
                get = f"{'bytes' if kind.element in _BYTES else 'tuple'}({code})"
            start = f"{put} or [0] * len({code})"
            slot = _Slot(get, f"{code}[:] = {start}", condition, junk, wide)
        elif isinstance(kind, ElementaryType) and kind.name == "BOOL":
            slot = _Slot(code, f"{code} = {{v}} == 1", condition, junk)
        elif isinstance(kind, EnumType) and not self._exact:
            slot = _Slot(code, f"{code} = {{v}}", condition, junk)
        else:
            slot = _Slot(get, f"{code} = {put}", condition, junk, wide)
        self._slots.append(slot)

    def _compile(self) -> None:
        names = self._functions(self._slots)
        self._packed: Struct = names["packed"]
        self._freeze: Any = names["freeze"]
        self._thaw: Any = names["thaw"]
        self._spoil: Any = names["spoil"]

    def _functions(self, slots: Sequence[_Slot]) -> dict[str, Any]:
        """Return the compiled functions that read and write these slots."""
        names = {
            **self._objects,
            "robot": self._robot,
            "elapsed": self._running,
            "ton": self._ton,
            "set_ton": self._set_ton,
            "index": self._wide_index,
            "wide": self._wide,
        }
        values = {id(slot): f"v{number}" for number, slot in enumerate(slots)}
        puts = [slot.put.format(v=values[id(slot)]) for slot in slots]
        sized = [slot for slot in slots if slot.size != _OPEN]
        others = [slot for slot in slots if slot.size == _OPEN]
        packed = Struct("<" + "".join(slot.size for slot in sized))
        names |= {"packed": packed, "pack": packed.pack, "unpack": packed.unpack_from}
        names |= {"dumps": marshal.dumps, "loads": marshal.loads}
        freeze = f"pack({_listed(slot.get for slot in sized)})"
        thaw = [f"{_listed(values[id(slot)] for slot in sized)} = unpack(state)"] * bool(sized)
        if self._exact:
            freeze += f" + dumps(({_listed(slot.get for slot in others)}), {_MARSHAL})"
            got = f"loads(state[{packed.size}:])"
            thaw += [f"{_listed(values[id(slot)] for slot in others)} = {got}"] * bool(others)
        lines = [
            "def freeze():",
            f"    return {freeze}",
            "def thaw(state, now, shift):",
            *(f"    {line}" for line in [*thaw, *puts]),
            "    pass",
            "def spoil(random, now=10**12):",
            "    getrandbits = random.getrandbits",
            *(f"    {line}" for line in self._junk),
            *(f"    {slot.junk}" for slot in slots if slot.junk),
        ]
        exec(compile("\n".join(lines), "<abstraction>", "exec"), names)
        return names


def _listed(parts: Iterable[str]) -> str:
    """Join the parts with a comma after each, so that a single part is a tuple, too."""
    return "".join(f"{part}, " for part in parts)


def _parts(kind: Type) -> Iterator[tuple[str, Type]]:
    """Yield the variables of a structure or block, by the names of their slots."""
    if isinstance(kind, StructType):
        yield from ((name.upper(), part) for name, part in kind.fields)
    elif isinstance(kind, BlockType) and kind.name in CLASSES:
        pins = {variable.name: variable.type for variable in kind.variables}
        for slot in CLASSES[kind.name].__slots__:
            if slot != "clock":
                yield slot, pins.get(slot, _MEMORY.get(slot, ElementaryType("BOOL")))
    else:
        assert isinstance(kind, BlockType)
        kept = ("VAR", "VAR_INPUT", "VAR_OUTPUT")
        for one in kind.variables:
            if one.section in kept and one.address is None:  # located variables are shared
                yield one.name.upper(), one.type


def _spoiling(code: str, kind: Type) -> list[str]:
    """Return statements that give a variable an arbitrary value of its type."""
    if isinstance(kind, StructType):
        return [
            line for name, part in kind.fields for line in _spoiling(f"{code}.{name.upper()}", part)
        ]
    if isinstance(kind, ArrayType):
        value = _arbitrary(kind.element)
        return [f"{code}[:] = [{value} for _ in {code}]"]
    return [f"{code} = {_arbitrary(kind)}"]


def _arbitrary(kind: Type) -> str:
    if isinstance(kind, EnumType):
        return f"random.randrange({len(kind.members)})"
    assert isinstance(kind, ElementaryType), kind
    if kind.name == "BOOL":
        return "random.random() < 0.5"
    if kind.name == "REAL":
        return "random.random()"
    return f"getrandbits({8 if kind.name == 'BYTE' else 15})"


def _held(value: Any) -> Any:
    """Return the value of a variable in a form that can be compared."""
    slots = getattr(value, "__slots__", None)
    if slots is None:
        return value
    return [_held(getattr(value, slot)) for slot in slots]
