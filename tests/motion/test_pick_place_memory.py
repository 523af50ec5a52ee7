"""FB_PickPlace remembers what it has sent, so that no part is dropped, doubled or missing."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from part_bench import AWAY, SOURCE, TARGET, PartBench

_PLAIN = ["DO(20) OFF", "move 10", "DO(20) ON", "move 20", "DO(20) OFF"]
_CALLS = {"no call": ("Call", False), "called twice": ("Twice", True), "early": ("Early", True)}
#: Maps commands of another block to the meaning of their data (guide 4.2.1, 4.2.17, 4.5.1, 4.7.4).
_OTHERS: dict[str, tuple[int, ...]] = {
    "moves": (0x001, 0, 0, 0, AWAY),
    "selects a shift": (0x03B, 0, 1),
    "opens": (0x301, 0, 0x1020, 0),
    "clears the port": (0x300, 0, 0x1020, 0),
    "reads": (0x506,),
    "switches a lamp": (0x301, 0, 0x1034, 1),
    "moves robot 2": (0x2001, 0, 0, 0, AWAY),
}
_ENDS = ("refused", "lost", "lost-done")
_DISTURBANCES = [
    *_CALLS,
    *("no call, refused", *_ENDS, "time-out", "power cycle", "link loss", "emergency stop"),
    *("Execute again", *_OTHERS),
]


def _begun(place: int, what: str = "", engine: str = "builtin", **kind: Any) -> PartBench:
    """Return a bench that was disturbed by `what` at command number `place` (from 0)."""
    bench = PartBench(engine, **kind)
    bench["Pick.Execute"] = True
    bench.scan()
    bench.until(lambda: bench.sent == place + 1)
    if what in _CALLS or what == "no call, refused":
        pin, value = _CALLS.get(what, _CALLS["no call"])
        bench.fault = "refused" if what not in _CALLS else ""
        bench[pin] = value
        bench.scan(1 if what in _CALLS else 8)
        bench[pin] = not value
    elif what in _ENDS:
        bench.fault = what
    elif what == "time-out":
        bench.fault = "late"
        bench.scan(30)
        bench.fault = ""
    elif what == "power cycle":
        bench.power_cycle()
    elif what == "link loss":
        bench.link_loss()
    elif what == "emergency stop":
        bench.plc.outputs(SO00=True)
        bench.scan()
        bench.plc.outputs(SO00=False)
    elif what == "Execute again":
        for value in (False, True):
            bench["Pick.Execute"] = value
            bench.scan()
    elif what in _OTHERS:
        bench.foreign = what in ("opens", "clears the port")
        bench.send(*_OTHERS[what])
    bench.until(lambda: not bench["Pick.Busy"])
    bench.until(lambda: not bench.plc.words[0])
    return bench


def _judge(place: int, what: str, after: str, **kind: Any) -> None:
    """Start the block until it is Done, and check that no part was dropped, doubled or missing."""
    bench = _begun(place, what, **kind)
    done = int(bench["Pick.Done"])
    assert bench.delivered >= done, "Done without a delivered part"
    if done:
        return
    if "moved" in after:
        bench.moved_by_hand()
    if "power" in after:
        bench.power_cycle()
        assert not bench["Pick.Holds"] or kind["outputs"] == 2
    found: list[str] = []
    while not found or found[-1] != "Done":
        found.append(bench.work())
        if found[-1] in ("805B", "805E"):
            bench.taken_out()
            found.append(bench.work(HandEmpty=True))
            bench["Pick.HandEmpty"] = False
        assert len(found) < 6, f"it does not come to its end: {found}, {bench.told}"
    told = any(error in found for error in ("8059", "805B", "805E"))
    assert 1 <= bench.delivered <= (2 if told else 1), f"{found}, {bench.told}"


@pytest.mark.exhaustive(
    but=["called twice", "early", "refused", "lost-done", "time-out", "power cycle", "link loss"]
)
@pytest.mark.parametrize("what", _DISTURBANCES)
def test_each_disturbance_at_each_command_neither_drops_nor_doubles_a_part(what: str) -> None:
    """The hand opens only at the target, and Done means a delivered part.

    A second part is fetched only after an error for which a person must look for the part.

    Source: head of FB_PickPlace, order of the commands
    """
    for place in range(len(_PLAIN)):
        _judge(place, what, "moved", outputs=1, sensor=False)
    for place in (3, 4):  # the opening output goes OFF, then the closing output goes ON
        _judge(place, what, "moved, power", outputs=2, sensor=False)
    _judge(4, what, "power", outputs=1, sensor=True)


@pytest.mark.parametrize("how", _CALLS)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_close_command_is_remembered_if_the_next_call_is_missing(engine: str, how: str) -> None:
    """If a call is missing after the close command, the block still carries the part to the target.

    In the meantime, the robot was moved to another place.

    Source: docs/explanation/scan-model.md, one scan; guide 4.5.1, I/O port reference
    """
    bench = _begun(2, how, engine)
    assert bench.held
    bench.moved_by_hand()
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", "DO(20) ON", "move 20", "DO(20) OFF"]
    assert bench.delivered == 1


@pytest.mark.parametrize("how", _CALLS)
def test_a_release_is_remembered_if_the_next_call_is_missing(how: str) -> None:
    """If a call is missing after the release command, no second part is brought to the target.

    This holds even if a sensor reports an empty hand.

    Source: head of FB_PickPlace
    """
    for sensor in (False, True):
        bench = _begun(4, how, sensor=sensor)
        assert bench.delivered == 1
        assert bench.work() == "Done"
        assert bench.told.count("move 10") == bench.delivered == 1


def test_a_hand_that_was_emptied_counts_as_empty_in_the_next_start_as_well() -> None:
    """The operator takes the part out, and the first command of the new start is refused.

    The start after it does not read the outputs of the hand, because no part can be in the hand.

    Source: head of FB_RcxPickStages
    """
    bench = _begun(3, "refused")
    assert bench.held
    bench.taken_out()
    bench.fault = "refused"
    assert bench.work(HandEmpty=True) != "Done"
    bench["Pick.HandEmpty"] = False
    bench.fault = ""
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == _PLAIN


@pytest.mark.parametrize("engine", ENGINES)
def test_after_a_refused_close_the_hand_counts_as_open(engine: str) -> None:
    """After a refused close command, the robot returns to the source and closes the hand there.

    Source: guide 1.2, abnormal end; 4.5.1
    """
    bench = _begun(2, "refused", engine)
    assert bench.end == ("Error", 0x8020, False)
    bench.moved_by_hand()
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", *_PLAIN]
    assert bench.delivered == 1


def test_a_power_cycle_opens_a_hand_of_one_output() -> None:
    """After a power cycle, a hand with one output is open and the part has fallen.

    Holds is FALSE, and the next start fetches another part.

    Source: docs/explanation/fidelity.md: outputs are OFF after power-on
    """
    bench = _begun(3, "power cycle")
    assert bench.end == ("Error", 0x8001, False)
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", *_PLAIN]


def test_a_power_cycle_after_the_error_is_reported_at_the_next_start() -> None:
    """If the power is cycled after an error, the next start reports that the part is lost.

    A person must look for the part first.

    Source: errors.md, 16#8059.
    """
    bench = _begun(3, "refused")
    assert bench.end == ("Error", 0x8020, True)
    bench.power_cycle()
    assert not bench["Pick.Holds"]
    assert bench.work() == "8059"
    assert bench.work() == "Done"


def test_a_power_cycle_at_the_target_releases_the_part_there() -> None:
    """If the power is cycled at the target, the part is released there, and no second part follows.

    Source: fidelity.md: outputs are OFF after power-on.
    """
    bench = PartBench()
    bench["Pick.Gripper.PartInput"] = 30
    bench["Pick.Execute"] = True
    bench.until(lambda: bench["Pick.Stage"] == "PICK_STILL")
    bench.power_cycle()
    assert (bench["Pick.ErrorID"], bench.delivered) == (0x8001, 1)
    assert bench.work() == "Done"
    assert (bench.told.count("move 10"), bench.delivered) == (1, 1)


def test_a_power_cycle_does_not_move_a_hand_with_two_outputs() -> None:
    """Source: RCX_GRIPPER: OpenOutput is ON while it is open."""
    bench = _begun(5, "power cycle", outputs=2)
    assert (bench["Pick.Holds"], bench.held) == (True, True)
    assert bench.work() == "Done"
    assert bench.delivered == 1


def test_a_lost_link_with_a_part_in_the_hand_is_not_a_power_cycle() -> None:
    """A lost link does not mean that the power was cycled. The outputs are read afterwards.

    Source: guide 4.5.1.
    """
    bench = _begun(3, "link loss")
    assert bench.end == ("Error", 0x8001, False)
    assert bench.work() == "Done"
    assert bench.told.count("move 10") == bench.delivered == 1


def test_a_power_cycle_without_a_call_of_the_block_is_detected_later() -> None:
    """A power cycle is detected even if the block was not called at that time.

    Some programs call the block in certain states only. Source: RCX_ARBITRATION, Losses.
    """
    bench = _begun(4, "no call, refused")
    bench.moved_by_hand()
    bench["Call"] = False
    bench.power_cycle()
    bench["Call"] = True
    assert bench.work() == "805E", "the part was released, or has fallen elsewhere"
    assert bench.work(HandEmpty=True) == "Done"


def test_an_unknown_state_of_the_hand_stays_an_error_until_hand_empty() -> None:
    """If the state of the hand is unknown, each start ends in 16#805E until HandEmpty.

    Both outputs are OFF, and the close command had no end. With a part sensor, HandEmpty is not
    needed.

    Source: head of FB_PickPlace, 16#805E
    """
    bench = _begun(4, "power cycle", outputs=2)
    for _ in range(2):
        assert bench.work() == "805E"
    assert bench.place == SOURCE, "nothing moves"
    bench.taken_out()
    assert bench.work(HandEmpty=True) == "Done"
    bench = _begun(4, "power cycle", outputs=2, sensor=True)
    assert bench.work() in ("Done", "8058")


def test_a_hand_that_closes_late_has_an_unknown_state() -> None:
    """If the hand closes only after the robot was moved away, the next start reports an error.

    It is unknown whether the hand holds the part.

    Source: docs/reference/errors.md, 16#805A
    """
    bench = PartBench()
    bench["Pick.Gripper.ClosedInput"] = 43
    bench.fingers = False
    assert bench.work() == "805A"
    bench.moved_by_hand()
    bench.fingers = True
    assert bench.work() == "805E"


def test_after_an_undetected_refused_release_the_part_is_released_at_the_target() -> None:
    """If a refused release was not detected, the next start releases the part at the target.

    Source: head of FB_PickPlace.
    """
    bench = _begun(4, "no call, refused")
    assert bench.held
    bench.moved_by_hand()
    assert bench.work() == "Done"
    assert (bench.place, bench.delivered) == (TARGET, 1)


def test_a_power_cycle_that_begins_in_a_scan_without_a_call_is_reported_later() -> None:
    """If the power is cycled during missing calls, the lost part is reported at a later start.

    The missing calls end the block with 16#8013.

    The part has fallen at the place where the robot was.

    Source: docs/reference/errors.md, 16#8013 and 16#8059
    """
    bench = PartBench()
    bench["Pick.Execute"] = True
    bench.until(lambda: bench.sent == 4)
    bench["Call"] = bench["Connected"] = False
    bench.scan()
    bench["Call"] = True
    bench.scan()
    assert bench.end == ("Error", 0x8013, False)
    bench.power_cycle()
    bench.moved_by_hand()
    assert bench.work() == "8059"
    assert (bench.work(), bench.delivered) == ("Done", 1)


def test_a_power_cycle_after_an_error_at_the_target_delivers_no_part() -> None:
    """If the power is cycled after an error at the target, the part is not assumed to be there.

    The robot may have been moved after the error.

    Source: head of FB_RcxPickMemory; errors.md.
    """
    bench = PartBench()
    bench["Pick.Gripper.PartInput"] = 30
    bench["Pick.Execute"] = True
    bench.until(lambda: bench["Pick.Stage"] == "PICK_STILL")
    bench.fault = "refused"
    bench.ends()
    assert (bench.end, bench["Pick.Stage"]) == (("Error", 0x8020, True), "PICK_STILL")
    bench.moved_by_hand()
    bench.power_cycle()
    assert bench.work() == "8059"
    assert bench.delivered == 0


@pytest.mark.parametrize("place", [3, 4])
def test_with_two_outputs_a_hand_that_stayed_open_fetches_its_part_again(place: int) -> None:
    """If a hand with two outputs did not close, the next start fetches the part at the source.

    The close command was refused at the first or at the second output.

    Source: guide 4.5.1.
    """
    bench = _begun(place, "refused", outputs=2)
    assert bench.end == ("Error", 0x8020, False)
    before = len(bench.told)
    bench.moved_by_hand()
    assert bench.work() == "Done"
    assert bench.told[before:][:3] == ["read DO2", "read DO2", "DO(20) OFF"]
    assert (bench.told.count("move 10"), bench.delivered) == (2, 1)


def test_with_two_outputs_a_closed_hand_continues_with_its_part() -> None:
    """Source: head of FB_PickPlace: if they close it, the block continues the movement."""
    bench = _begun(5, "refused", outputs=2)
    bench.moved_by_hand()
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", "read DO2", "move 20", "DO(20) OFF", "DO(21) ON"]


@pytest.mark.parametrize("power", [False, True])
def test_if_the_hand_closed_late_a_sensor_shows_whether_it_has_a_part(power: bool) -> None:
    """If the hand closed late, only a part sensor shows whether it holds a part.

    If both outputs are OFF afterwards, the hand does not move.

    Source: docs/reference/errors.md, 16#805A and 16#805E: or wire PartInput
    """
    bench = PartBench(outputs=2, sensor=True)
    bench["Pick.Gripper.ClosedInput"] = 43
    bench.fingers = False
    assert bench.work() == "805A"
    bench.fingers = True
    if power:
        bench.power_cycle()
    assert bench.held
    assert (bench.work(), bench.delivered) == ("Done", 1)


@pytest.mark.parametrize("sensor", [False, True])
def test_a_hand_closed_by_another_block_after_a_refused_release(sensor: bool) -> None:
    """If another block closes the hand after a refused release, 16#805E is reported.

    With a part sensor, the block continues.

    Source: docs/reference/errors.md, 16#805E
    """
    bench = _begun(4, "refused", sensor=sensor)
    bench.send(0x301, 0, 0x1020, 1)
    bench.until(lambda: bench.told[-1] == "DO(20) ON")
    bench.scan(5)
    assert bench.work() == ("Done" if sensor else "805E")
    assert bench.delivered == sensor


@pytest.mark.parametrize("outputs", [1, 2])
def test_after_a_release_and_a_lost_link_an_open_hand_has_released_its_part(outputs: int) -> None:
    """After a release and a lost link, an open hand with two outputs has released its part.

    A hand with one output also opens without power, perhaps at another place.

    Source: head of FB_RcxPickMemory: without power one output opens the hand
    """
    bench = _begun(4 if outputs == 1 else 7, "lost-done", outputs=outputs)
    assert bench.delivered == 1
    bench.link_loss()
    assert bench.work() == ("805E" if outputs == 1 else "Done")
    assert bench.delivered == 1


@pytest.mark.parametrize("wrong", [0, 28])
def test_a_refused_start_still_detects_a_switch_of_the_hand_by_another_block(wrong: int) -> None:
    """A refused start still detects that another block opens and closes the hand.

    It is unknown whether the hand holds a part.

    Source: errors.md, 16#805E.
    """
    bench = _begun(3, "refused")
    outputs: dict[str, Any] = {"Gripper.CloseOutput": wrong}
    if wrong:
        assert bench.work(**outputs) == "8044"
    outputs["Gripper.CloseOutput"] = 0
    bench.foreign = True
    for value in (0, 1):
        bench.send(0x301, 0, 0x1020, value)
        bench.scan(8)
    assert bench.told[-2:] == ["DO(20) OFF", "DO(20) ON"]
    assert bench.work(**outputs) == "805E"
