"""FB_RcxScanTime counts whole milliseconds since the last scan and loses none."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from random import Random

import pytest

from both_engines import ENGINES
from plc_bench import compiled

_PROGRAM = """
PROGRAM Clocked
  VAR
    ScanTime : FB_RcxScanTime;
    Total    : UDINT;
  END_VAR
  ScanTime();
  Total := Total + UINT_TO_UDINT(ScanTime.Milliseconds);
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#1ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Clocked;
  END_RESOURCE
END_CONFIGURATION
"""


def _counted(engine: str, gaps_us: Sequence[int]) -> tuple[list[int], int]:
    """Return the milliseconds counted in each scan, and their sum.

    `gaps_us` are the times between the scans.
    """
    program = compiled(_PROGRAM, engine)
    counted = []
    for now_us in accumulate(gaps_us, initial=5_000_000):
        program.scan(now_us)
        counted.append(program.read("Main.ScanTime.Milliseconds"))
    return counted, program.read("Main.Total")


@pytest.mark.parametrize("engine", ENGINES)
def test_the_first_scan_gives_0_and_each_further_one_the_time_since_the_last(
    engine: str,
) -> None:
    gaps = [10_000, 1_000, 999_000, 1_000_000, 1_001_000, 0, 64_999_000]
    counted, _ = _counted(engine, gaps)
    assert counted == [0, 10, 1, 999, 1000, 1001, 0, 64_999]


@pytest.mark.parametrize("engine", ENGINES)
def test_parts_of_a_millisecond_count_later(engine: str) -> None:
    counted, _ = _counted(engine, [600, 600, 600, 600, 10_600])
    assert counted == [0, 0, 1, 0, 1, 11]


@pytest.mark.parametrize("engine", ENGINES)
def test_from_65_s_on_it_is_65535_and_goes_on_from_there(engine: str) -> None:
    gaps = [65_000_000, 10_000, 3_600_000_000, 10_000, 99_999_000, 7_000]
    counted, _ = _counted(engine, gaps)
    assert counted == [0, 65_535, 10, 65_535, 10, 65_535, 7]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("scan_us", [1_000, 2_000, 4_000, 8_000, 16_000, 128_000, 333, 7_777])
def test_a_long_run_loses_and_gains_no_millisecond(engine: str, scan_us: int) -> None:
    """After 3000 scans, the counted milliseconds equal the elapsed time.

    On matiec about half of the time literals are one nanosecond short. These errors must not add
    up.
    """
    _, total = _counted(engine, [scan_us] * 3000)
    assert total == scan_us * 3000 // 1000


@pytest.mark.parametrize("engine", ENGINES)
def test_uneven_scans_add_up_too(engine: str) -> None:
    random = Random(8)
    gaps = [random.choice((1, 999, 1000, 1001, 20_000, 999_999, 2_500_000)) for _ in range(3000)]
    counted, total = _counted(engine, gaps)
    assert total == sum(gaps) // 1000
    assert counted[1:] == [
        after // 1000 - before // 1000
        for before, after in zip(accumulate(gaps, initial=0), accumulate(gaps), strict=False)
    ]
