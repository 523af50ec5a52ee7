"""The signals that a cell waits for: the PLC for bits of the robot, robot programs for inputs.

The signals of the PLC are found by trial. In the area that the PLC reads, each output bit that a
robot program names is inverted. If the outputs of the PLC then change, the PLC waits for the bit.
The trial is undone and takes no virtual time.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import combinations

from rcx_harness.cell import Cell
from rcx_harness.robot.ports import Port, value_in
from rcx_harness.robot.program.task import RobotTask
from structured_text.errors import InputError

__all__ = ["plc_waits", "robot_waits", "waits"]

#: Time of a trial in which the PLC can react [us], and its least and greatest number of scans.
_REACTS_US, _LEAST, _MOST = 1_000_000, 3, 200
#: If there are more bits than this number, pairs of bits are not tried.
_MOST_IN_PAIRS = 12
_WAIT = re.compile(r"\bWAIT\s+((?:[^':\"]|\"[^\"]*\")+)", re.IGNORECASE)

#: A bit of a robot, with the index of the robot in the cell.
_Bit = tuple[int, Port]


def waits(cell: Cell) -> str:
    """Return the signals that PLC and robot programs wait for; empty if no program runs."""
    robots = list(robot_waits(cell))
    if not robots:
        return ""
    bits = plc_waits(cell)
    return ", ".join([f"PLC waits for {' or '.join(bits)}"] * bool(bits) + robots)


def robot_waits(cell: Cell) -> Iterator[str]:
    """Yield the line and the awaited signals of each running robot program."""
    for number, robot in enumerate(cell.robots, 1):
        which = f" of controller {number}" if len(cell.robots) > 1 else ""
        for task in robot.program.tasks:
            if task.state == "running" and not task.endless:
                yield f"robot program {task.program.name}{which} {_doing(task)}"


def _doing(task: RobotTask) -> str:
    """Return the line of a task, and the condition for which the task waits."""
    code = task.code
    text = code.texts[task.line - 1].strip() if task.line <= len(code.texts) else ""
    kind = code.code[task.at].kind if task.at < len(code.code) else ""
    waiting = _WAIT.search(text)
    if kind == "wait" and waiting:
        return f"waits in line {task.line} for {waiting[1].strip()}"
    return f"is in line {task.line}: {text}" if text else f"is in line {task.line}"


def plc_waits(cell: Cell) -> list[str]:
    """Return the output bits of the robots for which the PLC waits.

    If no single bit changes the outputs of the PLC, pairs of bits are tried.
    """
    bits = [
        (number, bit)
        for number, robot in enumerate(cell.robots)
        for bit in _output_bits(robot.program.tasks)
    ]
    with cell.trial_of_program():
        try:
            trial = _Trial(cell)
            single = [trial.words((one,)) for one in bits if trial.reacts((one,))]
            if single or len(bits) > _MOST_IN_PAIRS:
                return single
            return [trial.words(pair) for pair in combinations(bits, 2) if trial.reacts(pair)]
        except InputError:  # an error in the trial stops the PLC, so the trial has no result
            return []


class _Trial:
    """Trial scans of the PLC program in which output bits of the robots are inverted."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._before = cell.program.snapshot()
        self._areas = [so for so, _ in cell.exchanged()]
        scans = max(_LEAST, min(_MOST, _REACTS_US // cell.timing.scan_us))
        self._times = [cell.now_us + k * cell.timing.scan_us for k in range(1, scans + 1)]
        self._unchanged = list(self._outputs(self._areas))

    def reacts(self, bits: Sequence[_Bit]) -> bool:
        """Return whether the PLC's outputs change if these bits are inverted."""
        outputs = self._outputs(self._inverted(bits))
        return any(a != b for a, b in zip(outputs, self._unchanged, strict=False))

    def words(self, bits: Sequence[_Bit]) -> str:
        """Return the awaited bits with their values, such as `SO(21) and SO(20) OFF`."""
        areas = self._inverted(bits)
        return " and ".join(
            bit.name
            + ("" if value_in(bit, areas[number]) else " OFF")
            + (f" of controller {number + 1}" if len(areas) > 1 else "")
            for number, bit in bits
        )

    def _inverted(self, bits: Sequence[_Bit]) -> list[bytes]:
        areas = [bytearray(area) for area in self._areas]
        for number, bit in bits:
            areas[number][bit.at] ^= 1 << (bit.bit or 0)
        return [bytes(area) for area in areas]

    def _outputs(self, areas: Sequence[bytes]) -> Iterator[list[bytes]]:
        """Yield the PLC's outputs of each scan while it reads these areas."""
        cell = self._cell
        cell.program.restore(self._before)
        for now_us in self._times:
            for image, area in zip(cell.images, areas, strict=True):
                image.put(area, connected=True)
            cell.program.scan(now_us)
            yield [image.get() for image in cell.images]


def _output_bits(tasks: list[RobotTask]) -> list[Port]:
    """Return the general-purpose output bits that robot programs name, in their order."""
    named = {
        place.name: place
        for task in tasks
        for instruction in task.code.code
        for node in instruction.nodes()
        if node.kind == "port"
        for place in node.args
        if isinstance(place, Port) and place.output and not place.bank and place.bit is not None
    }
    return [named[name] for name in sorted(named)]
