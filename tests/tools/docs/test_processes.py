"""The processes of docs/explanation/charts agree with their traces.

The tests do not use the code of the charts. The orders of steps are from the manual. The changes of
a step may come in any order, and each step comes after the previous one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import pytest

from rcx_harness import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.robot import RobotConfig
from rcx_harness.trace import Cycle, Scan
from rcx_tools.docs.processes import Process, processes

#: SI(n) as the PLC writes it, SO(m) as the PLC reads it. "rcx" marks signals of the controller.
ORDERS: dict[str, list[set[str]]] = {
    # Chapter 5, 3.1, initial servo ON process after power ON
    "servo_on": [{"SI01 ON"}, {"SO02 ON"}, {"SI01 OFF"}],
    # Chapter 5, 3.1, shift to emergency stop
    "emergency_stop": [{"SI00 OFF"}, {"SO00 ON", "SO03 ON", "SO02 OFF"}],
    # Chapter 5, 3.1, servo ON process from emergency stop status
    "servo_on_from_emergency_stop": [
        {"SI00 ON"},
        {"SO00 OFF"},
        {"SI16 ON"},
        {"SO03 OFF"},
        {"SI16 OFF"},
        {"SI01 ON"},
        {"SO02 ON"},
        {"SI01 OFF"},
    ],
    # Chapter 5, 3.2, AUTO mode changeover process (its inputs are not on a network)
    "auto_mode": [{"SO10 ON"}],
    # Chapter 5, 3.2, program reset process
    "program_reset": [{"SI15 ON"}, {"SO14 ON"}, {"SI15 OFF"}],
    # Chapter 5, 3.2, program execution process; 3.3 has the same
    "program_execution": [{"SI12 ON"}, {"SO14 OFF", "SO13 ON"}, {"SI12 OFF"}],
    # Chapter 5, 3.3, program stop process using stop input
    "program_stop": [{"SI06 OFF"}, {"SO13 OFF"}],
    # Chapter 5, 3.3, program execution after stopping program with stop input
    "program_continue": [{"SI06 ON"}, {"SI12 ON"}, {"SO13 ON"}, {"SI12 OFF"}],
    # Chapter 5, 3.1 and 3.2 in a row, with an alarm at the beginning
    "power_up": [
        {"SO01 ON", "SO00 ON", "SO03 ON"},
        {"SI00 ON"},
        {"SO00 OFF"},
        {"SI06 ON"},
        {"SI16 ON"},
        {"SO03 OFF"},
        {"SI16 OFF"},
        {"SI01 ON"},
        {"SO02 ON"},
        {"SI01 OFF"},
        {"SI15 ON"},
        {"SO14 ON"},
        {"SI15 OFF"},
        {"SI12 ON"},
        {"SO14 OFF", "SO13 ON"},
        {"SI12 OFF"},
    ],
    # Chapter 1, 5, transition to the connection error state, and back to the normal state
    "link_loss": [
        {"rcx SI00 OFF", "rcx SI06 OFF", "rcx SO00 ON", "rcx SO02 OFF", "rcx SO03 ON"},
        {"rcx SI00 ON"},
        {"rcx SO00 OFF"},
        {"rcx SI06 ON"},
    ],
    # Remote command guide, chapter 2, steps 1 to 6
    "remote_command": [
        {"n+2 0004", "n+6 0032", "n+8 0013"},
        {"n 0001"},
        {"m 0100"},
        {"m 0200"},
        {"n 0000"},
        {"m 0000"},
    ],
    # Remote command guide, chapter 1.2, abnormal end by an emergency stop, and chapter 2
    "remote_command_abnormal_end": [
        {"n+2 0004", "n+6 0032", "n+8 0013"},
        {"n 0001"},
        {"m 0100"},
        {"m 4000", "m+2 000C", "m+4 0258"},
        {"n 0000"},
        {"m 0000", "m+2 0000", "m+4 0000"},
    ],
}

_each = pytest.mark.parametrize("name", ORDERS)


@dataclass
class Run:
    """The records of a run, from the beginning to the end of the chart of its process."""

    process: Process
    scans: list[Scan]
    cycles: list[Cycle]

    def changes(self) -> list[tuple[int, str]]:
        """Return every change of a bit or word of ORDERS, in the order of time."""
        found: list[tuple[int, str]] = []
        for before, after in pairwise(self.scans):
            bits = [*_bits("SI", before.si, after.si), *_bits("SO", before.so, after.so)]
            words = [*_words("n", before.si, after.si), *_words("m", before.so, after.so)]
            found += [(after.t_us, change) for change in bits + words]
        for one, two in pairwise(self.cycles):
            none = bytes(48)
            bits = [*_bits("SI", one.rcx_si or none, two.rcx_si or none)]
            bits += _bits("SO", one.rcx_so, two.rcx_so)
            found += [(two.t_us, f"rcx {change}") for change in bits]
        return sorted(found)


def _bits(kind: str, before: bytes, after: bytes) -> list[str]:
    return [
        f"{kind}{byte - 32}{bit} {'ON' if after[byte] >> bit & 1 else 'OFF'}"
        for byte in (32, 33)
        for bit in range(8)
        if (before[byte] ^ after[byte]) >> bit & 1
    ]


def _words(kind: str, before: bytes, after: bytes) -> list[str]:
    return [
        f"{kind}{f'+{at}' if at else ''} {after[at + 1]:02X}{after[at]:02X}"
        for at in range(0, 32, 2)
        if before[at : at + 2] != after[at : at + 2]
    ]


def run(name: str, robot: RobotConfig | None = None, longer_us: int = 0) -> Run:
    """Run a process as `rcx run` runs it."""
    process = processes()[name]
    with Cell.build(process.program, robot=robot) as cell:
        Stimulus.load(process.stimulus).schedule(cell)
        cell.run(process.end_us + longer_us)
        assert not cell.violations
        shown = [one for one in cell.trace if one.t_us >= process.begin_us]
        return Run(
            process,
            [one for one in shown if isinstance(one, Scan)],
            [one for one in shown if isinstance(one, Cycle)],
        )


def test_every_process_has_an_order_here_and_every_order_a_process() -> None:
    assert sorted(processes()) == sorted(ORDERS)


@_each
def test_the_steps_of_a_process_come_in_the_order_of_the_manual(name: str) -> None:
    """The steps of a process come in the order of the manual.

    No other change of these signals occurs.

    Each step begins after the previous one is complete.

    Source: manual chapter 1, 5; chapter 5, 3.1 to 3.3; guide chapters 1.2 and 2.
    """
    order = ORDERS[name]
    expected = set().union(*order)
    sides = ("rcx",) if name == "link_loss" else ("SI", "SO", "n", "m")
    happened = [change for _, change in run(name).changes() if change.startswith(sides)]
    # Changes before the first step of the chart, and signals without a step, are left out.
    begin = min(happened.index(change) for change in order[0])
    taken = [change for change in happened[begin:] if change in expected]
    for number, step in enumerate(order, 1):
        part, taken = taken[: len(step)], taken[len(step) :]
        assert set(part) == step, f"step {number}"
    assert not taken


@_each
def test_the_controller_reads_dedicated_inputs_at_least_100_ms_apart(name: str) -> None:
    """Between two changes of dedicated inputs, the controller reads at least 100 ms.

    The only exception is switching SI(00) or SI(06) OFF.

    Source: manual chapter 5, 3.1 to 3.3, caution.
    """
    cycles = run(name).cycles
    last: int | None = None
    for before, after in pairwise(cycles):
        if not before.rcx_si or not after.rcx_si:
            last = None
            continue
        changed = _bits("SI", before.rcx_si, after.rcx_si)
        if not changed:
            continue
        stops = set(changed) <= {"SI00 OFF", "SI06 OFF"}
        assert stops or len(changed) == 1, f"{changed} in one exchange at {after.t_us} us"
        assert stops or last is None or after.t_us - last >= 100_000, f"{changed} at {after.t_us}"
        last = after.t_us


#: A controller that answers later than the interval, so a block must wait to keep the order.
SLOW = RobotConfig(
    servo_on_delay=250, alarm_reset_delay=250, program_reset_delay=250, program_start_delay=250
)


@pytest.mark.parametrize(
    ("name", "request_", "answer", "end"),
    [
        ("servo_on", "SI01 ON", "SO02 ON", "SI01 OFF"),
        ("servo_on_from_emergency_stop", "SI16 ON", "SO03 OFF", "SI16 OFF"),
        ("servo_on_from_emergency_stop", "SI01 ON", "SO02 ON", "SI01 OFF"),
        ("program_reset", "SI15 ON", "SO14 ON", "SI15 OFF"),
        ("program_execution", "SI12 ON", "SO13 ON", "SI12 OFF"),
        ("program_continue", "SI12 ON", "SO13 ON", "SI12 OFF"),
        ("power_up", "SI15 ON", "SO14 ON", "SI15 OFF"),
    ],
)
def test_an_input_stays_on_until_its_answer_however_late(
    name: str, request_: str, answer: str, end: str
) -> None:
    """The inputs for servo ON, alarm reset, program reset and start stay ON until their answer.

    Source: manual chapter 5, 3.1 to 3.3, the steps that follow a confirmation.
    """
    when = {change: t_us for t_us, change in run(name, SLOW, 2_000_000).changes()}
    assert when[request_] + 250_000 < when[answer] <= when[end]


def test_after_a_recovered_connection_nothing_restarts_by_itself() -> None:
    """After a recovery of the connection only SI(00) and SI(06) turn ON; nothing else restarts.

    Servo and alarm do not change.

    Source: manual chapter 1, 5, 2.
    """
    loss = run("link_loss")
    end = loss.cycles[-1]
    assert end.rcx_si[32:34] == bytes([0x41, 0x00])
    assert end.rcx_so[32] >> 2 & 1 == 0, "SO(02)"
    assert end.rcx_so[32] >> 3 & 1 == 1, "SO(03)"


def test_the_emergency_stop_and_the_stop_are_sent_in_the_scan_of_their_edge() -> None:
    """Source: manual chapter 5, 3.1, shift to emergency stop, step 1; 3.3, program stop, step 1."""
    for name, change, halt_us in (
        ("emergency_stop", "SI00 OFF", 1_000_000),
        ("program_stop", "SI06 OFF", 2_000_000),
    ):
        assert (halt_us, change) in run(name).changes()
