"""FB_CommandRecorder: what it keeps, what a fault is, and what a panel sees of it.

The test plays the robot: it writes RCX_REF as FB_ReadArea and FB_WriteArea leave it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import pytest

from alone import Alone
from rcx_harness import spec

Row = tuple[str, int, int]

_NOTHING: Row = ("LOG_NOTHING", 0, 0)


class Recorder:
    """The block, called every 10 ms."""

    def __init__(self) -> None:
        self._alone = _alone()
        self._alone.restart()
        self._now_ms = 0

    def __setitem__(self, path: str, value: Any) -> None:
        self._alone[path if path.startswith("Robot.") else f"Block.{path}"] = value

    def __getitem__(self, path: str) -> Any:
        return self._alone[f"Block.{path}"]

    def scan(self, count: int = 1) -> None:
        """Run scans."""
        for _ in range(count):
            self._alone["Robot.Elapsed"] = min(self._now_ms, 10)
            self._alone.scan(self._now_ms)
            self._now_ms += 10

    def rows(self) -> list[Row]:
        """Kind, Number and Result of the rows, without empty ones at the end."""
        rows = [_short(row) for row in self["Rows"]]
        while rows and rows[-1] == _NOTHING:
            rows.pop()
        return rows

    def edges(self, count: int) -> None:
        """Let SO(15), warning, change so many times, once a scan."""
        for _ in range(count):
            self["Robot.SO.SO15_Warning"] = not self._alone["Robot.SO.SO15_Warning"]
            self.scan()

    def command(self, status: int, code: int = 0x1001, **fields: Any) -> None:
        """A remote command is out for three scans and ends with this status."""
        self["Robot.Code"] = code
        self["Robot.Phase"] = "PHASE_COMMAND_DATA"
        self.scan()
        self["Robot.Phase"] = "PHASE_COMMAND_RUN"
        self.scan(3)
        self["Robot.Status"] = status
        self["Robot.Phase"] = "PHASE_STATUS_RESET"
        for path, value in fields.items():
            self[f"Robot.{path.replace('__', '.')}"] = value
        self.scan()
        self["Robot.Status"] = 0
        self["Robot.Phase"] = "PHASE_READY"
        self.scan()


@cache
def _alone() -> Alone:
    return Alone("FB_CommandRecorder", {"Robot": "RCX_REF"})


def _short(entry: Mapping[str, Any]) -> Row:
    return entry["Kind"], entry["Number"], entry["Result"]


@pytest.fixture
def recorder() -> Recorder:
    """Connected, CPU_OK, and the log begins after that: one row, SO(01)."""
    block = Recorder()
    block["Robot.Connected"] = True
    block["Robot.SO.SO01_CpuOk"] = True
    block.scan()
    assert block.rows() == [("LOG_OUTPUT", 1, 1), ("LOG_LINK", 0, 1)]
    return block


# ---- commands


def test_a_command_is_kept_at_its_end_with_its_status_and_how_long_it_was_out(
    recorder: Recorder,
) -> None:
    """Source: guide chapter 2; out in the scans at 20, 30 and 40 ms, ended in that at 50 ms."""
    recorder.command(0x0200, code=0x2001)
    assert recorder["Rows"][0] == {
        "Kind": "LOG_COMMAND",
        "Number": 0x2001,
        "Result": 0x0200,
        "Group": 0,
        "Category": 0,
        "Moment": 50,
        "Duration": 30,
    }
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"
    assert recorder["FaultCode"] == 0


def test_the_command_that_is_out_is_shown_with_its_time(recorder: Recorder) -> None:
    recorder["Robot.Code"] = 0x0505
    recorder["Robot.Phase"] = "PHASE_COMMAND_DATA"
    recorder.scan(2)
    assert recorder["Code"] == 0
    recorder["Robot.Phase"] = "PHASE_COMMAND_RUN"
    recorder.scan(1)
    assert (recorder["Code"], recorder["Running"]) == (0x0505, 0)
    recorder.scan(4)
    assert (recorder["Code"], recorder["Running"]) == (0x0505, 40)
    assert recorder["Count"] == 2
    recorder["Robot.Phase"] = "PHASE_STATUS_RESET"
    recorder.scan()
    assert (recorder["Code"], recorder["Running"]) == (0, 0)
    assert recorder["Rows"][0]["Duration"] == 50


def test_an_abnormal_end_brings_its_alarm_and_is_a_fault_with_the_words_of_the_command(
    recorder: Recorder,
) -> None:
    """Source: guide chapter 1, 1.2, code 0x4000; 0x0002 and 0x014E are 2.334."""
    data = [4, 0, 50, 19, *range(11)]
    recorder["Robot.Data"] = data
    recorder.command(0x4000, Response=[2, 334, *[0] * 13])
    entry = recorder["Rows"][0]
    assert _short(entry) == ("LOG_COMMAND", 0x1001, 0x4000)
    assert (entry["Group"], entry["Category"]) == (2, 334)
    assert recorder["Fault"] == entry
    assert (recorder["FaultCode"], recorder["FaultData"]) == (0x1001, data)


def test_only_an_abnormal_end_has_an_alarm(recorder: Recorder) -> None:
    """The words of a normal end are its response.

    Source: guide chapter 1, 1.2
    """
    recorder.command(0x0200, Response=[2, 334, *[0] * 13])
    assert (recorder["Rows"][0]["Group"], recorder["Rows"][0]["Category"]) == (0, 0)


@pytest.mark.parametrize(
    ("group", "category", "fault"),
    [(12, 400, False), (12, 401, True), (11, 400, True), (2, 334, True)],
)
def test_a_stop_is_no_fault_but_every_other_alarm_is(
    recorder: Recorder, group: int, category: int, fault: bool
) -> None:
    """Source: guide 4.2.6: a jog ends abnormally by the stop input, 0x000C and 0x0190."""
    recorder.command(0x4000, Response=[group, category, *[0] * 13])
    assert (recorder["Fault"]["Kind"] == "LOG_COMMAND") is fault


def test_a_continuous_output_that_the_plc_ends_is_no_fault(recorder: Recorder) -> None:
    """Source: guide 4.7.4: it has no end status; the status is still 0x0100."""
    recorder.command(0x0100, code=0x0505)
    assert recorder.rows()[0] == ("LOG_COMMAND", 0x0505, 0x0100)
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"


@pytest.mark.parametrize(
    ("change", "result"),
    [
        ({}, 0x8014),
        ({"SO__SO01_CpuOk": False}, 0x8002),
        ({"Connected": False, "SO__SO01_CpuOk": False}, 0x8001),
    ],
)
def test_a_command_without_an_end_has_the_error_id_that_its_block_has(
    recorder: Recorder, change: dict[str, Any], result: int
) -> None:
    """Source: docs/errors.md, 16#8014, 16#8002 and 16#8001."""
    recorder.command(0x0000, **change)
    ends = [row for row in recorder.rows() if row[0] == "LOG_COMMAND"]
    assert ends == [("LOG_COMMAND", 0x1001, result)]
    first = ("LOG_LINK", 0, 0) if "Connected" in change else ends[0]
    assert _short(recorder["Fault"]) == first
    assert recorder["FaultCode"] == 0x1001


def test_a_status_that_is_left_over_does_not_hide_a_lost_link(recorder: Recorder) -> None:
    recorder.command(0x4000, Connected=False, Response=[12, 400, *[0] * 13])
    assert ("LOG_COMMAND", 0x1001, 0x8001) in recorder.rows()


def test_the_words_of_a_command_are_those_it_went_out_with(recorder: Recorder) -> None:
    recorder["Robot.Data"] = [7] * 15
    recorder.command(0x4000, Data=[9] * 15)
    assert recorder["FaultData"] == [7] * 15


# ---- dedicated bits and the link

_BITS = [
    *(("SO", signal) for signal in spec.signals().output),
    *(("SI", signal) for signal in spec.signals().input),
]


@pytest.mark.parametrize(
    ("direction", "signal"), _BITS, ids=lambda part: getattr(part, "short", str(part))
)
def test_each_change_of_a_dedicated_bit_is_kept_by_the_number_of_the_manual(
    recorder: Recorder, direction: str, signal: spec.Signal
) -> None:
    """SO(00) and SO(03) that come ON are faults, and no other change is.

    Source: manual chapter 5, 2
    """
    kind = {"SO": "LOG_OUTPUT", "SI": "LOG_INPUT"}[direction]
    number = int(signal.short[2:], 16)
    path = f"Robot.{direction}.{signal.name}"
    for other, one in _BITS:
        recorder[f"Robot.{other}.{one.name}"] = one is not signal and one.short != "SO03"
    level = signal.short == "SO01"
    recorder[path] = level
    recorder["Robot.SO.SO00_EmergencyStop"] = False
    recorder.scan()
    before = recorder["Total"]
    for result in (not level, level):
        recorder[path] = result
        recorder.scan(2)
        assert recorder.rows()[0] == (kind, number, int(result))
        fault = recorder["Fault"]["Kind"] != "LOG_NOTHING"
        assert fault is (signal.short in ("SO00", "SO03"))
    assert recorder["Total"] == before + 2
    if signal.short in ("SO00", "SO03"):
        assert _short(recorder["Fault"]) == (kind, number, 1)


def test_several_changes_in_one_scan_are_kept_in_the_order_of_their_numbers(
    recorder: Recorder,
) -> None:
    for name in ("SO.SO03_Alarm", "SO.SO15_Warning", "SI.SI00_EmergencyStop"):
        recorder[f"Robot.{name}"] = True
    recorder.scan()
    assert recorder.rows()[:3] == [
        ("LOG_INPUT", 0x00, 1),
        ("LOG_OUTPUT", 0x15, 1),
        ("LOG_OUTPUT", 0x03, 1),
    ]


def test_without_a_link_outputs_are_not_believed_and_afterwards_only_real_changes_are_kept(
    recorder: Recorder,
) -> None:
    """Source: manual chapter 1, 5: no communication in the error state."""
    recorder["Robot.Connected"] = False
    recorder["Robot.SO.SO01_CpuOk"] = False
    recorder["Robot.SI.SI06_Stop"] = True
    recorder.scan(3)
    assert recorder.rows()[:2] == [("LOG_INPUT", 6, 1), ("LOG_LINK", 0, 0)]
    recorder["Robot.Connected"] = True
    recorder["Robot.SO.SO01_CpuOk"] = True
    recorder["Robot.SO.SO00_EmergencyStop"] = True
    recorder.scan(3)
    assert recorder.rows()[:2] == [("LOG_OUTPUT", 0, 1), ("LOG_LINK", 0, 1)]
    assert recorder["Count"] == 6
    assert _short(recorder["Fault"]) == ("LOG_LINK", 0, 0)


def test_without_a_link_inputs_are_still_believed_and_outputs_stay_as_they_were(
    recorder: Recorder,
) -> None:
    """What FB_WriteArea takes back is its own doing.

    Source: manual chapter 1, 5: SI(00) and SI(06) are OFF in the error state.
    """
    recorder["Robot.SO.SO00_EmergencyStop"] = True
    recorder["Robot.SI.SI00_EmergencyStop"] = True
    recorder.scan()
    before = recorder["Total"]
    for path in ("Connected", "SO.SO01_CpuOk", "SO.SO00_EmergencyStop", "SI.SI00_EmergencyStop"):
        recorder[f"Robot.{path}"] = False
    recorder.scan(2)
    assert recorder.rows()[:2] == [("LOG_INPUT", 0, 0), ("LOG_LINK", 0, 0)]
    assert recorder["Total"] == before + 2


def test_what_is_on_when_the_link_comes_is_kept_but_is_no_fault() -> None:
    """Before SI(00) is ON the controller stands in emergency stop, and its alarm 12.600 is on.

    Source: manual chapter 5, 3.1
    """
    recorder = Recorder()
    recorder["Robot.Connected"] = True
    recorder["Robot.SO.SO00_EmergencyStop"] = True
    recorder["Robot.SO.SO03_Alarm"] = True
    recorder.scan()
    assert recorder.rows() == [("LOG_OUTPUT", 3, 1), ("LOG_OUTPUT", 0, 1), ("LOG_LINK", 0, 1)]
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"
    recorder["Robot.SO.SO03_Alarm"] = False
    recorder.scan()
    recorder["Robot.SO.SO03_Alarm"] = True
    recorder.scan()
    assert _short(recorder["Fault"]) == ("LOG_OUTPUT", 3, 1)


def test_time_is_counted_in_milliseconds_since_the_first_call(recorder: Recorder) -> None:
    recorder.scan(123)
    assert recorder["Now"] == 1230
    recorder.edges(1)
    assert recorder["Rows"][0]["Moment"] == 1240


# ---- errors of blocks


def test_each_new_error_of_a_block_is_kept_and_is_a_fault(recorder: Recorder) -> None:
    """Source: docs/errors.md."""
    for error in (0x8010, 0x8010, 0, 0, 0x8010, 0x8003, 0):
        recorder["BlockError"] = error
        recorder.scan()
    assert recorder.rows()[:4] == [
        ("LOG_ERROR", 0, 0x8003),
        ("LOG_ERROR", 0, 0x8010),
        ("LOG_ERROR", 0, 0x8010),
        ("LOG_OUTPUT", 1, 1),
    ]
    assert recorder["Fault"]["Moment"] == 10


# ---- the log


def test_the_oldest_entries_make_room_and_a_page_shows_eight(recorder: Recorder) -> None:
    recorder.edges(10)
    assert recorder["Count"] == 12
    recorder.edges(30)
    assert (recorder["Count"], recorder["Total"]) == (32, 42)
    for first, moments in (
        (0, range(400, 320, -10)),
        (8, range(320, 240, -10)),
        (24, range(160, 80, -10)),
    ):
        recorder["First"] = first
        recorder.scan()
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
    ],
)
def test_rows_beyond_the_log_are_empty(recorder: Recorder, first: int, shown: list[int]) -> None:
    recorder.edges(40)
    recorder["First"] = first
    recorder.scan()
    assert [row["Moment"] for row in recorder["Rows"]] == shown
    empty = [row["Kind"] == "LOG_NOTHING" for row in recorder["Rows"]]
    assert empty == [moment == 0 for moment in shown]


def test_a_smaller_log_keeps_fewer_entries() -> None:
    """Source: RCX_LOG: LogSize is the number of its entries."""
    recorder = Recorder()
    recorder["LogSize"] = 3
    recorder["Robot.Connected"] = True
    recorder.scan()
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


def test_while_it_is_frozen_nothing_is_kept_and_nothing_is_made_up_for(
    recorder: Recorder,
) -> None:
    recorder["Freeze"] = True
    recorder.edges(1)
    recorder.command(0x0200)
    recorder["BlockError"] = 0x8010
    recorder.scan()
    assert recorder["Frozen"]
    assert recorder["Total"] == 2
    recorder["Freeze"] = False
    recorder.scan(2)
    assert not recorder["Frozen"]
    assert recorder["Total"] == 2
    recorder.edges(1)
    assert recorder["Total"] == 3


def test_a_fault_is_shown_also_while_the_log_is_frozen(recorder: Recorder) -> None:
    recorder["Freeze"] = True
    recorder["Robot.SO.SO03_Alarm"] = True
    recorder.scan()
    assert _short(recorder["Fault"]) == ("LOG_OUTPUT", 3, 1)


@pytest.mark.parametrize("after", [0, 1, 3])
def test_a_fault_freezes_the_log_once_so_many_more_entries_have_come(
    recorder: Recorder, after: int
) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = after
    recorder["Robot.SO.SO03_Alarm"] = True
    recorder.scan()
    for _ in range(after):
        assert not recorder["Frozen"]
        recorder.edges(1)
    assert recorder["Frozen"]
    recorder.edges(3)
    assert recorder["Frozen"]
    assert recorder["Total"] == 3 + after
    assert recorder.rows()[after] == ("LOG_OUTPUT", 3, 1)


def test_eight_more_entries_are_kept_unless_another_number_is_given(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["BlockError"] = 0x8001
    recorder.scan()
    recorder.edges(20)
    assert recorder["Total"] == 3 + 8


def test_a_second_fault_does_not_move_the_end(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 3
    for error in (0x8001, 0x8002, 0x8003, 0x8004, 0x8005):
        recorder["BlockError"] = error
        recorder.scan()
    assert recorder["Frozen"]
    assert recorder.rows()[0] == ("LOG_ERROR", 0, 0x8004)
    assert _short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8001)


def test_without_the_wish_a_fault_does_not_freeze_the_log(recorder: Recorder) -> None:
    recorder["After"] = 0
    recorder["BlockError"] = 0x8001
    recorder.scan()
    recorder.edges(20)
    assert not recorder["Frozen"]
    assert recorder["Total"] == 23


def test_other_entries_do_not_freeze_the_log(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 0
    recorder.edges(5)
    recorder.command(0x0200)
    assert not recorder["Frozen"]


def test_resume_forgets_the_fault_and_records_again(recorder: Recorder) -> None:
    recorder["FreezeOnFault"] = True
    recorder["After"] = 0
    recorder["Robot.Data"] = [3] * 15
    recorder.command(0x4000)
    assert recorder["Frozen"]
    recorder["Resume"] = True
    recorder.scan()
    assert not recorder["Frozen"]
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"
    assert (recorder["FaultCode"], recorder["FaultData"]) == (0, [0] * 15)
    recorder.edges(1)
    assert recorder["Total"] == 4

    recorder["BlockError"] = 0x8012
    recorder.scan(3)
    assert recorder["Frozen"], "Resume is an edge: it is still TRUE"
    assert _short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8012)


def test_a_fault_in_the_scan_of_resume_is_a_new_one(recorder: Recorder) -> None:
    recorder.command(0x4000, code=0x1001)
    recorder.command(0x0200, code=0x1002)
    recorder["Resume"] = True
    recorder["BlockError"] = 0x8012
    recorder.scan()
    assert _short(recorder["Fault"]) == ("LOG_ERROR", 0, 0x8012)
    assert recorder["FaultCode"] == 0x1002


def test_the_first_fault_stays_until_resume(recorder: Recorder) -> None:
    recorder.command(0x4000, code=0x1001)
    recorder.command(0x4000, code=0x1002)
    assert _short(recorder["Fault"]) == ("LOG_COMMAND", 0x1001, 0x4000)
    assert recorder["FaultCode"] == 0x1001


@pytest.mark.parametrize("block", ["FB_CommandRecorder", "FB_ChannelStatus", "FB_DedicatedBits"])
def test_the_blocks_only_look(block: str) -> None:
    """Source: docs/diagnosis.md."""
    alone = Alone(block, {"Robot": "RCX_REF"})
    alone["Robot.Connected"] = True
    alone["Robot.Phase"] = "PHASE_COMMAND_RUN"
    alone["Robot.Code"] = 0x1001
    alone["Robot.Command.NextTicket"] = 3
    alone["Robot.Command.Alive"] = True
    alone["Robot.Request.SI01_ServoOn"] = True
    before = alone["Robot"]
    alone.scan(0)
    alone.scan(100_000)
    assert alone["Robot"] == before
