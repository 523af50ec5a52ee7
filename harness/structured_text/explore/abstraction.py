"""The abstraction of a running program: its state is saved as bytes, and restored from bytes.

All variables that a program can name are stored unchanged, including pins. Each timer counts up to
its own PT. The tables in `omitted` name the exceptions: tickets, numbers of scans, variables that
are read only under a condition, and private variables of the library's blocks. A state contains
values and no references, so it is valid in every process with the same program. Two states get the
same bytes only if no later scan can distinguish them:

* Tickets: blocks compare tickets with the channel's Serving, by differences modulo 65536, and
  count them up. Adding a number to all tickets of a channel therefore changes nothing else. In a
  state Serving is 0, and the tickets are differences. A ticket that has been passed remains passed
  for at least 32767 further turns; all such tickets get the same code.
* Numbers of scans: a state stores only whether a number is the number of the last scan.
"""

from __future__ import annotations

import marshal
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
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

__all__ = ["NOW_US", "Abstraction", "Place", "Slot", "spoiling"]

#: PLC time of every scan. A state stores only elapsed times, so all scans can have the same time.
NOW_US = 1_000_000_000

#: The members of a channel that count its tickets.
_TURNS = ("SERVING", "NEXTTICKET", "LOWEST")
#: Empty tables, for a program without a known library.
_NONE = Tables()
_TIMERS = tuple(name for name in CLASSES if "start" in CLASSES[name].__slots__)
_MEMORY = {"phase": ElementaryType("USINT")}
#: Pins that are always stored, because the monitor of the rules for blocks reads them.
_JUDGED = {"EXECUTE", "ENABLE", "BUSY", "DONE", "VALID", "ACTIVE", "ERROR", "ERRORID"}
_BYTES = (ElementaryType("BYTE"), ElementaryType("USINT"))
#: The size code of a slot of variable size, and a version of `marshal`. In this version equal
#: values give equal bytes, whether or not they are the same object.
OPEN, _MARSHAL = "", 2


class Slot:
    """One stored variable, with the code that reads, writes and randomly changes its number.

    `size` is the format of the number for `struct`, or `OPEN` for a value of any size.
    """

    def __init__(
        self, get: str, put: str, condition: str = "", junk: str = "", size: str = "B"
    ) -> None:
        self.size = size
        self.get = f"({get}) if {condition} else 0" if condition else get
        self.put = put
        self.junk = f"if not ({condition}): {junk}" if condition else ""


class Place(NamedTuple):
    """A structure or block, with the facts that the code for its variables needs.

    `name` is the name of the structure or block in the code of its variables. `owner` is the type
    that contains it, and `channel` is the channel that it works on. `dropped` names its variables
    that a state does not store. `conditions` gives the conditions under which other variables are
    read. `jobs` gives the channels of its jobs.
    """

    name: str
    type_name: str
    held: Any
    kept: Omitted
    owner: str
    channel: str
    dropped: Collection[str]
    conditions: Mapping[str, str]
    jobs: Mapping[str, str]


class Abstraction:
    """The encoder and decoder of the states of one program.

    The program must be in its initial state. Its timers count in steps of `tick_us`.

    Raises:
        InputError: A variable has a type that states cannot hold, or there is more than one device.
    """

    #: Whether a state has slots of variable size after the numbers.
    has_open_slots = True

    def __init__(self, program: BuiltinProgram, tick_us: int, tables: Tables = _NONE) -> None:
        self.tables = tables
        self._project = program.module.project
        self.root: Any = program.holder(next(iter(program.instances())))
        self.now = NOW_US * 1000
        self.tick = tick_us * 1000
        self._objects: dict[str, Any] = {}
        self.slots: list[Slot] = []
        self.junk: list[str] = []
        self.robot = self.shared_structure(program)
        self.plan(program)
        self.compile()

    def plan(self, program: BuiltinProgram) -> None:
        """Decide how a state stores each variable of the program."""
        for name, kind in program.instances().items():
            assert isinstance(kind, BlockType)
            self.walk(kind, program.holder(name), Omitted(), "", "")
        self._globals(program)

    def shared_structure(self, program: BuiltinProgram) -> Any:
        """Return the structure that the library's blocks share in this program, or None."""
        tables = self.tables
        found = [
            path
            for path, kind in program.walk()
            if isinstance(kind, StructType) and kind.name.upper() == tables.reference
        ]
        if len(found) > 1:
            told = f"the program has {len(found)} {tables.devices}: {', '.join(found)}"
            raise InputError(told, hint="explore a program with only one")
        return getattr(program.holder(found[0]), tables.member) if found else None

    def _globals(self, program: BuiltinProgram) -> None:
        """Decide how a state stores the global and located variables."""
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

    def differences(self, one: bytes, other: bytes) -> list[str]:
        """Return the code of the slots in which two states differ, for messages."""
        pairs = zip(self.values(one), self.values(other), strict=True)
        return [slot.get for slot, (a, b) in zip(self._ordered(), pairs, strict=True) if a != b]

    def _ordered(self) -> list[Slot]:
        """Return the slots in their order in a state; slots of variable size are last."""
        return sorted(self.slots, key=lambda one: one.size == OPEN)

    def values(self, state: bytes) -> tuple[Any, ...]:
        """Return the values of the slots in a state, in their order."""
        return (*self.packed.unpack_from(state), *marshal.loads(state[self.packed.size :]))

    def freeze(self) -> bytes:
        """Return the program's state after a scan."""
        return self._freeze()  # type: ignore[no-any-return]

    def thaw(self, state: bytes, ticks: int = 1) -> None:
        """Put the program into a state as it is `ticks` after the scan that led to this state."""
        self.now = NOW_US * 1000
        self._thaw(state, self.now - ticks * self.tick, 0)

    def disturb(self, state: bytes, ticks: int, random: Random) -> int:
        """Call `thaw` with arbitrary values in omitted variables; return the scan's time [us]."""
        now_us = NOW_US + random.randrange(1_000_000)
        self.now = now_us * 1000
        self._thaw(state, self.now - ticks * self.tick, random.randrange(1, 65536))
        self._spoil(random)
        return now_us

    # --- the plan ---

    def walk(self, kind: Type, held: Any, kept: Omitted, owner: str, channel: str) -> None:
        """Decide how a state stores each variable of a structure or block."""
        name = f"o{len(self._objects)}"
        self._objects[name] = held
        type_name = kind.name.upper() if not isinstance(kind, ElementaryType) else ""
        dropped = self.dropped(kind, type_name, kept, owner)
        conditions = {
            variable: condition.replace("o.", f"{name}.")
            for condition, variables in self.conditional(type_name, kept).items()
            for variable in variables.upper().split()
        }
        if type_name in self.tables.own:
            channel = "own"
            self._objects[f"own_{name}"] = held.OWN
        jobs = self.jobs(type_name)
        place = Place(name, type_name, held, kept, owner, channel, dropped, conditions, jobs)
        for slot, part in _parts(kind):
            self.variable(place, slot, part)

    def variable(self, place: Place, slot: str, part: Type) -> None:
        """Decide how a state stores one variable of a structure or block."""
        name, type_name, held, kept, owner, channel, dropped, conditions, jobs = place
        code = f"{name}.{slot}"
        ticket = {key.upper(): to for key, to in kept.tickets.items()}.get(slot)
        if slot in dropped:
            self.junk += spoiling(code, part)
        elif ticket is not None:
            self._ticket(code, self._channel(ticket, type_name, owner, channel), conditions[slot])
        elif type_name == self.tables.channel and slot in _TURNS:
            self.turn(code, name, slot, own=channel == "own")
        elif slot in kept.scans.upper().split():
            self._number(code, conditions.get(slot, ""))
        elif type_name in _TIMERS and slot == "start":
            self._elapsed(name)
        elif isinstance(part, (BlockType, StructType)):
            inner = self.tables.types.get(part.name.upper(), Omitted())
            below = jobs.get(slot) or self._below(slot, channel, name)
            self.walk(part, getattr(held, slot), inner, type_name, below)
        elif slot not in conditions:
            self._part(code, part, getattr(held, slot))
        else:
            self.plain(code, part, conditions[slot])

    def dropped(self, kind: Type, type_name: str, kept: Omitted, owner: str) -> set[str]:
        """Return the variables of a structure or block that no program can read."""
        dropped = set(kept.dropped.upper().split())
        if isinstance(kind, BlockType):
            own = {one.name.upper() for one in kind.variables if one.section == "VAR"}
            return (dropped - _JUDGED) & (own | self._passed(owner, kind.name))
        if type_name != self.tables.shared:
            return set()
        unless = self.tables.unless.items()
        return dropped - {one for one, pou in unless if pou in self._project.pous}

    def conditional(self, type_name: str, kept: Omitted) -> Mapping[str, str]:
        """Return the condition under which a variable is read, by the name of the variable."""
        # The program can copy structures that are not internal, so even a value that is not read
        # has an effect.
        return kept.while_true if type_name.startswith(self.tables.core) else {}

    def _part(self, code: str, kind: Type, held: Any) -> None:
        """Decide how a state stores a variable of any type."""
        if isinstance(kind, (ReferenceType, InterfaceType)):
            told = f"a variable of type {describe(kind)} cannot be explored"
            raise InputError(told, hint="remove the pointers and references")
        if isinstance(kind, (BlockType, StructType)):
            self.walk(kind, held, self.tables.types.get(kind.name.upper(), Omitted()), "", "")
        elif isinstance(kind, ArrayType) and not is_scalar(kind.element):
            for place, one in enumerate(held):
                self._part(f"{code}[{place}]", kind.element, one)
        else:
            self.plain(code, kind, "")

    def _passed(self, owner: str, name: str) -> set[str]:
        """Return the pins of an internal block that the containing block writes in each call."""
        pou = self._project.pous.get(owner)
        if pou is None or not name.upper().startswith(self.tables.core):
            return set()
        calls = [one for one in calls_of(pou.body) if one.block.name.upper() == name.upper()]
        pins = [{pin.upper() for pin, _ in one.inputs} for one in calls]
        return set.intersection(*pins) if pins else set()

    def jobs(self, type_name: str) -> dict[str, str]:
        """Return the channel that a block's body passes to each job, by the slot of the job."""
        pou = self._project.pous.get(type_name)
        found = {}
        for call in calls_of(pou.body) if pou else ():
            if call.block.name.upper() == self.tables.job and isinstance(call.instance, t.Use):
                pins = {pin.upper(): value for pin, value in call.in_outs}
                channel = expression_text(pins["CHANNEL"]).upper()
                if channel.endswith((".COMMAND", ".SEQUENCE")):
                    found[call.instance.symbol.name.upper()] = channel.rpartition(".")[2].lower()
        return found

    def _below(self, slot: str, channel: str, name: str) -> str:
        """Return the private channel for the slot JOB or OWN of a block.

        The result is empty for all other slots.
        """
        if channel == "own":
            return f"own_{name}" if slot == "JOB" else "own" if slot == "OWN" else ""
        return ""

    def _channel(self, ticket: str, type_name: str, owner: str, channel: str) -> str:
        if channel.startswith("own_"):
            return channel
        if channel in ("command", "sequence"):
            return f"robot.{channel.upper()}"
        if type_name == self.tables.job:
            return f"robot.{self.tables.owners.get(owner, 'sequence').upper()}"
        return f"robot.{ticket.upper()}"

    def _ticket(self, code: str, channel: str, condition: str) -> None:
        """Let a state store a ticket as its distance from the channel's Serving.

        Tickets count modulo 65536, and blocks only compare differences. A difference below 32768
        is a ticket that waits, or that is served now (0). All other tickets have been passed. They
        behave alike and share the code 255; decoding chooses any passed number for them.
        """
        ahead = f"{code} - {channel}.SERVING & 65535"
        self.slots.append(
            Slot(
                f"min({ahead}, 254) if ({ahead}) < 32768 else 255",
                f"{code} = ({channel}.SERVING + ({{v}} if {{v}} < 255 else -1 - shift % 32767))"
                " & 65535",
                condition,
                f"{code} = random.randrange(65536)",
            )
        )

    def _number(self, code: str, condition: str) -> None:
        """Let a state store whether a variable contains the number of the last scan.

        A state does not store any other number of a scan.
        """
        if code.endswith(".SCAN"):
            self.slots.insert(0, Slot("0", f"{code} = shift"))
            return
        self.slots.append(
            Slot(
                f"{code} == robot.SCAN",
                f"{code} = robot.SCAN - (0 if {{v}} else 1 + shift % 65000) & 65535",
                condition,
                f"{code} = random.randrange(65536)",
            )
        )

    def turn(self, code: str, name: str, slot: str, *, own: bool) -> None:
        """Let a state store a counter of a channel relative to Serving, which is 0 in every state.

        `shift` is 0 in a normal run. `disturb` sets it to another number, which shifts all tickets.
        This must not change the result of a scan.
        """
        if slot == "SERVING":
            self.slots.insert(0, Slot("0", f"{code} = shift"))
        elif slot == "LOWEST" and own:
            self.junk.append(f"{code} = random.randrange(65536)")
        else:
            get = f"min({code} - {name}.SERVING & 65535, 255)"
            self.slots.append(Slot(get, f"{code} = shift + {{v}} & 65535"))

    def _elapsed(self, name: str) -> None:
        """Let a state store the running time of a timer in ticks, at most its PT."""
        get = f"elapsed({name})"
        self.slots.append(Slot(get, f"{name}.start = now - {{v}} * {self.tick}", size="I"))

    def _running(self, timer: Any) -> int:
        if timer.phase != 1:
            return 0
        most = -(-max(timer.PT, 0) // self.tick)
        return int(min((self.now - timer.start) // self.tick, most))

    def plain(self, code: str, kind: Type, condition: str) -> None:
        """Let a state store a scalar, or an array of scalars, unchanged."""
        junk = "; ".join(spoiling(code, kind))
        if isinstance(kind, ArrayType):
            get = f"{'bytes' if kind.element in _BYTES else 'tuple'}({code})"
            slot = Slot(get, f"{code}[:] = {{v}} or [0] * len({code})", condition, junk, OPEN)
        elif isinstance(kind, ElementaryType) and kind.name == "BOOL":
            slot = Slot(code, f"{code} = {{v}} == 1", condition, junk)
        else:
            slot = Slot(code, f"{code} = {{v}}", condition, junk, OPEN)
        self.slots.append(slot)

    def compile(self) -> None:
        """Compile the functions that read, write and randomly change all slots."""
        names = self.functions(self.slots)
        self.packed: Struct = names["packed"]
        self._freeze: Any = names["freeze"]
        self._thaw: Any = names["thaw"]
        self._spoil: Any = names["spoil"]

    def names(self) -> dict[str, Any]:
        """Return the objects that the code of the slots uses, by name."""
        return {**self._objects, "robot": self.robot, "elapsed": self._running}

    def functions(self, slots: Sequence[Slot]) -> dict[str, Any]:
        """Return the compiled functions that read and write some slots."""
        names = self.names()
        values = {id(slot): f"v{number}" for number, slot in enumerate(slots)}
        puts = [slot.put.format(v=values[id(slot)]) for slot in slots]
        sized = [slot for slot in slots if slot.size != OPEN]
        others = [slot for slot in slots if slot.size == OPEN]
        packed = Struct("<" + "".join(slot.size for slot in sized))
        names |= {"packed": packed, "pack": packed.pack, "unpack": packed.unpack_from}
        names |= {"dumps": marshal.dumps, "loads": marshal.loads}
        freeze = f"pack({_listed(slot.get for slot in sized)})"
        thaw = [f"{_listed(values[id(slot)] for slot in sized)} = unpack(state)"] * bool(sized)
        if self.has_open_slots:
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
            *(f"    {line}" for line in self.junk),
            *(f"    {slot.junk}" for slot in slots if slot.junk),
        ]
        exec(compile("\n".join(lines), "<abstraction>", "exec"), names)
        return names


def _listed(parts: Iterable[str]) -> str:
    """Join the parts with a comma after each, so that even a single part gives a tuple."""
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
            # Located variables are stored with the globals.
            if one.section in kept and one.address is None:
                yield one.name.upper(), one.type


def spoiling(code: str, kind: Type) -> list[str]:
    """Return statements that give a variable an arbitrary value of its type."""
    if isinstance(kind, StructType):
        return [
            line for name, part in kind.fields for line in spoiling(f"{code}.{name.upper()}", part)
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
