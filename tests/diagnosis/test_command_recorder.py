"""FB_CommandRecorder records events and detects faults.

The test writes RCX_REF as FB_ReadArea and FB_WriteArea do in a real program.
"""

from __future__ import annotations

from typing import Any

import pytest

from alone import Alone
from rcx_harness import spec
from recorder_bench import Recorder, connected, short


@pytest.fixture
def recorder() -> Recorder:
    """Return a recorder with a connection and CPU_OK. Its log has two rows: the link and SO(01)."""
    return connected()


# ---- commands


def test_a_command_is_recorded_at_its_end_with_status_and_duration(
    recorder: Recorder,
) -> None:
    """An entry has the command's end time and duration: sent at 20, 30 and 40 ms, ended at 50 ms.

    Source: guide chapter 2.
    """
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
    recorder["Robot.Inner.Code"] = 0x0505
    recorder.change("Robot.Inner.Phase", to="PHASE_COMMAND_DATA", scans=2)
    assert recorder["Code"] == 0
    recorder.change("Robot.Inner.Phase", to="PHASE_COMMAND_RUN")
    assert (recorder["Code"], recorder["Running"]) == (0x0505, 0)
    recorder.scan(4)
    assert (recorder["Code"], recorder["Running"]) == (0x0505, 40)
    assert recorder["Count"] == 2
    recorder.change("Robot.Inner.Phase", to="PHASE_STATUS_RESET")
    assert (recorder["Code"], recorder["Running"]) == (0, 0)
    assert recorder["Rows"][0]["Duration"] == 50


def test_an_abnormal_end_is_a_fault_with_its_alarm_and_the_data_of_the_command(
    recorder: Recorder,
) -> None:
    """An abnormal end is a fault with its alarm (0x0002 and 0x014E are 2.334) and its data.

    Source: guide chapter 1, 1.2, code 0x4000.
    """
    data = [4, 0, 50, 19, *range(11)]
    recorder["Robot.Inner.Data"] = data
    recorder.command(0x4000, Response=[2, 334, *[0] * 13])
    entry = recorder["Rows"][0]
    assert short(entry) == ("LOG_COMMAND", 0x1001, 0x4000)
    assert (entry["Group"], entry["Category"]) == (2, 334)
    assert recorder["Fault"] == entry
    assert (recorder["FaultCode"], recorder["FaultData"]) == (0x1001, data)


def test_only_an_abnormal_end_has_an_alarm(recorder: Recorder) -> None:
    """After a normal end the entry has no alarm, because the words are a response.

    Source: guide chapter 1, 1.2.
    """
    recorder.command(0x0200, Response=[2, 334, *[0] * 13])
    assert (recorder["Rows"][0]["Group"], recorder["Rows"][0]["Category"]) == (0, 0)


@pytest.mark.parametrize(
    ("group", "category", "fault"),
    [(12, 400, False), (12, 401, True), (11, 400, True), (2, 334, True)],
)
def test_every_alarm_except_a_stop_is_a_fault(
    recorder: Recorder, group: int, category: int, fault: bool
) -> None:
    """Alarm 12.400 is not a fault, because a stop input ends a jog with it. Source: guide 4.2.6."""
    recorder.command(0x4000, Response=[group, category, *[0] * 13])
    assert (recorder["Fault"]["Kind"] == "LOG_COMMAND") is fault


def test_the_end_of_a_continuous_output_is_not_a_fault(recorder: Recorder) -> None:
    """A continuous output that ends with status 0x0100 is not a fault. Source: guide 4.7.4."""
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
def test_a_command_without_an_end_status_has_the_error_id_of_its_block(
    recorder: Recorder, change: dict[str, Any], result: int
) -> None:
    """A command that ends without an end status is logged with the ErrorID of its cause.

    Source: docs/reference/errors.md, 16#8014, 16#8002 and 16#8001.
    """
    recorder.command(0x0000, **change)
    ends = [row for row in recorder.rows() if row[0] == "LOG_COMMAND"]
    assert ends == [("LOG_COMMAND", 0x1001, result)]
    first = ("LOG_LINK", 0, 0) if "Connected" in change else ends[0]
    assert short(recorder["Fault"]) == first
    assert recorder["FaultCode"] == 0x1001


def test_a_status_that_is_left_over_does_not_hide_a_lost_link(recorder: Recorder) -> None:
    recorder.command(0x4000, Connected=False, Response=[12, 400, *[0] * 13])
    assert ("LOG_COMMAND", 0x1001, 0x8001) in recorder.rows()


def test_the_words_of_a_command_are_those_it_went_out_with(recorder: Recorder) -> None:
    recorder["Robot.Inner.Data"] = [7] * 15
    recorder.command(0x4000, Inner__Data=[9] * 15)
    assert recorder["FaultData"] == [7] * 15


# ---- tests of dedicated bits and of the link

_BITS = [
    *(("SO", signal) for signal in spec.signals().output),
    *(("SI", signal) for signal in spec.signals().input),
]


@pytest.mark.parametrize(
    ("direction", "signal"), _BITS, ids=lambda part: getattr(part, "short", str(part))
)
def test_each_change_of_a_dedicated_bit_is_recorded_with_its_number(
    recorder: Recorder, direction: str, signal: spec.Signal
) -> None:
    """Each change of a dedicated bit is one entry with the bit's number.

    Source: manual chapter 5, 2.
    """
    kind = {"SO": "LOG_OUTPUT", "SI": "LOG_INPUT"}[direction]
    number = int(signal.short[2:], 16)
    path = f"Robot.{direction}.{signal.name}"
    for other, one in _BITS:
        recorder[f"Robot.{other}.{one.name}"] = one is not signal and one.short != "SO03"
    level = signal.short == "SO01"
    recorder[path] = level
    recorder.change("Robot.SO.SO00_EmergencyStop", to=False)
    before = recorder["Total"]
    for result in (not level, level):
        recorder[path] = result
        recorder.scan(2)
        assert recorder.rows()[0] == (kind, number, int(result))
        fault = recorder["Fault"]["Kind"] != "LOG_NOTHING"
        assert fault is (signal.short in ("SO00", "SO03"))
    assert recorder["Total"] == before + 2
    if signal.short in ("SO00", "SO03"):
        assert short(recorder["Fault"]) == (kind, number, 1)


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


def test_without_a_link_changes_of_outputs_are_not_recorded(
    recorder: Recorder,
) -> None:
    """Without a link, changes of outputs are not recorded.

    Source: manual chapter 1, 5: no communication in the error state.
    """
    recorder["Robot.Connected"] = False
    recorder["Robot.SO.SO01_CpuOk"] = False
    recorder.change("Robot.SI.SI06_Stop", to=True, scans=3)
    assert recorder.rows()[:2] == [("LOG_INPUT", 6, 1), ("LOG_LINK", 0, 0)]
    recorder["Robot.Connected"] = True
    recorder["Robot.SO.SO01_CpuOk"] = True
    recorder.change("Robot.SO.SO00_EmergencyStop", to=True, scans=3)
    assert recorder.rows()[:2] == [("LOG_OUTPUT", 0, 1), ("LOG_LINK", 0, 1)]
    assert recorder["Count"] == 6
    assert short(recorder["Fault"]) == ("LOG_LINK", 0, 0)


def test_without_a_link_changes_of_inputs_are_recorded(
    recorder: Recorder,
) -> None:
    """When the link is lost, FB_WriteArea turns inputs OFF. These changes are recorded.

    Source: manual chapter 1, 5: SI(00) and SI(06) are OFF in the error state.
    """
    recorder["Robot.SO.SO00_EmergencyStop"] = True
    recorder.change("Robot.SI.SI00_EmergencyStop", to=True)
    before = recorder["Total"]
    for path in ("Connected", "SO.SO01_CpuOk", "SO.SO00_EmergencyStop", "SI.SI00_EmergencyStop"):
        recorder[f"Robot.{path}"] = False
    recorder.scan(2)
    assert recorder.rows()[:2] == [("LOG_INPUT", 0, 0), ("LOG_LINK", 0, 0)]
    assert recorder["Total"] == before + 2


def test_outputs_that_are_on_when_the_link_starts_are_no_faults() -> None:
    """Outputs that are ON when the link starts are recorded, but are not faults.

    Until SI(00) is ON, the controller is in emergency stop with alarm 12.600.

    Source: manual chapter 5, 3.1
    """
    recorder = Recorder()
    recorder["Robot.Connected"] = True
    recorder["Robot.SO.SO00_EmergencyStop"] = True
    recorder.change("Robot.SO.SO03_Alarm", to=True)
    assert recorder.rows() == [("LOG_OUTPUT", 3, 1), ("LOG_OUTPUT", 0, 1), ("LOG_LINK", 0, 1)]
    assert recorder["Fault"]["Kind"] == "LOG_NOTHING"
    recorder.change("Robot.SO.SO03_Alarm", to=False)
    recorder.change("Robot.SO.SO03_Alarm", to=True)
    assert short(recorder["Fault"]) == ("LOG_OUTPUT", 3, 1)


def test_time_is_counted_in_milliseconds_since_the_first_call(recorder: Recorder) -> None:
    recorder.scan(123)
    assert recorder["Now"] == 1230
    recorder.edges(1)
    assert recorder["Rows"][0]["Moment"] == 1240


# ---- tests of the errors of blocks


def test_each_new_error_of_a_block_is_kept_and_is_a_fault(recorder: Recorder) -> None:
    """Source: docs/reference/errors.md."""
    for error in (0x8010, 0x8010, 0, 0, 0x8010, 0x8003, 0):
        recorder.change("BlockError", to=error)
    assert recorder.rows()[:4] == [
        ("LOG_ERROR", 0, 0x8003),
        ("LOG_ERROR", 0, 0x8010),
        ("LOG_ERROR", 0, 0x8010),
        ("LOG_OUTPUT", 1, 1),
    ]
    assert recorder["Fault"]["Moment"] == 10


@pytest.mark.parametrize("block", ["FB_CommandRecorder", "FB_ChannelStatus", "FB_DedicatedBits"])
def test_the_blocks_change_nothing_in_the_controllers_data(block: str) -> None:
    """Source: docs/how-to/diagnosis.md."""
    alone = Alone(block, {"Robot": "RCX_REF"})
    alone["Robot.Connected"] = True
    alone["Robot.Inner.Phase"] = "PHASE_COMMAND_RUN"
    alone["Robot.Inner.Code"] = 0x1001
    alone["Robot.Inner.Command.NextTicket"] = 3
    alone["Robot.Inner.Request"] = 0x0002
    alone.scan(0)
    before = alone["Robot"]
    alone.scan(100_000)
    assert isinstance(before, dict)
    before["Inner"]["Scan"] += 1  # the block may change the scan number, but nothing else
    assert alone["Robot"] == before
