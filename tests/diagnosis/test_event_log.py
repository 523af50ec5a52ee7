"""FB_EventLog stores entries in a ring buffer, shows them to a panel, and can freeze.

The tests use the FB_EventLog inside FB_CommandRecorder.
"""

from __future__ import annotations

import pytest

from recorder_bench import Recorder, connected, short


@pytest.fixture
def recorder() -> Recorder:
    """Return a recorder with a connection and CPU_OK. Its log has two rows: the link and SO(01)."""
    return connected()


# ---- tests of the log's entries and of freezing


def test_the_oldest_entries_are_overwritten_and_a_page_shows_eight(recorder: Recorder) -> None:
    recorder.edges(10)
    assert recorder["Count"] == 12
    recorder.edges(30)
    assert (recorder["Count"], recorder["Total"]) == (32, 42)
    for first, moments in (
        (0, range(400, 320, -10)),
        (8, range(320, 240, -10)),
        (24, range(160, 80, -10)),
    ):
        recorder.change("First", to=first)
        assert [row["Moment"] for row in recorder["Rows"]] == list(moments), first


@pytest.mark.parametrize(
    ("first", "shown"),
    [
        (-9, [0, 0, 0, 0, 0, 0, 0, 0]),
        (-8, [0, 0, 0, 0, 0, 0, 0, 0]),
        (-7, [0, 0, 0, 0, 0, 0, 0, 400]),
        (-1, [0, 400, 390, 380, 370, 360, 350, 340]),
        (25, [150, 140, 130, 120, 110, 100, 90, 0]),
        (31, [90, 0, 0, 0, 0, 0, 0, 0]),
        (32, [0, 0, 0, 0, 0, 0, 0, 0]),
        (32_767, [0, 0, 0, 0, 0, 0, 0, 0]),
    ],
)
def test_rows_beyond_the_log_are_empty(recorder: Recorder, first: int, shown: list[int]) -> None:
    recorder.edges(40)
    recorder.change("First", to=first)
    assert [row["Moment"] for row in recorder["Rows"]] == shown
    empty = [row["Kind"] == "LOG_NOTHING" for row in recorder["Rows"]]
    assert empty == [moment == 0 for moment in shown]


def test_a_smaller_log_keeps_fewer_entries() -> None:
    """With LogSize = 3 the log keeps the three newest entries. Source: RCX_LOG."""
    recorder = Recorder()
    recorder["LogSize"] = 3
    recorder.change("Robot.Connected", to=True)
    recorder.edges(4)
    assert (recorder["Count"], recorder["Total"]) == (3, 5)
    assert [row["Moment"] for row in recorder["Rows"]] == [40, 30, 20, 0, 0, 0, 0, 0]


@pytest.mark.parametrize(("size", "count"), [(8, 8), (1, 1), (0, 0), (-1, -1)])
def test_a_log_that_becomes_smaller_stays_within_its_bounds(
    recorder: Recorder, size: int, count: int
) -> None:
    recorder.edges(35)
    recorder["LogSize"] = size
    for _ in range(40):
        recorder.edges(1)
        assert recorder["Count"] == count
    shown = sum(row["Kind"] != "LOG_NOTHING" for row in recorder["Rows"])
    assert shown == max(count, 0)


# ---- freezing


def test_while_it_is_frozen_nothing_is_kept_and_nothing_is_made_up_for(recorder: Recorder) -> None:
    recorder["Freeze"] = True
    recorder.edges(1)
    recorder.command(0x0200)
    recorder.change("BlockError", to=0x8010)
    assert recorder["Frozen"]
    assert recorder["Total"] == 2
    recorder.change("Freeze", to=False, scans=2)
    assert not recorder["Frozen"]
    assert recorder["Total"] == 2
    recorder.edges(1)
    assert recorder["Total"] == 3


def test_a_fault_is_shown_also_while_the_log_is_frozen(recorder: Recorder) -> None:
    recorder["Freeze"] = True
    recorder.change("Robot.SO.SO03_Alarm", to=True)
    assert short(recorder["Fault"]) == ("LOG_OUTPUT", 3, 1)


@pytest.mark.parametrize("after", [0, 1, 3])
def test_a_fault_freezes_the_log_after_the_given_number_of_entries(
    recorder: Recorder, after: int
) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = after
    recorder.change("Robot.SO.SO03_Alarm", to=True)
    for _ in range(after):
        assert not recorder["Frozen"]
        recorder.edges(1)
    assert recorder["Frozen"]
    recorder.edges(3)
    assert recorder["Frozen"]
    assert recorder["Total"] == 3 + after
    assert recorder.rows()[after] == ("LOG_OUTPUT", 3, 1)


def test_by_default_the_log_freezes_eight_entries_after_a_fault(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder.change("BlockError", to=0x8001)
    recorder.edges(20)
    assert recorder["Total"] == 3 + 8


def test_a_second_fault_does_not_move_the_end(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 3
    for error in (0x8001, 0x8002, 0x8003, 0x8004, 0x8005):
        recorder.change("BlockError", to=error)
    assert recorder["Frozen"]
    assert recorder.rows()[0] == ("LOG_ERROR", 0, 0x8004)
    assert short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8001)


def test_without_freeze_on_fault_the_log_does_not_freeze(recorder: Recorder) -> None:
    recorder["After"] = 0
    recorder.change("BlockError", to=0x8001)
    recorder.edges(20)
    assert not recorder["Frozen"]
    assert recorder["Total"] == 23


def test_other_entries_do_not_freeze_the_log(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 0
    recorder.edges(5)
    recorder.command(0x0200)
    assert not recorder["Frozen"]


def test_resume_clears_the_fault_and_records_again(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 0
    recorder["Robot.Inner.Data"] = [3] * 15
    recorder.command(0x4000)
    assert recorder["Frozen"]
    recorder.change("Resume", to=True)
    assert not recorder["Frozen"]
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"
    assert (recorder["FaultCode"], recorder["FaultData"]) == (0, [0] * 15)
    recorder.edges(1)
    assert recorder["Total"] == 4

    recorder.change("BlockError", to=0x8012, scans=3)
    assert recorder["Frozen"], "Resume is an edge: it is still TRUE"
    assert short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8012)


def test_a_fault_in_the_scan_of_resume_is_a_new_one(recorder: Recorder) -> None:
    recorder.command(0x4000, code=0x1001)
    recorder.command(0x0200, code=0x1002)
    recorder["Resume"] = True
    recorder.change("BlockError", to=0x8012)
    assert short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8012)
    assert recorder["FaultCode"] == 0x1002


def test_the_first_fault_stays_until_resume(recorder: Recorder) -> None:
    recorder.command(0x4000, code=0x1001)
    recorder.command(0x4000, code=0x1002)
    assert short(recorder["Fault"]) == ("LOG_COMMAND", 0x1001, 0x4000)
    assert recorder["FaultCode"] == 0x1001
