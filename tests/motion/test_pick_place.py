"""FB_PickPlace sends its commands in order, and continues after an error."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from pick_bench import PickBench, picking

_PLAIN = ["DO(20) OFF", "PTP 10 at 50", "DO(20) ON", "PTP 20 at 50", "DO(20) OFF"]
_SENSOR: dict[str, Any] = {"Gripper__PartInput": 21}
_SHIFTS: dict[str, Any] = {"Shifts__SourceAbove": 1, "Shifts__Target": 2, "Shifts__TargetAbove": 3}
_APPROACH = [
    *("DO(20) OFF", "shift 1", "PTP 10 at 50", "shift 0", "PTP 10 at 5", "DO(20) ON"),
    *("shift 1", "PTP 10 at 5", "shift 3", "PTP 20 at 50", "shift 2", "PTP 20 at 5", "DO(20) OFF"),
    *("shift 3", "PTP 20 at 5", "shift 0"),
]


def _with_sensor(**pins: Any) -> PickBench:
    """Return a bench with a part sensor: DI(21) is ON while the hand is closed."""
    plc = picking(**_SENSOR, **pins)
    plc.follows = {21: 20}
    return plc


def _approaching(**pins: Any) -> PickBench:
    return picking(**_SHIFTS, Shifts__ApproachSpeed=5.0, **pins)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_part_is_fetched_at_the_source_and_put_down_at_the_target(engine: str) -> None:
    """Source: guide 4.2.1 (PTP), 4.5.1 (bit units)."""
    plc = picking(engine)
    assert plc.end == ("", 0, "PICK_START", False)
    for _ in range(2):
        assert plc.work() == _PLAIN
        assert plc.end == ("Done", 0, "PICK_START", False)
    plc["Pick.Execute"] = False
    plc.scan()
    assert plc.end == ("", 0, "PICK_START", False)


def test_the_stages_of_the_work_are_shown_in_order() -> None:
    """Source: a rule of this library."""
    plc = picking()
    plc.start()
    seen: list[tuple[str, bool]] = []
    while plc["Pick.Busy"]:
        if not seen or seen[-1] != plc.end[2:]:
            seen.append(plc.end[2:])
        plc.scan()
    stages = [f"PICK_{name}" for name in ("EMPTY", "OPEN", "TO_SOURCE", "CLOSE", "TO_TARGET")]
    holding = [("PICK_TO_TARGET", True), ("PICK_STILL", True), ("PICK_RELEASE", True)]
    assert seen == [(stage, False) for stage in stages[:-1]] + holding


def test_between_pallets_it_moves_in_arches() -> None:
    """The robot moves from pallet 1, position 4 to pallet 2, position 6, with axis 3 at 0 between.

    Source: guide 4.2.5, arch designation.
    """
    plc = picking(
        SourcePallet=1,
        SourcePosition=4,
        TargetPallet=2,
        TargetPosition=6,
        ArchAxis=3,
        ArchPosition=-70.0,
        ArchDistance=5000.0,
        RobotNumber=2,
    )
    arch = "at 50 by robot 2, 000100 [-70, 5000, 5000] pulses"
    told = plc.work()
    assert told[1::2] == [f"arch 1/4 {arch}", f"arch 2/6 {arch}"]
    assert plc.end == ("Done", 0, "PICK_START", False)


def test_an_arch_in_mm_is_sent_without_conversion() -> None:
    """Source: guide 4.2.1, arch designation: integers (x1000) in millimetres."""
    plc = picking(ArchAxis=1, ArchUnit="UNIT_MM", ArchPosition=9.5, ArchDistance=20.0, Speed=0.0)
    arch = "000001 [9500, 20000, 20000] mm"
    assert plc.work()[1::2] == [f"arch 10, {arch}", f"arch 20, {arch}"]


def test_the_robot_approaches_from_above_and_leaves_upwards() -> None:
    """The robot moves to a point above source and target before and after each visit.

    The block selects one shift for the place itself, and another for the point above it. The robot
    moves between these two points without an arch.

    Source: guide 4.2.17
    """
    plc = _approaching()
    assert plc.work() == _APPROACH
    assert plc.end == ("Done", 0, "PICK_START", False)
    plc["Pick.ArchAxis"] = 3
    arched = [text for text in plc.work() if text.startswith("arch")]
    assert arched == [f"arch {k} at 50, 000100 [0, 0, 0] pulses" for k in (10, 20)]


def test_without_shifts_no_shift_is_selected_at_the_end() -> None:
    """Source: RCX_PICK_SHIFTS: if the first four are 0, no shift is selected."""
    assert picking(Shifts__Afterwards=7).work() == _PLAIN


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("afterwards", [0, 7])
def test_at_the_end_the_shift_afterwards_is_selected(engine: str, afterwards: int) -> None:
    """At the end, the block selects the shift for later movements of the program.

    Source: guide 4.2.17; field Afterwards of RCX_PICK_SHIFTS
    """
    plc = picking(engine, Shifts__Target=4, Shifts__Afterwards=afterwards)
    plc.start()
    plc.scan_until(lambda: plc.end[2] == "PICK_SHIFT", most=600)
    assert plc.end == ("Busy", 0, "PICK_SHIFT", False)
    plc.scan_until(lambda: not plc["Pick.Busy"], most=60)
    assert plc.end == ("Done", 0, "PICK_START", False)
    assert plc.told[-2:] == ["DO(20) OFF", f"shift {afterwards}"]


@pytest.mark.parametrize("shifts", [{"Shifts__TargetAbove": 3}, {}])
def test_if_only_the_last_shift_failed_no_second_part_is_fetched(shifts: dict[str, Any]) -> None:
    """If only the last shift command failed, the next start selects it and fetches no part.

    HandEmpty and changed shifts have no effect on this.

    Source: head: after an error it continues with what is not finished
    """
    plc = picking(Shifts__Target=4, **shifts)
    plc.until("DO(20) ON")
    plc.refuses = "shift 0"
    plc.scan_until(lambda: not plc["Pick.Busy"], most=600)
    assert plc.end == ("Error", 0x8020, "PICK_SHIFT", False)
    plc["Pick.HandEmpty"] = True
    plc["Pick.Shifts.Target"] = plc["Pick.Shifts.TargetAbove"] = 0
    assert plc.work() == ["shift 0"]
    assert plc.end == ("Done", 0, "PICK_START", False)


def test_after_an_error_the_shift_of_the_movement_stays_selected() -> None:
    """After an error, the shift of the last movement stays selected: no more command is sent.

    Source: head of FB_PickPlace.
    """
    plc = _approaching(Shifts__Afterwards=7)
    plc.refuses = "PTP 10 at 5"
    assert plc.work()[-2:] == ["shift 0", "PTP 10 at 5"]
    plc.scan(50)
    assert plc.told[-1] == "PTP 10 at 5"
    assert plc.work() == [*_APPROACH[:-1], "shift 7"]


def test_the_robot_also_approaches_pallets_from_above() -> None:
    """The robot also approaches work positions of pallets from above.

    Without its own speed, the approach has the speed of the movement. Source: guide 4.2.5,
    4.2.17.
    """
    plc = picking(TargetPallet=0, Shifts__TargetAbove=7)
    target = ["shift 7", "PTP 0/1 at 50", "shift 0", "PTP 0/1 at 50", "DO(20) OFF", "shift 7"]
    target += ["PTP 0/1 at 50", "shift 0"]
    assert plc.work()[4:] == target
    plc["Pick.ArchAxis"] = 3
    arch = "arch 0/1 at 50, 000100 [0, 0, 0] pulses"
    assert plc.work()[5:] == [arch, *target[2:]], (
        "there is no arch between the place and the shift above it"
    )


@pytest.mark.parametrize("shift", ["Source", "Target"])
def test_with_one_shift_a_shift_is_selected_for_both_places(shift: str) -> None:
    """If only one place has a shift, shift 0 is selected for the other place.

    Source: guide 4.2.17.
    """
    place: dict[str, Any] = {f"Shifts__{shift}": 4}
    plc = picking(**place)
    source, target = (4, 0) if shift == "Source" else (0, 4)
    told = plc.work()
    assert told[1:3] == [f"shift {source}", "PTP 10 at 50"]
    assert told[4:6] == [f"shift {target}", "PTP 20 at 50"]


def test_inputs_are_sampled_at_the_rising_edge() -> None:
    """Source: design of the library, 3."""
    plc = _approaching(Gripper__PartInput=21)
    plc.follows = {21: 20}
    plc.start()
    for name in ("SourcePoint", "TargetPoint", "Shifts.SourceAbove", "Shifts.Target"):
        plc[f"Pick.{name}"] = 30
    for name, value in (("Speed", 1.0), ("ArchAxis", 2), ("SourcePallet", 1), ("TargetPallet", 1)):
        plc[f"Pick.{name}"] = value
    plc["Pick.Gripper.CloseOutput"] = 30
    plc["Pick.Gripper.PartInput"] = 0
    plc.scan_until(lambda: not plc["Pick.Busy"], most=600)
    assert [text for text in plc.told if not text.startswith("DI")] == _APPROACH
    assert plc.told.count("DI2?") == 6, "empty, open, closed, lifted, at the target, open"


def test_an_edge_while_the_block_works_samples_no_input() -> None:
    """An edge of Execute while the block works does not sample its inputs.

    The block may also be waiting without a command. Source: design of the library, 3.
    """
    plc = picking(Gripper__Settle="T#1s")
    plc.until("DO(20) ON")
    plc.scan(20)
    assert (plc.end[0], plc["Pick.Active"]) == ("Busy", False)
    plc["Pick.Execute"] = False
    plc.scan()
    plc["Pick.TargetPoint"], plc["Pick.HandEmpty"], plc["Pick.Execute"] = 30, True, True
    plc.scan_until(lambda: not plc["Pick.Busy"], most=600)
    assert plc.told == _PLAIN


def test_without_a_work_position_the_first_one_is_used() -> None:
    """Source: guide 4.2.5: work positions from 1."""
    told = picking(SourcePallet=3, TargetPallet=4).work()
    assert told[1::2] == ["PTP 3/1 at 50", "PTP 4/1 at 50"]


@pytest.mark.parametrize(
    ("broken", "again"),
    [
        ("PTP 10 at 50", _PLAIN),
        ("DO(20) ON", ["DO2?", *_PLAIN]),
        ("PTP 20 at 50", ["DO2?", *_PLAIN[3:]]),
    ],
)
def test_the_next_start_continues_with_the_unfinished_command(
    broken: str, again: list[str]
) -> None:
    """After an error, the next start continues with the command that has not ended.

    Before the close command, it begins with the first movement. If the hand is closed, the block
    opens it only at the target. The outputs that are read from the controller decide.

    Source: a rule of this library; alarm 12.600: guide 1.2; port reference: guide 4.5.1.
    """
    plc = picking()
    plc.refuses = broken
    assert plc.work()[-1] == broken
    stage = plc.end[2]
    assert plc.end[:2] == ("Error", 0x8020)
    assert (plc["Pick.AlarmGroup"], plc["Pick.AlarmCategory"]) == (12, 600)
    plc.scan(50)
    assert plc.told[-1] == broken, "nothing continues by itself"
    assert (plc["Pick.AlarmGroup"], plc["Pick.AlarmCategory"]) == (12, 600), (
        "the error stays until Execute falls"
    )
    assert plc.end[1:3] == (0x8020, stage)
    assert plc.work() == again
    assert plc.end == ("Done", 0, "PICK_START", False)
    assert (plc["Pick.AlarmGroup"], plc["Pick.AlarmCategory"]) == (0, 0)
    assert plc.work() == _PLAIN


def test_an_interrupted_release_is_repeated_at_the_target() -> None:
    """If the release was interrupted, the next start moves to the target and releases again.

    Perhaps the hand has opened already. The part sensor is not read.

    Source: a rule of this library.
    """
    plc = _with_sensor()
    plc.until("PTP 20 at 50")
    plc.silent = "DO(20) OFF"
    plc.scan_until(lambda: plc.told[-1] == "DO(20) OFF")
    plc.outputs(SO01=False)
    plc.scan()
    assert plc.end == ("Error", 0x8002, "PICK_RELEASE", False)
    plc.outputs(SO01=True)
    plc.silent, plc.follows = "", {}
    plc.on = set()
    plc.scan(40)
    assert plc.work() == ["DO2?", "PTP 20 at 50", "DO(20) OFF", "DI2?"]
    assert plc.end == ("Done", 0, "PICK_START", False)
    plc.follows = {21: 20}
    assert plc.work().count("DI2?") == 5, "the next part reads the sensor again, also at the target"


@pytest.mark.parametrize("lost_at", ["PTP 20 at 50", "PTP 20 at 5", "DO(20) OFF"])
def test_an_interrupted_release_is_repeated_from_above(lost_at: str) -> None:
    """Source: a rule of this library."""
    plc = _approaching()
    plc.until("DO(20) ON")
    plc.refuses = "DO(20) OFF"
    plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert plc.end == ("Error", 0x8020, "PICK_RELEASE", True)
    plc.refuses = lost_at
    assert plc.work()[-1] == lost_at
    rest = _APPROACH[_APPROACH.index("shift 3") :]
    assert plc.work() == ["DO2?", *rest]
    assert plc.end == ("Done", 0, "PICK_START", False)


@pytest.mark.parametrize(
    ("count", "again"),
    [
        (4, _APPROACH),
        (7, ["DO2?", *_APPROACH[6:]]),
        (9, ["DO2?", *_APPROACH[8:]]),
        (10, ["DO2?", *_APPROACH[8:]]),
        (14, _APPROACH[13:]),
    ],
)
def test_an_interrupted_approach_is_continued(count: int, again: list[str]) -> None:
    """An interrupted movement to or from a place is continued at the next start.

    With a part in the hand, it is lifted again. After the release, the robot only leaves.

    Source: a rule of this library.
    """
    plc = _approaching()
    plc.start()
    plc.scan_until(lambda: len(plc.told) == count + 1, most=300)
    plc["SafeOk"] = False
    plc.answer(0x4000, [12, 600])
    plc.scan_until(lambda: not plc["Pick.Busy"])
    assert plc.end[:2] == ("Error", 0x8020)
    plc["SafeOk"] = True
    plc.scan(40)
    assert plc.work() == again
    assert plc.end == ("Done", 0, "PICK_START", False)


@pytest.mark.parametrize("broken", ["DO(20) ON", "PTP 20 at 50", "DO(20) OFF"])
def test_if_the_part_was_removed_the_next_start_fetches_another_part(broken: str) -> None:
    """Source: a rule of this library."""
    plc = picking()
    plc.until("PTP 10 at 50")
    plc.refuses = broken
    plc.scan_until(lambda: not plc["Pick.Busy"])
    plc["Pick.HandEmpty"] = True
    assert plc.work() == _PLAIN
    assert plc.end == ("Done", 0, "PICK_START", False)


def test_after_the_release_hand_empty_has_no_effect() -> None:
    """After the release, HandEmpty has no effect: the next start fetches no second part.

    Source: a rule of this library.
    """
    plc = _approaching()
    plc.until("DO(20) ON")
    plc.scan_until(lambda: plc.told[-1] == "DO(20) OFF")
    plc.refuses = "PTP 20 at 5"
    plc.scan_until(lambda: not plc["Pick.Busy"])
    assert plc.end == ("Error", 0x8020, "PICK_LEAVE", False)
    plc["Pick.HandEmpty"] = True
    assert plc.work() == ["shift 3", "PTP 20 at 5", "shift 0"]
    assert plc.end == ("Done", 0, "PICK_START", False)


@pytest.mark.parametrize("out", ["DI2?", "DO(20) OFF", "PTP 10 at 50"])
def test_if_the_servos_turn_off_during_a_command_its_alarm_is_reported(out: str) -> None:
    """If the servos turn OFF during a command, the block waits for its end with an alarm.

    The alarm is more precise than SO(02) OFF.

    Source: guide 1.2; manual chapter 5, 3.1.
    """
    plc = picking(**_SENSOR)
    plc.silent = out
    plc.until(out)
    plc.outputs(SO02=False)
    plc.scan(20)
    assert (plc.end[0], plc["Pick.Active"]) == ("Busy", True)
    plc.answer(0x4000, [12, 600])
    plc.scan_until(lambda: not plc["Pick.Busy"])
    assert (plc.end[:2], plc["Pick.Active"]) == (("Error", 0x8020), False)
    assert (plc["Pick.AlarmGroup"], plc["Pick.AlarmCategory"]) == (12, 600)


@pytest.mark.exhaustive
def test_without_timeout_a_command_may_take_one_minute() -> None:
    """Without a value for Timeout, a command may take one minute (6000 scans of 10 ms).

    Source: design of the library, 2: every wait has a limit.
    """
    plc = picking()
    plc.silent = "PTP 10 at 50"
    plc.until("PTP 10 at 50")
    assert 5990 <= plc.scan_until(lambda: not plc["Pick.Busy"], most=6100) <= 6000
    assert plc.end[:2] == ("Error", 0x8011)


def test_a_movement_longer_than_timeout_ends_the_block() -> None:
    """Source: design of the library, 2: every wait has a limit."""
    plc = picking(Timeout="T#100ms")
    plc.silent = "PTP 20 at 50"
    plc.work()
    assert plc.end == ("Error", 0x8011, "PICK_TO_TARGET", True)


@pytest.mark.parametrize(
    ("stage", "silent"),
    [("OPEN", "DO(20) OFF"), ("EMPTY", "DI2?"), ("TO_SOURCE", "shift 4")],
)
def test_timeout_applies_to_every_command(stage: str, silent: str) -> None:
    """Source: design of the library, 2: every wait has a limit."""
    plc = picking(Timeout="T#100ms", Gripper__PartInput=21, Shifts__Source=4)
    plc.silent = silent
    plc.start()
    assert plc.scan_until(lambda: not plc["Pick.Busy"]) < 40
    assert plc.end[:3] == ("Error", 0x8011, f"PICK_{stage}")


@pytest.mark.parametrize("how", ["skipped", "twice"])
def test_a_missing_or_second_call_ends_the_block(how: str) -> None:
    """Source: docs/explanation/scan-model.md, one scan."""
    plc = picking()
    plc.until("PTP 20 at 50")
    plc["Call" if how == "skipped" else "Twice"] = how != "skipped"
    if how == "skipped":
        plc.scan()
        plc["Call"] = True
    plc.scan()
    assert plc.end[:2] == ("Error", 0x8013 if how == "skipped" else 0x8016)
    plc["Twice"] = False
    plc.scan(20)
    assert plc.work() == ["DO2?", *_PLAIN[3:]]


@pytest.mark.parametrize("how", ["skipped", "twice"])
def test_after_a_missing_or_second_call_no_command_is_sent(how: str) -> None:
    """After a missing or second call between two commands, no command is sent.

    Source: scan-model.md, one scan.
    """
    plc = picking(**_SENSOR)
    plc["Twice"] = how == "twice"
    plc.start()
    if how == "skipped":
        plc["Call"] = False
        plc.scan()
        plc["Call"] = True
        plc.scan()
    plc["Twice"] = False
    assert plc.end == ("Error", 0x8013 if how == "skipped" else 0x8016, "PICK_EMPTY", False)
    plc.scan(20)
    assert plc.told == []


@pytest.mark.parametrize("refused", ["", "PTP 20 at 50"])
def test_if_execute_falls_at_once_the_end_is_shown_for_one_scan(refused: str) -> None:
    """Source: design of the library, 3."""
    plc = picking()
    plc.refuses = refused
    plc.start()
    plc["Pick.Execute"] = False
    plc.scan_until(lambda: plc.told[-1:] == ["PTP 20 at 50"], most=300)
    assert (plc["Pick.Active"], plc["Pick.Holds"]) == (True, True)
    plc.scan_until(lambda: not plc["Pick.Busy"], most=300)
    assert plc.end[0] == ("Error" if refused else "Done")
    plc.scan()
    assert plc.end[0] == ""
