"""The scan of a model, run call by call, with cached results of each call.

A scan calls FB_ReadArea, the blocks of the model, and FB_WriteArea. Each call works on its own
instance and on shared data: the robot, and the plain variables of the program. The same combination
of instance state, shared data and inputs occurs in millions of scans. The result of each call is
therefore cached. Every state of a part has a number.

The cache does not omit anything. While a call runs, the program contains only the instance, the
shared data and the inputs of this call. `Explorer.check` compares one scan from each state with a
scan of the whole program.
"""

from __future__ import annotations

import marshal
from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any, NamedTuple

from rcx_tools.evidence.explore.abstraction import ModelAbstraction
from rcx_tools.evidence.explore.model import Choice, Model
from structured_text.engines.builtin import BuiltinProgram
from structured_text.explore.abstraction import NOW_US

__all__ = ["End", "Stages"]


class _Numbered:
    """The different values of a part of the program. Each value has a number and a note.

    Args:
        note: Function that makes the note while the program contains the value.
    """

    def __init__(self, note: Callable[[], Any]) -> None:
        self._note = note
        self._numbers: dict[Any, int] = {}
        self.values: list[Any] = []
        self.notes: list[Any] = []

    def number(self, key: Any, value: Any) -> int:
        """Return the number of the program's present value. `key` identifies the value."""
        found = self._numbers.setdefault(key, len(self.values))
        if found == len(self.values):
            self.values.append(value)
            self.notes.append(self._note())
        return found


class End(NamedTuple):
    """The result of a scan.

    Attributes:
        state: The numbers of the parts of the state: first the shared data, then each instance.
        shared: Note of the shared data.
        notes: Notes of the instances.
    """

    state: tuple[int, ...]
    shared: Any
    notes: list[Any]


class Stages:
    """Cached execution of the scans of a model.

    Args:
        model: The model.
        program: Compiled program of the model, in its initial state.
        state: Abstraction of the model. Its states are split into shared data and instances from
            now on.
        shared: Function that makes the note of the shared data while the program is in that state.
        notes: Functions that make the notes of the instances: FB_ReadArea, the blocks,
            FB_WriteArea.
    """

    def __init__(
        self,
        model: Model,
        program: BuiltinProgram,
        state: ModelAbstraction,
        shared: Callable[[], Any],
        notes: Sequence[Callable[[], Any]],
    ) -> None:
        self._model, self._program, self._root = model, program, state.root
        kind = type(self._root)
        names = program.module.names
        self._save, self._load = (
            names[f"{what}_{kind.__name__.removeprefix('b_')}"] for what in ("save", "load")
        )
        slots = kind.__slots__[1:]
        own = ["READAREA", *(block.name.upper() for block in model.blocks), "WRITEAREA"]
        free = {name.upper() for name in model.free()}
        together = ["ROBOT", *(slot for slot in slots if slot not in {"ROBOT", *own, *free})]
        self._parts = state.parts([together, *([name] for name in own)])
        held = [together, *([name] for name in own[:-1]), ["WRITEAREA", "OUTPUTAREA"]]
        self._places = [[slots.index(name) for name in some] for some in held]
        seen = sorted({name for part in self._parts[1:] for name in part.robot})
        looks = [attrgetter(name) for name in seen]
        robot = self._root.ROBOT.INNER
        self._views = _Numbered(lambda: None)
        self._root.CALLREAD = self._root.CALLWRITE = False
        self._start: tuple[Any, ...] = self._save(self._root)

        def note_shared() -> tuple[int, int, Any]:
            view = tuple(look(robot) for look in looks)
            return self._views.number(view, view), self._number(0), shared()

        # Full values of each part, and their abstract states. Index 0 is the shared data.
        self._held = [_Numbered(note) for note in (note_shared, *notes)]
        self._frozen = [_Numbered(lambda: None) for _ in self._parts]
        self.first = tuple(self._number(k) for k in range(len(self._parts)))
        """The initial state, as the numbers of its parts."""
        self._inputs = _Numbered(lambda: None)
        self._given = [self._inputs_of(own, choice) for choice in model.choices()]
        self._entries: list[dict[tuple[int, int], int]] = [{} for _ in self._parts]
        self._calls: list[dict[tuple[int, int, int], tuple[int, int]]] = [{} for _ in own]
        self._ends: list[dict[tuple[int, int], int]] = [{} for _ in own]

    def bytes_of(self, state: Sequence[int]) -> bytes:
        """Return a state in the bytes of the abstraction."""
        return b"".join(kept.values[one] for kept, one in zip(self._frozen, state, strict=True))

    def entry(self, state: Sequence[int], ticks: int) -> tuple[int, ...]:
        """Return the parts of a state at the start of a scan, after a number of ticks."""
        return tuple([self._entered(k, one, ticks) for k, one in enumerate(state)])

    def notes(self, entry: Sequence[int]) -> list[Any]:
        """Return the note of each instance in a state."""
        return [held.notes[one] for held, one in zip(self._held[1:], entry[1:], strict=True)]

    def scan(self, entry: Sequence[int], choice: Choice) -> End:
        """Run a scan. A call runs only if its result is not cached."""
        shared, *owns = entry
        ends = []
        # A call depends only on its own instance, the shared data before it, and its inputs. These
        # three numbers are the key of the cache. The shared data after one call are those before
        # the next, so a scan is a chain of look-ups. `view` is the part of the robot that a frozen
        # state depends on.
        for k, (calls, own, given) in enumerate(
            zip(self._calls, owns, self._given[choice.number], strict=True)
        ):
            key = shared, own, given
            found = calls.get(key)
            if found is None:
                found = calls[key] = self._called(k + 1, *key)
            shared = found[0]
            ends.append(found[1])
        view, first, noted = self._held[0].notes[shared]
        state, notes = [first], []
        for k, end in enumerate(ends):
            frozen = self._ends[k].get((end, view))
            if frozen is None:
                frozen = self._ends[k][end, view] = self._left(k + 1, shared, end)
            state.append(frozen)
            notes.append(self._held[k + 1].notes[end])
        return End(tuple(state), noted, notes)

    def reset(self) -> None:
        """Put the program into its initial state."""
        self._load(self._root, self._start)

    # --- calls whose results are not cached yet ---

    def _inputs_of(self, own: Sequence[str], choice: Choice) -> tuple[int, ...]:
        """Return the number of the input values of each call.

        The values of `switches` are inputs of all calls.
        """
        found = []
        for k, name in enumerate(own):
            pins = {
                0: {"CALLREAD", "CONNECTED"},
                len(own) - 1: {"CALLWRITE", "EMERGENCYSTOPOK", "STOPOK"},
            }.get(k, {f"CALL{name}", f"GO{name}"})
            pins |= self._model.switch_names()
            values = tuple((pin, value) for pin, value in choice.values if pin in pins)
            given = values, b"" if k else choice.image
            found.append(self._inputs.number(given, given))
        return tuple(found)

    def _number(self, k: int) -> int:
        """Return the number of the present abstract state of a part."""
        state = self._parts[k].freeze()
        return self._frozen[k].number(state, state)

    def _entered(self, k: int, number: int, ticks: int) -> int:
        found = self._entries[k].get((number, ticks))
        if found is None:
            self.reset()
            self._parts[0].thaw(self._frozen[0].values[self.first[0]], ticks)
            self._parts[k].thaw(self._frozen[k].values[number], ticks)
            found = self._entries[k][number, ticks] = self._keep(k)
        return found

    def _keep(self, k: int) -> int:
        """Return the number of the present full value of a part."""
        saved = self._save(self._root)
        held = [saved[place] for place in self._places[k]]
        return self._held[k].number(marshal.dumps(held, 2), held)

    def _put(self, shared: int, k: int, own: int) -> None:
        """Load the shared data and one instance into the program. The rest stays initial."""
        values = list(self._start)
        for part, number in ((0, shared), (k, own)):
            held = self._held[part].values[number]
            for place, value in zip(self._places[part], held, strict=True):
                values[place] = value
        self._load(self._root, values)

    def _called(self, k: int, shared: int, own: int, given: int) -> tuple[int, int]:
        """Call one instance. Return the new numbers of the shared data and of the instance."""
        self._put(shared, k, own)
        values, image = self._inputs.values[given]
        for name, value in values:
            setattr(self._root, name, value)
        self._root.INPUTAREA[: len(image)] = image
        self._program.scan(NOW_US)
        return self._keep(0), self._keep(k)

    def _left(self, k: int, shared: int, end: int) -> int:
        """Return the number of the abstract state of an instance at the end of a scan."""
        self._put(shared, k, end)
        return self._number(k)
