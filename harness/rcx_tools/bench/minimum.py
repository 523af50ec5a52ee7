"""Theoretical minimum in docs/explanation/timing.md: the earliest possible time of each step.

The calculation does not use the blocks. It uses three clocks, the order of the steps, and the
interval of 100 ms from the manual.
"""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.cell.clock import Timing
from rcx_harness.spec.wire import CYCLE_US

__all__ = ["Clocks", "Command", "Step", "command", "sequence"]

#: A command that is shorter than this time ends in the cycle in which it begins. The controller
#: then skips the status "running".
_SHORT_US = CYCLE_US


@dataclass(frozen=True)
class Command:
    """The earliest times of a remote command; each is the time of a scan [us].

    Attributes:
        code: The code is written. The data words were written one scan earlier.
        done: The end status is read.
        ready: The status 0x0000 is read after the reset, and the next data words are written.
        following: The code of the next command is written.
    """

    code: int
    done: int
    ready: int
    following: int


@dataclass(frozen=True)
class Step:
    """The earliest times of one dedicated input of a sequence; each is the time of a scan [us].

    Attributes:
        on: The input goes ON.
        done: The controller's answer is read.
        off: The input goes OFF.
    """

    on: int
    done: int
    off: int


class Clocks:
    """The clocks of PLC scan, packet and controller cycle, without jitter."""

    def __init__(self, timing: Timing) -> None:
        self.scan_us, self._rpi_us = timing.scan_us, timing.rpi_us
        self._cycle_phase, self._to_robot, self._to_plc, self._scan_phase = timing.phases

    def scan(self, t_us: int) -> int:
        """Return S(t): the first scan at `t_us` or later."""
        return _next(t_us, self.scan_us, self._scan_phase)

    def cycle(self, t_us: int) -> int:
        """Return C(t): the first controller cycle at `t_us` or later."""
        return _next(t_us, CYCLE_US, self._cycle_phase)

    def seen_by_robot(self, t_us: int) -> int:
        """Return R(t): the cycle in which the controller reads the outputs of the scan at `t_us`.

        The first packet after a scan sends the outputs of the scan. A cycle reads all packets that
        have arrived before the cycle.
        """
        packet = _next(t_us + 1, self._rpi_us, self._to_robot)
        return self.cycle(packet + 1)

    def seen_by_plc(self, t_us: int) -> int:
        """Return A(t): the scan that reads the answer of the cycle at `t_us`."""
        return self.scan(_next(t_us, self._rpi_us, self._to_plc))


def command(
    clocks: Clocks, start_us: int, *, accept_us: int, run_us: int, reset_us: int
) -> Command:
    """Return the earliest times of a remote command in the handshake.

    Args:
        clocks: The three clocks.
        start_us: The scan of the rising edge. In this scan the status is 0x0000, and the channel is
            free.
        accept_us: The controller's time from the code to the beginning of the command.
        run_us: Duration of the command.
        reset_us: The controller's time from the code 0x0000 to the status 0x0000.
    """
    code = start_us + clocks.scan_us
    begun = clocks.cycle(clocks.seen_by_robot(code) + accept_us)
    ended = begun if run_us < _SHORT_US else clocks.cycle(begun + run_us)
    done = clocks.seen_by_plc(ended)
    ready = clocks.seen_by_plc(clocks.cycle(clocks.seen_by_robot(done) + reset_us))
    return Command(code, done, ready, ready + clocks.scan_us)


def sequence(
    clocks: Clocks, start_us: int, answers_us: tuple[int, ...], spacing_us: int
) -> list[Step]:
    """Return the earliest times of dedicated inputs in a row. The end of one step starts the next.

    Args:
        clocks: The three clocks.
        start_us: The scan of the first rising edge. No input has changed for `spacing_us` before
            this scan.
        answers_us: The controller's time from each input to its answer.
        spacing_us: Interval between two changes: 100 ms plus the margin.
    """
    steps: list[Step] = []
    # `asked` is the time at which the next input is requested; `free` is the time at which the wire
    # may change again. Each input waits for both times. The OFF edge of an input is also a change,
    # so the next input has to wait for another interval.
    asked, free = start_us, start_us
    for answer_us in answers_us:
        on = clocks.scan(max(asked, free))
        done = clocks.seen_by_plc(clocks.cycle(clocks.seen_by_robot(on) + answer_us))
        off = clocks.scan(max(done, on + spacing_us))
        steps.append(Step(on, done, off))
        asked, free = done, off + spacing_us
    return steps


def _next(t_us: int, period_us: int, phase_us: int) -> int:
    """Return the first of the times phase, phase + period, ... that is not before `t_us`."""
    return max(0, -(-(t_us - phase_us) // period_us)) * period_us + phase_us
