"""Blocks that are called in every scan use a channel in order, whatever other blocks do."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench

#: Scans of 10 ms until the end is read: data, code, end status.
_SENT = 3


def _bench(blocks: str, calls: str) -> PlcBench:
    plc = PlcBench(
        program=f"""PROGRAM Turns
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL := TRUE;
    Good, Retry : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
{blocks}
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
{calls}
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""
    )
    plc.outputs(SO01=True, SO02=True, SO04=True, SO10=True)
    plc.scan_until(lambda: bool(plc["Robot.Settled"]))
    return plc


_POLLING = ("Day", "Hour", "Speeds", "Versions", "Servos", "Torques")
_KINDS = (
    *("ReadDate", "ReadTime", "ReadSpeeds", "ReadVersions", "ReadServoStatus", "ReadTorqueOfMax"),
)


@pytest.fixture
def polling() -> PlcBench:
    """Return a bench with a movement, and six blocks that read repeatedly while Retry is TRUE."""
    pairs = list(zip(_POLLING, _KINDS, strict=True))
    return _bench(
        "    Go : FB_MovePtp;\n" + "".join(f"    {name} : FB_{kind};\n" for name, kind in pairs),
        "  Go(Robot := Robot, Execute := Good, Point := 19);\n"
        + "".join(
            f"  {name}(Robot := Robot, Execute := Retry AND NOT ({name}.Done OR {name}.Error));\n"
            for name in _POLLING
        ),
    )


@pytest.mark.parametrize("lost_scans", [1, 3000])
def test_after_a_lost_link_the_first_command_is_sent_at_once(
    polling: PlcBench, lost_scans: int
) -> None:
    """Source: design of the library, 2: waiting is bounded by what still lives."""
    plc = polling
    plc.change("Good", to=True, scans=4)
    assert plc.words[0] == 0x0001
    plc.change("Retry", to=True, scans=2)
    plc.change("Connected", to=False, scans=lost_scans)
    assert plc["Go.ErrorID"] == 0x8001
    before = plc["Robot.Inner.Command.NextTicket"]
    plc["Connected"] = True
    taken = plc.scan_until(lambda: plc.words[0] != 0, most=30)
    assert taken <= 26 + _SENT, "the interval after the recovery (250 ms), data, code"
    assert plc["Robot.Inner.Command.NextTicket"] - before <= len(_POLLING)


def test_without_a_link_no_ticket_stays_behind(polling: PlcBench) -> None:
    plc = polling
    plc["Connected"] = False
    plc["Retry"] = True
    for _ in range(300):
        plc.scan()
        turns = plc["Robot.Inner.Command"]
        assert isinstance(turns, dict)
        assert (turns["NextTicket"] - turns["Serving"]) % 65536 <= len(_POLLING)


@pytest.fixture
def refusing() -> PlcBench:
    """Return a bench with four blocks that retry an illegal input in every scan.

    A fifth block has a legal input.
    """
    return _bench(
        "".join(f"    Bad{k} : FB_MovePtp;\n" for k in (1, 2, 3, 4)) + "    Best : FB_ReadDate;\n",
        "".join(
            f"  Bad{k}(Robot := Robot, Execute := Retry AND NOT (Bad{k}.Done OR Bad{k}.Error), "
            "Point := -1);\n"
            for k in (1, 2)
        )
        + "  Best(Robot := Robot, Execute := Good AND NOT (Best.Done OR Best.Error), "
        "Timeout := T#2s);\n"
        + "".join(
            f"  Bad{k}(Robot := Robot, Execute := Retry AND NOT (Bad{k}.Done OR Bad{k}.Error), "
            "Point := -1);\n"
            for k in (3, 4)
        ),
    )


def test_a_refused_input_never_touches_the_channel(refusing: PlcBench) -> None:
    """Source: docs/explanation/scan-model.md: without a turn and without a telegram."""
    plc = refusing
    plc["Retry"] = True
    before = plc["Robot.Inner.Command"]
    for _ in range(300):
        plc.scan()
        assert plc["Robot.Inner.Command"] == before
        assert not any(plc[f"Bad{k}.Active"] for k in (1, 2, 3, 4))
    assert plc["Bad1.ErrorID"] in (0x0000, 0x8044)


def test_refused_commands_do_not_delay_a_legal_command(refusing: PlcBench) -> None:
    """Source: guide, chapter 2; docs/explanation/scan-model.md, remote commands."""
    plc = refusing
    plc["Retry"] = plc["Good"] = True
    for _ in range(200):
        taken = plc.scan_until(lambda: plc.words[0] != 0, most=4)
        assert taken <= _SENT
        plc.answer(0x0200, scans=1)
        assert plc.words[0] == 0
        assert plc["Best.Done"] is True
        plc.answer(0x0000)


@pytest.fixture
def queue() -> PlcBench:
    """Return a bench with a long command; four blocks with time-outs and one without wait."""
    return _bench(
        "".join(
            f"    {name} : FB_RemoteCommand;\n"
            for name in ("Go", "Hasty1", "Hasty2", "Hasty3", "Hasty4", "Patient")
        )
        + "    Wait : BOOL;\n",
        "  Go(Robot := Robot, Execute := Good, Code := WORD#16#0001, Timeout := T#50ms);\n"
        + "".join(
            f"  Hasty{k}(Robot := Robot, Execute := Retry AND NOT (Hasty{k}.Done OR "
            f"Hasty{k}.Error), Code := WORD#16#0501, Timeout := T#30ms);\n"
            for k in (1, 2, 3, 4)
        )
        + "  Patient(Robot := Robot, Execute := Wait, Code := WORD#16#0502, Timeout := T#0s);\n",
    )


@pytest.mark.parametrize(("scans", "before"), [(20, 0), (400, 0), (400, 32_700)])
def test_blocks_that_left_the_queue_do_not_delay_the_block_behind_them(
    queue: PlcBench, scans: int, before: int
) -> None:
    """Blocks that have left the queue do not delay the block behind them, even if it was full.

    Source: design of the library, 2: a turn goes to the next job that is still there, at once.
    """
    plc = queue
    plc.change("Good", to=True, scans=10)
    assert plc["Go.ErrorID"] == 0x8011
    plc["Robot.Inner.Command.NextTicket"] = plc["Robot.Inner.Command.NextTicket"] + before
    plc["Robot.Inner.Command.Lowest"] = plc["Robot.Inner.Command.NextTicket"]
    plc["Retry"] = True
    plc.scan(scans // 2)
    plc["Wait"] = True
    plc.scan(scans // 2)
    assert plc["Patient.Busy"] is True
    assert plc["Patient.ErrorID"] == 0
    plc.change("Retry", to=False, scans=5)
    plc.complete()
    assert plc.scan_until(lambda: plc.words[0] != 0, most=4) <= _SENT
    assert plc.words[0] == 0x0502


@pytest.mark.parametrize("patient_first", [True, False])
def test_whoever_waits_longest_is_next_also_among_those_who_give_up(
    queue: PlcBench, patient_first: bool
) -> None:
    plc = queue
    plc.change("Good", to=True, scans=10)
    if patient_first:
        plc.change("Wait", to=True)
    plc.change("Retry", to=True, scans=40)
    plc.change("Wait", to=True)
    plc.complete()
    order: list[int] = []
    for _ in range(5):
        plc.scan_until(lambda: plc.words[0] != 0, most=5)
        order.append(plc.words[0])
        plc.complete()
    assert 0x0502 in order
    assert not patient_first or order[0] == 0x0502


@pytest.fixture
def sequences() -> PlcBench:
    """Return a bench with four program resets and an alarm reset.

    The program resets are retried in every scan.
    """
    return _bench(
        "".join(f"    Reset{k} : FB_ProgramReset;\n" for k in (1, 2, 3, 4))
        + "    Alarm : FB_AlarmReset;\n",
        "".join(
            f"  Reset{k}(Robot := Robot, Execute := Retry AND NOT (Reset{k}.Done OR "
            f"Reset{k}.Error));\n"
            for k in (1, 2, 3, 4)
        )
        + "  Alarm(Robot := Robot, Execute := Good);\n",
    )


@pytest.mark.parametrize("lost_scans", [10, 3000])
def test_after_a_lost_link_the_channel_of_the_dedicated_inputs_is_free_at_once(
    sequences: PlcBench, lost_scans: int
) -> None:
    """Source: manual chapter 1, 5.2; design of the library, 2."""
    plc = sequences
    plc["Retry"] = True
    plc.change("Connected", to=False, scans=lost_scans)
    plc.change("Retry", to=False, scans=2)
    plc["Connected"] = plc["Good"] = True
    plc.outputs(SO03=True)
    plc.scan_until(lambda: "SI16" in plc.inputs, most=4 * 26)


@pytest.mark.parametrize("block", ["Day", "Go"])
def test_a_block_that_is_called_again_in_the_same_scan_ends_with_its_own_error(
    block: str,
) -> None:
    """A second call in a scan ends the block with 16#8016: its time limit would count twice.

    A command that was sent is held to its end.

    Source: docs/explanation/scan-model.md: once in every scan.
    """
    call = {
        "Day": "  Day(Robot := Robot, Execute := Good);\n",
        "Go": "  Go(Robot := Robot, Execute := Good, Point := 19);\n",
    }
    plc = _bench(
        "    Day : FB_ReadDate;\n    Go : FB_MovePtp;\n    Twice : BOOL;\n",
        f"{call[block]}  IF Twice THEN\n  {call[block]}  END_IF;\n",
    )
    plc.change("Good", to=True, scans=3)
    code = plc.words[0]
    assert code != 0
    plc.change("Twice", to=True)
    assert plc[f"{block}.ErrorID"] == 0x8016
    plc.scan(50)
    assert plc.words[0] == code, "the command is held to its end"
    plc["Good"] = plc["Twice"] = False
    plc.answer(0x0200, scans=1)
    plc.answer(0x0000, scans=2)
    plc["Good"] = True
    assert plc.scan_until(lambda: plc.words[0] == code, most=5) <= _SENT


_TWO_ROBOTS = """PROGRAM Both
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Robot, Other : RCX_REF;
    ReadArea, ReadOther : FB_ReadArea;
    WriteArea, WriteOther : FB_WriteArea;
    Own : FB_RemoteCommand;
    OwnOther : FB_RemoteCommand;
    Shared : FB_RemoteCommand;
    Go, GoOther, GoShared, SharedFirst, SharedLast : BOOL;
    Told : WORD;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  ReadOther(Robot := Other, Image := InputArea, m := {m}, Connected := TRUE);
  IF SharedFirst THEN
    Shared(Robot := Robot, Execute := FALSE);
    Told := Told OR Shared.ErrorID;
  END_IF;
  Own(Robot := Robot, Execute := Go, Code := WORD#16#0501);
  OwnOther(Robot := Other, Execute := GoOther, Code := WORD#16#0502);
  IF SharedLast THEN
    Shared(Robot := Robot, Execute := FALSE);
    Told := Told OR Shared.ErrorID;
  END_IF;
  Shared(Robot := Other, Execute := GoShared, Code := WORD#16#0001);
  Told := Told OR Shared.ErrorID;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
  WriteOther(Robot := Other, Image := OutputArea, n := 48, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.mark.parametrize("m", [0, 48])
@pytest.mark.parametrize("place", ["SharedFirst", "SharedLast"])
@pytest.mark.parametrize("ahead", range(4))
def test_an_instance_called_with_two_robots_never_moves_the_wrong_one(
    m: int, place: str, ahead: int
) -> None:
    """An instance that is called with two robots never sends its command to the wrong robot.

    At the other robot, its ticket number may belong to another block. With m = 0, both robots read
    the same answers, and their scans have the same numbers.
    """
    plc = PlcBench(program=_TWO_ROBOTS.format(m=m), size=96, contract=False)
    for area in (0, 48):
        plc.so[area + 32 : area + 34] = bytes([0x12, 0x01])
    plc["ReadArea.Size"] = plc["WriteArea.Size"] = 48
    plc["Shared.Data"] = [0xAAAA] * 15
    plc.scan_until(lambda: bool(plc["Robot.Settled"] and plc["Other.Settled"]))
    plc[place] = True
    plc["GoOther"] = True
    for scan in range(40):
        plc["Go"] = scan >= ahead
        plc.change("GoShared", to=scan >= 2)
        image = plc.image
        assert image[0:2] in (b"\x00\x00", b"\x01\x05"), f"scan {scan}: {image[:4].hex()}"
        if image[0:2] == b"\x01\x05":
            assert image[2:32] == bytes(30), f"scan {scan}: its own data"
    assert plc["Told"] in (0x8013, 0x8016)
    assert plc.image[0:2] == b"\x01\x05", "the robot's own command is out"


def test_data_that_change_in_the_scan_of_the_code_are_sent_before_it() -> None:
    """If data change in the scan of the code, the code waits one scan more.

    Two blocks both assume that they have the channel. Code and data are held for a scan unchanged.

    Source: guide, chapter 2, steps 1 and 2: data, then the code.
    """
    plc = _bench(
        "    Go : FB_RemoteCommand;\n    Code, Other : WORD;\n",
        "  Go(Robot := Robot, Execute := Good, Code := WORD#16#0001);\n"
        "  IF Code <> WORD#16#0000 THEN\n    Robot.Inner.Code := Code;\n"
        "    Robot.Inner.Data[3] := Other;\n  END_IF;\n",
    )
    plc["Good"] = True
    for word, code in ((1, 1), (2, 1), (2, 2), (3, 2)):
        plc["Other"], plc["Code"] = word, code
        plc.scan()
        assert (plc.words[0], plc.words[3]) == (0, word)
    plc.scan()
    assert (plc.words[0], plc.words[3]) == (2, 3)
