"""The states of a cell in an exploration: bytes that restore a state, and keys that identify it."""

from __future__ import annotations

import io
import marshal
import pickle
import zlib
from collections.abc import Iterator
from hashlib import blake2b
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.verify.explore.relative import relative
from rcx_harness.verify.explore.state_tables import TABLES
from rcx_harness.verify.properties import Judge
from rcx_harness.watch.wire import INTERVAL_US
from structured_text.bench.agenda import STIMULUS
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.explore.abstraction import Abstraction

__all__ = ["CellStates", "FrozenStates"]

#: Number of bytes in the digest that identifies a state, and version of `marshal`.
_DIGEST, _MARSHAL = 16, 2


class FrozenStates:
    """Converts states of a cell to bytes and back. The cell has not run its first scan.

    The bytes of a state are valid in all processes that build the same cell.
    """

    def __init__(self, cell: Cell, judge: Judge) -> None:
        assert isinstance(cell.program, BuiltinProgram)
        self._cell, self._judge = cell, judge
        # These objects never change. A state contains only the positions of these objects in this
        # list.
        self._fixed = list(_fixed(cell))
        self._places = {id(one): place for place, one in enumerate(self._fixed)}

    def freeze(self, *, stimuli: bool = True) -> bytes:
        """Return the state of the cell as bytes; planned actions only with `stimuli`."""
        snapshot: Any = self._cell.snapshot()
        if not stimuli:
            queue, count, periods = snapshot.bench.agenda
            left = tuple(one for one in queue if one[1] != STIMULUS)
            bench = snapshot.bench._replace(agenda=(left, count, periods))
            snapshot = snapshot._replace(bench=bench)
        return self._frozen(snapshot)

    def _frozen(self, snapshot: object) -> bytes:
        stream = io.BytesIO()
        pickler = _Pickler(stream, self._places)
        try:
            pickler.dump((snapshot, self._judge.snapshot()))
        except (TypeError, AttributeError, pickle.PicklingError) as error:
            text = f"a state of this cell cannot be stored: {error}"
            raise InputError(text, hint="please report it with the cell") from None
        return zlib.compress(stream.getvalue(), 1)

    def thaw(self, state: bytes) -> None:
        """Bring the cell into a state that `freeze` returned."""
        stream = io.BytesIO(zlib.decompress(state))
        cell, judge = _Unpickler(stream, self._fixed).load()
        self._cell.restore(cell)
        self._judge.restore(judge)


class CellStates(FrozenStates):
    """The states of a cell with one robot, with keys that identify them."""

    def __init__(self, cell: Cell, judge: Judge) -> None:
        super().__init__(cell, judge)
        assert isinstance(cell.program, BuiltinProgram)
        self._program = Abstraction(cell.program, cell.timing.scan_us, TABLES)

    def key(self) -> bytes:
        """Return the key of the cell's state; states with the same key behave alike."""
        return self._key(self._cell.snapshot())

    def freeze_with_key(self) -> tuple[bytes, bytes]:
        """Return the state of the cell, and its key."""
        snapshot = self._cell.snapshot()
        return self._frozen(snapshot), self._key(snapshot)

    def _key(self, snapshot: Any) -> bytes:
        now_us = self._cell.now_us
        self._program.now = now_us * 1000
        parts = (
            self._program.freeze(),
            tuple(self._nodes(snapshot.nodes, now_us)),
            _of_plc(snapshot.bench.plc),
            relative(self._judge.memory(now_us), now_us),
            _clocks(snapshot.bench.agenda, now_us),
        )
        return blake2b(marshal.dumps(parts, _MARSHAL), digest_size=_DIGEST).digest()

    def _nodes(self, nodes: Any, now_us: int) -> Iterator[Any]:
        """Yield controller, network and wire monitor of each node."""
        scan_us, timeout_us = self._cell.timing.scan_us, self._cell.timing.timeout_us
        for robot, network, wire, _, _ in nodes:
            (*state, _, lost_us), (last, due), images, random, _ = network
            # Events before these times have no effect on later packets (see `PacketNetwork`).
            reopens_us = -(scan_us + timeout_us)
            yield (
                relative(robot, now_us),
                tuple(state),
                None if lost_us is None else max(lost_us - now_us, reopens_us),
                tuple(None if t is None else max(t - now_us, -timeout_us) for t in last),
                tuple(max(t - now_us, 0) for t in due),
                images,
                random if self._cell.timing.jitter_us else None,
                tuple(_of_wire(wire, now_us)),
            )


def _of_plc(plc: Any) -> Any:
    """Return the memory of the monitors, and whether the PLC runs."""
    (contract, (_, faults)), runs, powered, _ = plc
    # The monitor stores the last called block of each robot. This block has an effect only if there
    # are several robots.
    return relative((contract, faults), 0), runs, powered


def _clocks(agenda: Any, now_us: int) -> Any:
    """Return the times of the next packet, cycle and scan."""
    queue, _, _ = agenda
    return tuple(sorted((t_us - now_us, int(kind), device) for t_us, kind, device, *_ in queue))


def _of_wire(wire: Any, now_us: int) -> Iterator[Any]:
    """Yield the memory of a wire monitor.

    Changes older than 100 ms and counters of commands are left out.
    """
    values = dict(wire)
    changed_us = values["_changed_us"]
    ago_us = None if changed_us is None else min(now_us - changed_us, INTERVAL_US)
    yield ago_us, values["_changed_what"] if ago_us is not None and ago_us < INTERVAL_US else ""
    for name, value in values.items():
        if name not in ("commands", "_changed_us", "_changed_what") and not isinstance(value, dict):
            yield name, value


def _fixed(cell: Cell) -> Iterator[Any]:
    snapshot: Any = cell.snapshot()
    queue, _, _ = snapshot.bench.agenda
    yield snapshot.bench.program.module
    yield cell.timing
    for *_, action in queue:
        yield action
    for number, robot in enumerate(cell.robots, 1):
        yield cell.network_of(number)  # packets on their way refer to their network
        yield robot.config
        yield from robot.config.programs
        yield from (task.code for task in robot.program.tasks)


class _Pickler(pickle.Pickler):
    """A pickler that replaces objects that never change by their positions in a list."""

    def __init__(self, stream: io.BytesIO, places: dict[int, int]) -> None:
        super().__init__(stream, protocol=5)
        self._places = places

    def persistent_id(self, one: Any) -> int | None:
        """Return the position of an object that never changes; None for all others."""
        return self._places.get(id(one))


class _Unpickler(pickle.Unpickler):
    def __init__(self, stream: io.BytesIO, fixed: list[Any]) -> None:
        super().__init__(stream)
        self._fixed = fixed

    def persistent_load(self, place: int) -> Any:
        """Return the object at this position in the list of objects that never change."""
        return self._fixed[place]
