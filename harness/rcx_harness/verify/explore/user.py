"""The exploration of a program: inputs and a small controller change in every possible order."""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from hashlib import blake2b
from io import BytesIO
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from rcx_harness.cell.image import find_image
from rcx_harness.cell.node import status_path
from rcx_harness.cell.sources import blame_lib
from rcx_harness.spec.wire import SIZE
from rcx_harness.verify.explore.controller import FAULTS, MOVES, Small, Wire
from rcx_harness.verify.explore.demanded import Demanded
from rcx_harness.verify.explore.inputs import values_of
from rcx_harness.verify.explore.monitors import Monitors
from rcx_harness.verify.explore.state_tables import TABLES
from rcx_harness.verify.properties import Declared
from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.image_source import reads_located
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.storage import is_scalar
from structured_text.errors import InputError
from structured_text.explore.abstraction import NOW_US, Abstraction
from structured_text.explore.always import with_always
from structured_text.explore.search import Result, Search, World
from structured_text.explore.shared import Stepping, shared
from structured_text.farm import Farm
from structured_text.language.load import load
from structured_text.language.project import Project
from structured_text.language.source import in_dialect
from structured_text.language.walk import written
from structured_text.projects.sources import SourceFiles
from structured_text.prove.assertions import VARIABLE, Copies

__all__ = ["Choice", "Explored", "Settings", "explore", "refuse"]

#: Number of bytes of the digest that identifies a state.
_DIGEST = 16
#: Number of bytes in the length field at the end of a state.
_LENGTH = 4
#: The search begins in one process for this time [s], because worker processes would slow down a
#: short search.
_ALONE_S = 1.0


class Choice(NamedTuple):
    """An event before a scan: a move of the controller and a new value of an input."""

    number: int
    move: str
    path: str
    text: str
    """The new value of the input, as the user wrote it."""
    value: Any

    def tell(self) -> str:
        """Return a description of the choice in words."""
        parts = [MOVES[self.move]] if self.move else []
        parts += [f"{self.path} := {self.text}"] if self.path else []
        return ", ".join(parts) or "nothing"


@dataclass(frozen=True)
class Settings:
    """The settings of an exploration.

    Attributes:
        inputs: Values of each input in Structured Text. An empty list for a BOOL means both values.
        always: Expressions that hold after every scan, in the names of the program.
        properties: Properties from TOML files, which name variables by paths. Properties in Python
            are not supported.
        faults: Names from `controller.FAULTS`.
        size: Bytes of the areas.
        m: Where the area from the controller begins.
        n: Where the area to the controller begins.
        robot: Whether there is a controller. Without a controller the program has no areas.
        states: Greatest number of states to expand; 0 means no limit.
        depth: Greatest number of scans from the start; 0 means no limit.
        seed: The seed of the random checks of the abstraction.
        report: Called with the number of expanded states and of known states.
    """

    inputs: Mapping[str, Sequence[str]] = field(default_factory=dict)
    always: Sequence[str] = ()
    properties: Sequence[Declared] = ()
    faults: frozenset[str] = frozenset(FAULTS)
    scan_us: int = 100_000
    size: int = SIZE
    m: int = 0
    n: int = 0
    robot: bool = True
    states: int = 0
    depth: int = 0
    seed: int = 1
    report: Callable[[int, int], None] | None = None


@dataclass(frozen=True)
class Explored:
    """The result of an exploration.

    Attributes:
        result: The figures, and the first broken rule with its path, a sequence of `Choice` items.
        inputs: The possible values of each input.
        left: Inputs for which the user gave no values. They keep their initial values.
        areas: For each scan of the path, the area that the PLC reads and the state of the link.
    """

    result: Result
    inputs: Mapping[str, Sequence[str]]
    left: Sequence[str]
    areas: Sequence[tuple[bytes, bool]]


def explore(sources: SourceFiles, settings: Settings, farm: Farm | None = None) -> Explored:
    """Explore a program.

    Without a `farm` of worker processes, this process does all the work. The result does not depend
    on it.
    """
    own, library = sources.users
    with TemporaryDirectory() as folder:
        copies = with_always(own, settings.always, Path(folder))
        try:
            project = load([in_dialect(file, sources.dialect) for file in copies.files] + library)
        except InputError as error:
            raise _of_original(blame_lib(error, sources.folder), copies) from None
        steady = steady_instances(sources.own, sources.lib)
        kind = _Program if settings.robot else _Alone
        world = kind(project, copies, settings, steady)
        taken, alone_s = None, 0.0
        if farm is not None and (farm.workers > 1 or farm.cluster is not None):
            make = partial(kind, project, copies, replace(settings, report=None), steady)
            taken = shared(farm, Stepping(make, settings.seed))
            alone_s = _ALONE_S if farm.cluster is None else 0.0
        search = Search(world, world.every, settings.seed, taken, alone_s)
        result = search.run("program", settings.states, settings.depth, settings.report)
        inputs = {path: [text for text, _ in found] for path, found in world.inputs.items()}
        path = result.broken.path if result.broken else ()
        return Explored(result, inputs, _left(project, world), list(world.areas(path)))


def _of_original(error: InputError, copies: Copies) -> InputError:
    said = [one for one in copies.assertions if (one.file, one.line) == (error.file, error.line)]
    if said:
        return InputError(f"{said[0].text!r} cannot be checked: {error.message}", hint=error.hint)
    file = copies.original(error.file)
    return InputError(
        error.message, file=file or None, line=error.line, column=error.column, hint=error.hint
    )


class _Program(World[Choice]):
    """A program with its surroundings. A state contains the memory of both after a scan."""

    moves: Collection[str] = tuple(MOVES)

    def __init__(
        self, project: Project, copies: Copies, settings: Settings, steady: Collection[str]
    ) -> None:
        refuse(project)
        self._settings, self._copies = settings, copies
        self.program = program = BuiltinProgram.build(project)
        self.status: str | None = None
        self._areas = (bytes(settings.size), bytes(settings.size))
        self._surround(project)
        self.inputs = {
            path: list(values_of(program, path, texts)) for path, texts in settings.inputs.items()
        }
        self._state = Abstraction(program, settings.scan_us, TABLES)
        self._monitors = Monitors(program, settings.size, settings.scan_us, steady)
        areas = self._exchanged if settings.robot else None
        self._demanded = Demanded(program, settings.properties, settings.scan_us, areas)
        sets = [("", "", None)]
        sets += [(path, *one) for path, found in self.inputs.items() for one in found]
        pairs = [(move, one) for move in self.moves for one in sets]
        self.every = [Choice(k, move, *one) for k, (move, one) in enumerate(pairs)]
        self._by_move = {move: [c for c in self.every if c.move == move] for move in self.moves}

    def _surround(self, project: Project) -> None:
        """Find the variables of the program that contain the areas."""
        self._image = find_image(
            self.program,
            size=self._settings.size,
            m=self._settings.m,
            n=self._settings.n,
            located=reads_located(project),
        )
        self.status = status_path(self.program, 1)

    def first(self) -> bytes:
        """Return the initial state, before the first scan."""
        memory = (Small(), Wire(), self._demanded.state(), *self._monitors.state())
        return self._state.freeze() + _packed(memory)

    def known_as(self, state: bytes) -> bytes:
        """Return a digest of 128 bits that identifies a state."""
        return blake2b(state, digest_size=_DIGEST).digest()

    def packed(self, state: bytes) -> bytes:
        """Return the state in compressed form; most of its bytes are 0."""
        return zlib.compress(state, 1)

    def unpacked(self, packed: bytes) -> bytes:
        """Decompress a state that `packed` returned."""
        return zlib.decompress(packed)

    def choices(self, state: bytes) -> Sequence[Choice]:
        """Return each possible move of the controller, without and with each change of an input."""
        small, wire, *_ = _memory(state)
        self._state.thaw(state)
        now = {path: self.program.read(path) for path in self.inputs}
        moves = self._possible(small.seen(wire), wire)
        return [
            choice
            for move in moves
            for choice in self._by_move[move]
            if not choice.path or now[choice.path] != choice.value
        ]

    def _possible(self, small: Small, wire: Wire) -> Iterable[str]:
        """Return the moves that the controller may make in a state."""
        return small.moves(wire, self._settings.faults)

    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Run one scan, and return the following state and the broken rules."""
        self._state.thaw(state)
        return self._scan(state, choice, NOW_US)

    def check(self, state: bytes, choice: Choice, following: bytes, random: Random) -> None:
        """Check that the abstraction is sound for one step.

        The same scan runs at another time, with other tickets and scan numbers. It must lead to the
        same state. If it does not, the abstraction has left out a variable with an effect.
        """
        now_us = self._state.disturb(state, 1, random)
        there, broken = self._scan(state, choice, now_us)
        if there != following or broken:
            where = "; ".join(self._state.differences(there, following)) or "a monitor"
            raise InputError(
                f"the states of this program cannot be distinguished: {where}",
                hint="please report it with the program; nothing is said about its rules",
            )

    def areas(self, path: Sequence[Choice]) -> Iterator[tuple[bytes, bool]]:
        """Yield, for each scan of a path, the area that the PLC reads and the state of the link."""
        state = self.first()
        for choice in path:
            small = self._after(state, choice)
            yield small.area(self._settings.size), small.link
            state, _ = self.step(state, choice)

    def _after(self, state: bytes, choice: Choice) -> Small:
        small, wire, *_ = _memory(state)
        after: Small = small.seen(wire).after(choice.move)
        return after

    def _scan(self, state: bytes, choice: Choice, now_us: int) -> tuple[bytes, list[str]]:
        program, small = self.program, self._after(state, choice)
        _, _, demanded, *monitors = _memory(state)
        self._monitors.go_to(monitors, now_us)
        self._demanded.go_to(demanded, now_us)
        if choice.path:
            program.write(choice.path, choice.value)
        self._put(small)
        try:
            program.scan(now_us)
        except InputError as error:
            return state, [self._stopped(error)]
        wire, broken = self._get(small, now_us)
        broken += self._demanded.scan(now_us)
        memory = (small, wire, self._demanded.state(now_us), *self._monitors.state(now_us))
        return self._state.freeze() + _packed(memory), broken

    def _put(self, small: Small) -> None:
        """Write the controller's area and link status into the process image."""
        if self.status is not None:
            self.program.write(self.status, small.link)
        self._image.put(small.area(self._settings.size), small.link)

    def _get(self, small: Small, now_us: int) -> tuple[Wire, list[str]]:
        """Return the output area of the program, and the rules that the program has broken."""
        self._areas = so, si = small.area(self._settings.size), self._image.get()
        return Wire.of(si), self._monitors.scan(now_us, so, si, connected=small.link)

    def _exchanged(self) -> Sequence[tuple[bytes, bytes]]:
        """Return the areas that the program has read and written in the last scan."""
        return (self._areas,)

    def _stopped(self, error: InputError) -> str:
        for one in self._copies.assertions:
            if (one.file, one.line) == (str(error.file), error.line):
                return f"always: {one.text}"
        return f"stops: {_of_original(error, self._copies)}"


class _Alone(_Program):
    """A program without a controller, used if `Settings.robot` is False."""

    moves = ("",)

    def _surround(self, project: Project) -> None:
        pass

    def _possible(self, small: Small, wire: Wire) -> Iterable[str]:
        return self.moves

    def _after(self, state: bytes, choice: Choice) -> Small:
        return Small()

    def _put(self, small: Small) -> None:
        pass

    def _get(self, small: Small, now_us: int) -> tuple[Wire, list[str]]:
        return Wire(), []


def _packed(memory: tuple[Any, ...]) -> bytes:
    """Return the memory of controller, properties and monitors as bytes.

    Equal memory gives equal bytes.
    """
    small, wire, *others = memory
    stream = BytesIO()
    pickler = pickle.Pickler(stream, protocol=5)
    pickler.fast = True  # equal objects must give equal bytes, even if they are not the same object
    pickler.dump((tuple(small), tuple(wire), *others))
    packed = stream.getvalue()
    return packed + len(packed).to_bytes(_LENGTH, "little")


def _memory(state: bytes) -> tuple[Any, ...]:
    """Return the memory of the program that is stored in a state."""
    length = int.from_bytes(state[-_LENGTH:], "little")
    return _unpacked(state[-_LENGTH - length : -_LENGTH])


@lru_cache(1024)
def _unpacked(packed: bytes) -> tuple[Any, ...]:
    small, wire, *others = pickle.loads(packed)
    return Small(*small), Wire(*wire), *others


def refuse(project: Project) -> None:
    """Raise InputError if states cannot be distinguished or never recur."""
    if any(run.every > 1 for run in project.schedule):
        raise InputError(
            "the program has tasks of several intervals",
            hint="explore a program whose tasks have the same interval",
        )
    clocks = [pou for pou in project.pous.values() if pou.clock]
    if clocks:
        raise InputError(
            f"{clocks[0].name} reads the time, which never comes back to where it was",
            file=clocks[0].file,
            hint="measure with a TON",
        )


def _left(project: Project, world: _Program) -> list[str]:
    """Return the inputs without values from the user.

    Inputs are variables that neither a program nor the scanner sets.
    """
    given = {path.upper() for path in world.inputs}
    names = []
    for instance, block in project.instances.items():
        pou = project.pous[block.name.upper()]
        writes = written(pou)
        for symbol in pou.symbols.values():
            path = f"{instance}.{symbol.name}"
            own = symbol.section in ("VAR", "VAR_INPUT") and not symbol.constant
            free = own and is_scalar(symbol.type) and symbol.address is None
            if free and symbol.name.upper() not in writes and path.upper() not in given:
                names.append(path)
    return [one for one in names if one != world.status and VARIABLE not in one]
