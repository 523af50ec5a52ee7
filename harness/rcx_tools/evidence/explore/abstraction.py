"""The abstraction of a model: a state as a few bytes, which are split into several parts.

This abstraction omits more than the abstraction for programs of users. The model is known, and
tables say which variables of the library influence later scans:

* Time: all scans of a model have the same interval, or one of a few intervals that the environment
  chooses. A TON only compares the time since its start with PT. So only the ticks since its start
  matter, and all numbers above the longest PT of the model are equal. Only `Tables.clock` reads ET,
  and it restarts its TON in every scan. Its ET is 0 before the first scan, and then the time since
  the previous scan. Waits that are counted in milliseconds are ordinary numbers; none exceeds its
  limit.
* Words without a later effect are omitted, as the tables say.
* All other values are replaced by an index, in the order of their first occurrence.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from structured_text.engines.builtin import BuiltinProgram
from structured_text.explore.abstraction import NOW_US, Abstraction, Place, Slot, spoiling
from structured_text.explore.omitted import Omitted, Tables
from structured_text.language.types import ArrayType, BlockType, ElementaryType, EnumType, Type

__all__ = ["ModelAbstraction", "Part"]

_EXPIRED = 255
#: Pattern of members of the robot in the code of a slot.
_ROBOT = re.compile(r"\brobot\.([A-Z0-9_.]+)")


class Part(NamedTuple):
    """The part of a state that contains some variables of the program.

    `ModelAbstraction.parts` makes it.
    """

    robot: tuple[str, ...]
    """The members of the shared structure that this part also uses."""
    freeze: Callable[[], bytes]
    """Function that returns the bytes of this part after a scan at `NOW_US`."""
    thaw: Callable[[bytes, int], None]
    """Function that restores the variables of this part, a number of ticks later.

    The shared structure must already be restored.
    """


class ModelAbstraction(Abstraction):
    """The encoder and decoder of the states of a model.

    Args:
        program: The program, in its initial state.
        tick_us: Time of one count of a timer.
        ticks: Longest time of any timer in the program, in ticks.
        free: Variables of the program that are written before each scan.
        tables: Facts about the library.
    """

    has_open_slots = False

    def __init__(
        self, program: BuiltinProgram, tick_us: int, ticks: int, free: set[str], tables: Tables
    ) -> None:
        assert ticks < _EXPIRED - 1
        self._free, self._cap = free, ticks
        self._fixed: list[tuple[Any, str, str]] = []
        self._wide: list[Any] = [0]
        self._index: dict[Any, int] = {0: 0}
        self._part_of: dict[int, str] = {}
        self._current = ""
        super().__init__(program, tick_us, tables)

    @property
    def size(self) -> int:
        """Return the number of bytes of a state."""
        return self.packed.size

    def parts(self, groups: Sequence[Sequence[str]]) -> list[Part]:
        """Split the state into parts.

        From now on, a state is the concatenation of the parts' bytes.

        Args:
            groups: Names of the program's variables in each part, in upper case. The first part
                must contain the robot, and each stored variable must be in exactly one part.
        """
        places = {name: place for place, names in enumerate(groups) for name in names}
        self.slots.sort(key=lambda one: places[self._part_of[id(one)]])
        self.compile()
        found = []
        for group in groups:
            slots = [slot for slot in self.slots if self._part_of[id(slot)] in group]
            robot = {one for slot in slots for one in _ROBOT.findall(f"{slot.get} {slot.put}")}
            names = self.functions(slots)
            freeze = partial(self._freeze_part, names["freeze"])
            thaw = partial(self._thaw_part, names["thaw"])
            found.append(Part(tuple(sorted(robot)), freeze, thaw))
        return found

    def _freeze_part(self, freeze: Callable[[], bytes]) -> bytes:
        self.now = NOW_US * 1000
        return freeze()

    def _thaw_part(self, thaw: Callable[[bytes, int, int], None], state: bytes, ticks: int) -> None:
        self.now = NOW_US * 1000
        thaw(state, self.now - ticks * self.tick, 0)

    def check_fixed(self) -> None:
        """Check after a scan that the `fixed` variables of the tables have not changed."""
        for holder, slot, before in self._fixed:
            if repr(_held(getattr(holder, slot))) != before:
                raise AssertionError(f"{type(holder).__name__}.{slot} is not fixed")

    def values(self, state: bytes) -> tuple[Any, ...]:
        """Return the state as a sequence of numbers."""
        return self.packed.unpack_from(state)

    # --- called by the generated code ---

    def names(self) -> dict[str, Any]:
        """Return the names that the generated code of the slots uses."""
        more = {"ton": self._ton, "set_ton": self._set_ton}
        return super().names() | more | {"index": self._wide_index, "wide": self._wide}

    def _wide_index(self, value: Any) -> int:
        key = tuple(value) if isinstance(value, list) else value
        found = self._index.get(key)
        if found is None:
            found = self._index[key] = len(self._wide)
            self._wide.append(key)
        return found

    def _ton(self, timer: Any) -> int:
        """Return the byte of a TON: 0 if idle, 255 if expired, else 1 + elapsed ticks."""
        if timer.phase == 0:
            return 0
        if timer.phase == 2:
            return _EXPIRED
        elapsed = (self.now - timer.start) // self.tick
        return 1 + min(int(elapsed), self._cap)

    def _set_ton(self, timer: Any, code: int, now: int) -> None:
        timer.phase = timer.before = timer.Q = 0
        if code == _EXPIRED:
            timer.phase, timer.before, timer.Q = 2, True, True
        elif code:
            timer.phase, timer.before = 1, True
            timer.start = now - (code - 1) * self.tick

    # --- planning of the slots ---

    def plan(self, program: BuiltinProgram) -> None:
        """Plan all variables of the only program of the model."""
        kind = next(iter(program.instances().values()))
        assert isinstance(kind, BlockType)
        self.walk(kind, self.root, Omitted(dropped=" ".join(self._free)), "", "")
        self._name_part()

    def shared_structure(self, program: BuiltinProgram) -> Any:
        """Return the structure that all blocks of the library share (the robot)."""
        return getattr(getattr(self.root, self.tables.variable), self.tables.member)

    def dropped(self, kind: Type, type_name: str, kept: Omitted, owner: str) -> set[str]:
        """Return the variables of a structure or block that the tables omit."""
        return set(kept.dropped.upper().split())

    def conditional(self, type_name: str, kept: Omitted) -> Mapping[str, str]:
        """Map each variable that is read only under a condition to this condition."""
        return kept.while_true

    def jobs(self, type_name: str) -> dict[str, str]:
        """Return an empty mapping, because the tables already name the channels of all jobs."""
        return {}

    def variable(self, place: Place, slot: str, part: Type) -> None:
        """Plan one variable of a structure or block."""
        if place.held is self.root:
            self._name_part()
            self._current = slot
        kept, tables = place.kept, self.tables
        code = f"{place.name}.{slot}"
        is_own_channel = place.type_name == tables.channel and place.channel == "own"
        is_fixed = slot in kept.fixed.upper().split()
        if is_fixed and not is_own_channel:
            self._fixed.append((place.held, slot, repr(_held(getattr(place.held, slot)))))
        elif is_fixed:
            self.junk += spoiling(code, part)
        elif slot in place.dropped:
            super().variable(place, slot, part)
        elif slot in kept.flags.upper().split():
            self.slots.append(Slot(f"{code} != 0", f"{code} = {{v}} * 0x8001"))
        elif isinstance(part, BlockType) and part.name == "TON":
            is_clock = place.type_name == tables.clock
            self._timer(code, place.conditions.get(slot, ""), reads_et=is_clock)
        else:
            super().variable(place, slot, part)

    def _name_part(self) -> None:
        """Record which program variable contains the slots that were added since the last call."""
        for slot in self.slots:
            self._part_of.setdefault(id(slot), self._current)

    def turn(self, code: str, name: str, slot: str, *, own: bool) -> None:
        """Plan a counter of a channel as its difference from Serving. Serving itself becomes 0."""
        if slot == "LOWEST" and not own:
            # At the end of a scan the library sets LOWEST to NextTicket, because the next scan has
            # not seen any ticket yet.
            self.slots.append(Slot(f"{code} != {name}.NEXTTICKET", f"{code} = {name}.NEXTTICKET"))
        else:
            super().turn(code, name, slot, own=own)

    def _timer(self, code: str, condition: str, *, reads_et: bool) -> None:
        junk = f"set_ton({code}, random.choice((0, 1, 2, 255)), now)"
        self.slots.append(Slot(f"ton({code})", f"set_ton({code}, {{v}}, now)", condition, junk))
        et = "0" if reads_et else "random.randrange(10**9)"
        self.junk += [f"{code}.ET = {et}"]

    def plain(self, code: str, kind: Type, condition: str) -> None:
        """Plan a scalar, or an array of scalars."""
        junk = "; ".join(spoiling(code, kind))
        get, put = f"index({code})", f"{code} = wide[{{v}}]"
        if isinstance(kind, ArrayType):
            put = f"{code}[:] = wide[{{v}}] or [0] * len({code})"
        elif isinstance(kind, EnumType):
            get, put = code, f"{code} = {{v}}"
        elif isinstance(kind, ElementaryType) and kind.name == "BOOL":
            get, put = code, f"{code} = {{v}} == 1"
        self.slots.append(Slot(get, put, condition, junk))


def _held(value: Any) -> Any:
    """Return the value of a variable in a form that can be compared."""
    slots = getattr(value, "__slots__", None)
    if slots is None:
        return value
    return [_held(getattr(value, slot)) for slot in slots]
