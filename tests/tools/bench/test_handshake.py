"""Handshakes take the minimum of scans in timing.md. `make bench` tests all combinations."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from rcx_harness.cell.clock import Timing
from rcx_harness.cell.sources import default_lib
from rcx_tools.bench import handshake
from rcx_tools.bench.handshake import Case, grid, simulate_command, simulate_sequence
from rcx_tools.bench.minimum import Clocks, command, sequence

_PAGE = Path(__file__).resolve().parents[3] / "docs/explanation/timing.md"
#: Times without a common divisor, and the limits of the ranges.
_GRID = grid((1, 7, 20), (1, 13, 100), (0, 7))


def _printed() -> list[list[int]]:
    """Return the whole numbers in each line of the worked examples of the page."""
    lines = re.findall(r"^\| \d+ ms .*$", _PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return [[int(number) for number in re.findall(r"\d+", line)] for line in lines]


@pytest.mark.parametrize("line", _printed(), ids=lambda line: f"{line[0]} ms, RPI {line[1]} ms")
def test_formula_and_blocks_take_the_scans_that_the_page_prints(line: list[int]) -> None:
    """Formula and blocks take the scans that the page prints, which are the minimum.

    Done is counted in scans from Execute, the next code in scans from Done.

    Source: docs/explanation/timing.md, worked examples; guide chapters 1 and 2.
    """
    scan, rpi, response, *times, done_scans, next_scans = line
    found = simulate_command(Case(scan * 1000, rpi * 1000, response * 1000), together=True)
    assert [time // 1000 for time in found.minimum] == times
    assert found.took == found.minimum
    assert done_scans == times[1] // scan
    assert next_scans == (times[3] - times[1]) // scan


def test_the_page_prints_some_examples() -> None:
    """Source: docs/explanation/timing.md, worked examples."""
    assert len(_printed()) >= 5


@pytest.mark.parametrize("case", _GRID, ids=str)
def test_a_command_and_its_successor_take_the_fewest_scans_possible(case: Case) -> None:
    """Source: docs/explanation/timing.md; guide chapters 1 and 2."""
    found = simulate_command(case)
    assert found.took == found.minimum


@pytest.mark.parametrize("case", grid((3, 20), (7, 50), (0,)), ids=str)
def test_sequences_wait_only_for_the_controller_and_the_interval(case: Case) -> None:
    """Sequences wait only for the controller and for the interval.

    The sequence has alarm reset, servo ON, program reset and start, one after the other.

    Source: docs/explanation/timing.md; manual chapter 5, 3.
    """
    found = simulate_sequence(case)
    assert found.took == found.minimum


def test_a_packet_sent_at_the_time_of_a_scan_has_no_outputs_of_this_scan() -> None:
    """A packet that leaves at the time of a scan does not contain the outputs of this scan.

    With all clocks at 10 ms, outputs written at 10 are sent at 20 and read in the cycle at 25.

    Source: docs/explanation/timing.md, three clocks.
    """
    clocks = Clocks(Timing.make(scan="10ms", rpi="10ms"))
    assert clocks.seen_by_robot(10_000) == 25_000
    assert clocks.seen_by_plc(25_000) == 30_000
    assert clocks.seen_by_plc(30_000) == 30_000


def test_phases_move_each_clock() -> None:
    """A phase moves each clock: packets leave at 1, 11, ... and cycles run at 2, 7, 12.

    Outputs written at 3 are read at 12.

    Source: docs/explanation/timing.md, three clocks.
    """
    phases = {"cycle": "2ms", "to_robot": "1ms", "to_plc": "4ms", "scan": "3ms"}
    clocks = Clocks(Timing.make(scan="10ms", rpi="10ms", phases=phases))
    assert clocks.seen_by_robot(3_000) == 12_000
    assert clocks.seen_by_plc(12_000) == 23_000


def test_the_bounds_of_the_page_hold() -> None:
    """Source: docs/explanation/timing.md, a remote command."""
    for case in _GRID:
        scan, rpi = case.scan_us, case.rpi_us
        took = case.response_us
        rounded = -(-took // 5_000) * 5_000
        run = took if took >= 5_000 else 0
        least = command(
            Clocks(case.timing), case.phases[3], accept_us=took, run_us=took, reset_us=took
        )
        start = case.phases[3]
        assert scan + took + run < least.done - start
        assert least.done - start < 2 * scan + 2 * rpi + 5_000 + 2 * rounded
        assert scan + took < least.following - least.done
        assert least.following - least.done < 2 * scan + 2 * rpi + 5_000 + rounded


def test_an_input_turns_off_after_its_answer_and_the_interval() -> None:
    """An input turns OFF after its answer and after the interval of 120 ms.

    With an answer at 40, it turns OFF at 120 and ON again at 240. With a late answer, it turns OFF
    at once.

    Source: docs/explanation/timing.md, dedicated inputs; manual chapter 5, 3.
    """
    clocks = Clocks(Timing.make(scan="10ms", rpi="10ms"))
    first, second = sequence(clocks, 0, (20_000, 200_000), 120_000)
    assert (first.on, first.done, first.off) == (0, 40_000, 120_000)
    assert (second.on, second.done, second.off) == (240_000, 460_000, 460_000)


def test_a_library_that_needs_one_more_scan_is_detected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The benchmark detects a library that needs one scan more between two commands.

    Source: docs/explanation/timing.md: extra scans 0, and the bench would see one.
    """
    library = tmp_path / "lib"
    shutil.copytree(default_lib(), library)
    file = library / "core" / "FB_RcxHandshake.st"
    text = file.read_text(encoding="utf-8")
    found = "IF Hold OR NOT Robot.Inner.CodeRequest THEN"
    assert found in text
    slow = found.replace(" THEN", " OR Robot.Inner.Phase = PHASE_STATUS_RESET THEN")
    file.write_text(text.replace(found, slow), encoding="utf-8")
    monkeypatch.setattr(handshake, "default_lib", lambda: library)
    assert simulate_command(Case(10_000, 10_000, 0)).extra == 1
