"""A second call of FB_ReadArea or FB_WriteArea in a scan is harmless and is reported.

FB_ReadAreaWords and FB_WriteAreaWords behave alike. FB_RcxTakeHead and FB_RcxDedicatedInputs detect
the second call.
"""

from __future__ import annotations

from itertools import pairwise

import pytest

from plc_bench import PlcBench

_INTERVAL_SCANS = 12


def _bench(
    twin: str, *, other: bool = False, m: int = 0, n: int = 0, contract: bool = True
) -> PlcBench:
    """Return a bench that can call the area blocks twice per scan.

    If `other` is TRUE, a second instance makes the second call.
    """
    image = "RCX_IMAGE_WORDS" if twin else "RCX_IMAGE"
    copied = "" if not twin else _COPY
    read, write = ("ReadOther", "WriteOther") if other else ("ReadArea", "WriteArea")
    plc = PlcBench(
        program=f"""PROGRAM Twice
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Taken, Given : {image};
    Connected, ConnectedAgain, Okay, Read : BOOL := TRUE;
    EmergencyStopOkAgain, StopOkAgain : BOOL := TRUE;
    ReadTwice, WriteTwice, NoWrite : BOOL;
    Robot : RCX_REF;
    ReadArea, ReadOther : FB_ReadArea{twin};
    WriteArea, WriteOther : FB_WriteArea{twin};
    First : FB_RemoteCommand;
    ServoOn : FB_ServoOn;
    Request : WORD;
    k : INT;
  END_VAR
  {copied.partition("---")[0] or "Taken := InputArea;"}
  IF Read THEN
    ReadArea(Robot := Robot, Image := Taken, Connected := Connected);
  END_IF;
  IF ReadTwice THEN
    {read}(Robot := Robot, Image := Taken, m := {m}, Connected := ConnectedAgain);
  END_IF;
  First(Robot := Robot);
  ServoOn(Robot := Robot);
  Robot.Inner.Request := Robot.Inner.Request OR Request;
  IF NOT NoWrite THEN
    WriteArea(Robot := Robot, Image := Given, Margin := T#20ms,
              EmergencyStopOk := Okay, StopOk := Okay);
  END_IF;
  IF WriteTwice THEN
    {write}(Robot := Robot, Image := Given, n := {n}, Margin := T#20ms,
              EmergencyStopOk := EmergencyStopOkAgain, StopOk := StopOkAgain);
  END_IF;
  {copied.partition("---")[2] or "OutputArea := Given;"}
END_PROGRAM
""",
        contract=contract,
    )
    plc.outputs(SO01=True, SO04=True, SO10=True)
    plc.scan_until(lambda: bool(plc["Robot.Settled"]))
    plc["First.Code"] = 0x0001
    return plc


_COPY = """k := 0;
  WHILE k <= 255 DO
    Taken[k] := FC_RcxWord(LowByte := InputArea[2 * k], HighByte := InputArea[2 * k + 1]);
    k := k + 1;
  END_WHILE;
---k := 0;
  WHILE k <= 255 DO
    OutputArea[2 * k] := WORD_TO_BYTE(Given[k] AND WORD#16#00FF);
    OutputArea[2 * k + 1] := WORD_TO_BYTE(SHR(Given[k], 8));
    k := k + 1;
  END_WHILE;"""

_TWINS = pytest.mark.parametrize("twin", ["", "Words"])
_OTHER = pytest.mark.parametrize("other", [False, True])


@_TWINS
@_OTHER
def test_reading_the_area_twice_does_not_change_a_timeout(twin: str, other: bool) -> None:
    """If the area is read twice per scan, Timeout (5 s) still ends after 500 scans of 10 ms.

    Source: pin Timeout of every block.
    """
    plc = _bench(twin, other=other)
    plc["ReadTwice"] = plc["First.Execute"] = True
    taken = plc.scan_until(lambda: bool(plc["First.Error"]), most=600)
    assert (taken, plc["First.ErrorID"]) == (501, 0x8011)


@_TWINS
@_OTHER
def test_a_second_read_call_is_reported_and_the_data_of_the_first_stay(
    twin: str, other: bool
) -> None:
    """If the area is read a second time in a scan, the data of the first call remain valid.

    The second call may read the area of another controller. Its answers must not be used.
    """
    plc = _bench(twin, other=other, m=48 if other else 0)
    read = "ReadOther" if other else "ReadArea"
    before = plc["Robot.SO"]
    plc["ReadTwice"] = True
    plc["First.Execute"] = True
    for _ in range(30):
        plc.scan()
        assert (plc[f"{read}.Error"], plc[f"{read}.ErrorID"]) == (True, 0x8037)
        assert plc["Robot.Connected"] is True
        assert plc["Robot.SO"] == before
    assert plc.words[0] == 0x0001
    plc.change("ReadTwice", to=False)
    assert (plc["ReadArea.Error"], plc["ReadArea.ErrorID"]) == (False, 0)


@_TWINS
def test_an_illegal_offset_is_reported_before_the_second_read_call(twin: str) -> None:
    """If an area with an illegal offset is read twice, the error is 16#8031 (illegal offset).

    The user must correct the offset first. An area that cannot be read counts as not connected.

    Source: docs/reference/errors.md.
    """
    plc = _bench(twin, m=-1)
    plc.change("ReadTwice", to=True)
    assert (plc["ReadArea.Error"], plc["ReadArea.ErrorID"]) == (True, 0x8031)
    assert plc["Robot.Connected"] is False


@_TWINS
def test_a_second_read_call_without_connection_counts_as_a_lost_connection(twin: str) -> None:
    """If one of the two calls in a scan has Connected FALSE, the connection counts as lost.

    Source: manual chapter 1, 5.2.
    """
    plc = _bench(twin)
    plc["ReadTwice"], plc["ConnectedAgain"] = True, False
    plc.scan()
    assert plc["Robot.Connected"] is False
    assert plc.inputs == []


@_TWINS
def test_a_second_read_call_without_link_is_not_counted_as_a_scan(twin: str) -> None:
    """If the second call in a scan has no link, the call does not count as a new scan.

    The blocks therefore report a lost connection and not a missing call.

    Source: docs/reference/errors.md, 16#8001 and 16#8013.
    """
    plc = _bench(twin)
    plc.change("First.Execute", to=True, scans=2)
    plc["ReadTwice"], plc["ConnectedAgain"] = True, False
    plc.scan()
    assert plc["First.ErrorID"] == 0x8001


@_TWINS
@_OTHER
def test_writing_twice_never_sends_data_and_code_in_one_scan(twin: str, other: bool) -> None:
    """Source: guide, chapter 2: the data before the command."""
    plc = _bench(twin, other=other)
    plc["First.Data"] = [0x1234] * 15
    plc.change("WriteTwice", "First.Execute", to=True)
    assert plc.words == [0x0000] + [0x1234] * 15
    plc.scan()
    assert plc.words == [0x0001] + [0x1234] * 15
    write = "WriteOther" if other else "WriteArea"
    assert (plc[f"{write}.Error"], plc[f"{write}.ErrorID"]) == (True, 0x8037)


@_TWINS
@_OTHER
def test_writing_twice_keeps_the_interval_between_dedicated_inputs(twin: str, other: bool) -> None:
    """Source: manual chapter 5, 3, caution."""
    plc = _bench(twin, other=other)
    plc["WriteTwice"] = plc["ServoOn.Execute"] = True
    changes: list[int] = []
    before = plc.image[32:34]
    for scan in range(200):
        plc.outputs(SO02="SI01" in plc.inputs or bool(plc["ServoOn.Done"]), scans=1)
        if plc.image[32:34] != before:
            changes.append(scan)
        before = plc.image[32:34]
    assert len(changes) == 2, "SI(01) ON and OFF"
    assert changes[1] - changes[0] >= _INTERVAL_SCANS
    assert plc["ServoOn.Done"] is True


@_TWINS
def test_a_second_write_call_turns_the_safety_inputs_off(twin: str) -> None:
    """If the second call of FB_WriteArea has its safety pins FALSE, SI(00) and SI(06) go OFF.

    They go OFF in the same scan and stay OFF until a block releases them.

    Source: manual chapter 5, 2, SI(00) and SI(06): OFF stops.
    """
    plc = _bench(twin)
    assert plc.inputs == ["SI00", "SI06"]
    plc["WriteTwice"] = True
    plc.change("EmergencyStopOkAgain", "StopOkAgain", to=False)
    assert plc.inputs == []
    plc.change("WriteTwice", to=False, scans=100)
    assert plc.inputs == []
    assert (plc["Robot.Inner.HoldEmergency"], plc["Robot.Inner.HoldStop"]) == (True, True)


@_TWINS
@_OTHER
@pytest.mark.parametrize(
    ("pin", "stays", "held"),
    [("EmergencyStopOk", "SI06", "HoldEmergency"), ("StopOk", "SI00", "HoldStop")],
)
def test_each_safety_pin_of_a_second_write_call_turns_its_input_off(
    twin: str, other: bool, pin: str, stays: str, held: str
) -> None:
    """Source: manual chapter 5, 2, SI(00), SI(06) and SI(17)."""
    plc = _bench(twin, other=other, n=48)
    plc["WriteArea.n"] = plc.n = 48
    plc.scan_until(lambda: plc.inputs == ["SI00", "SI06"])
    plc["WriteTwice"], plc[f"{pin}Again"] = True, False
    plc["Robot.Inner.Applied"] = 0x8041
    plc.change("Request", to=0x8000)
    assert plc.inputs == sorted([stays, "SI17"])
    plc["WriteTwice"], plc["Request"] = False, 0
    plc.scan()
    assert [name for name in ("HoldEmergency", "HoldStop") if plc[f"Robot.Inner.{name}"]] == [held]


@_TWINS
def test_a_second_area_with_the_same_rcx_ref_gets_no_command(twin: str) -> None:
    """If two robots share one RCX_REF by mistake, the second one is not driven.

    Source: manual chapter 1, 4: an area for each controller.
    """
    plc = _bench(twin, other=True, n=48)
    plc["WriteTwice"] = plc["First.Execute"] = True
    plc.change("First.Data", to=[0x1234] * 15, scans=30)
    assert plc.words[0] == 0x0001
    assert plc.image[48:] == bytes(512 - 48)


@_TWINS
def test_without_reading_only_the_safety_inputs_can_be_taken_away(twin: str) -> None:
    plc = _bench(twin, contract=False)
    plc["Read"] = False
    plc.change("First.Execute", to=True, scans=5)
    assert plc["WriteArea.ErrorID"] == 0x8037
    assert (plc.words[0], plc.inputs) == (0, ["SI00", "SI06"])
    assert plc["First.ErrorID"] == 0x8017, "and the second area has no scan of a block"
    plc.change("Okay", to=False)
    assert plc.inputs == []


@_TWINS
def test_without_writing_the_blocks_end_and_reading_says_why(twin: str) -> None:
    plc = _bench(twin)
    plc.change("First.Execute", to=True)
    plc.change("NoWrite", to=True, scans=2)
    assert plc["ReadArea.ErrorID"] == 0x8037
    assert plc["First.ErrorID"] == 0x8016


def test_two_writing_instances_in_turn_keep_the_interval() -> None:
    """If two instances write in turn, each one waits for the interval before its first change.

    An instance cannot measure the time since a change that the other instance has made.

    Source: chapter 5, 3, caution.
    """
    plc = _bench("", other=True)
    changes: list[tuple[int, bytes]] = []
    before = plc.image[32:34]
    for scan in range(240):
        # the writing instance changes every 7 scans, the request for servo on every 20 scans
        plc["NoWrite"] = plc["WriteTwice"] = (scan // 7) % 2 == 1
        plc.change("ServoOn.Execute", to=scan % 40 < 20)
        if plc.image[32:34] != before:
            changes.append((scan, plc.image[32:34]))
        before = plc.image[32:34]
    assert all(b[0] - a[0] >= _INTERVAL_SCANS for a, b in pairwise(changes))


@pytest.mark.parametrize(
    ("interval", "margin", "scans"),
    [
        ("T#100ms", "T#-50ms", 10),
        ("T#-1s", "T#-1s", 10),
        ("T#0s", "T#0s", 10),
        ("T#200ms", "T#-150ms", 20),
        ("T#-1s", "T#40ms", 14),
        ("T#100ms", "T#20ms", 12),
    ],
)
def test_a_margin_never_shortens_the_interval(interval: str, margin: str, scans: int) -> None:
    """A negative Margin never shortens the interval, which is at least 100 ms.

    SI(00) turns ON after interval and margin, and SI(06) after the same time again.

    Source: manual chapter 5, 3, caution: 100 ms or more.
    """
    plc = PlcBench(margin=None)
    plc["WriteArea.Interval"], plc["WriteArea.Margin"] = interval, margin
    found: list[int] = []
    for scan in range(60):
        before = plc.image[32:34]
        plc.scan()
        if plc.image[32:34] != before:
            found.append(scan)
    assert found == [scans, 2 * scans]


@pytest.mark.parametrize(
    ("block", "bit"),
    [("AutoStart", "SI12"), ("ServoOn", "SI01"), ("OriginIncr", "SI14"), ("OriginAbs", "SI17")],
)
@pytest.mark.parametrize("pin", ["EmergencyStopOk", "StopOk"])
@pytest.mark.parametrize(
    "released",
    [
        *(8, 10, 12, 24),
        *(pytest.param(scans, marks=pytest.mark.exhaustive) for scans in (9, 11, 13, 20, 23, 25)),
    ],
)
def test_no_start_input_goes_on_while_a_stop_is_requested(
    block: str, bit: str, pin: str, released: int
) -> None:
    """If a stop is requested, no start input goes ON; SI(01) does not depend on the stop.

    The stop is requested for 2 scans, released for some scans, and requested again.

    Source: manual chapter 5, 2, SI(01), and chapter 5, 3.2: no start with SI(00) or SI(06) OFF.
    """
    request = {"SI01": 0x0002, "SI12": 0x0400, "SI14": 0x1000, "SI17": 0x8000}[bit]
    plc = _started()
    levels = {"SI00"} if bit == "SI01" else {"SI00", "SI06"}
    for count, on in ((2, False), (released, True), (40, False)):
        plc[pin] = on
        for _ in range(count):
            before = plc.inputs
            plc.change("Request", to=request)
            if bit in plc.inputs and bit not in before:
                assert levels <= set(plc.inputs), plc.inputs


def _started() -> PlcBench:
    plc = PlcBench(contract=False)
    plc.power_up()
    plc.scan(20)
    return plc


def test_an_automatic_start_is_not_sent_in_the_scan_in_which_the_stop_comes() -> None:
    """Source: manual chapter 5, 3.2: it cannot be executed with the stop input OFF."""
    for released in range(8, 26):
        plc = _started()
        plc["AutoStart.Execute"] = True
        for count, on in ((2, False), (released, True), (30, False)):
            plc["StopOk"] = on
            for _ in range(count):
                before = plc.inputs
                plc.scan()
                if "SI12" in plc.inputs and "SI12" not in before:
                    assert on, released
                    assert "SI06" in plc.inputs, released
