"""FB_PickPlace remembers what it has sent, so that no part is dropped, doubled or missing."""

from __future__ import annotations

from typing import Any

import pytest

from both_engines import ENGINES
from part_bench import AWAY, SOURCE, TARGET, PartBench

_PLAIN = ["DO(20) OFF", "move 10", "DO(20) ON", "move 20", "DO(20) OFF"]
_CALLS = {"no call": ("Call", False), "called twice": ("Twice", True), "early": ("Early", True)}
#: Commands of another block, and the meaning of their data (guide 4.2.1, 4.2.17, 4.5.1, 4.7.4).
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
    """Return a bench that has sent command `place` (from 0), has met `what`, and has stopped."""
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
    """Continue until Done; the bench or this function fails on forbidden events."""
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


@pytest.mark.parametrize("what", _DISTURBANCES)
def test_each_disturbance_at_each_command_neither_drops_nor_doubles_a_part(what: str) -> None:
    """The hand opens only at the target, and Done means a delivered part.

    A second part is fetched only after an error that requires a person to look.

    Source: head of FB_PickPlace; the places are those of its order
    """
    for place in range(len(_PLAIN)):
        _judge(place, what, "moved", outputs=1, sensor=False)
    for place in (3, 4):  # the opening output goes OFF, then the closing output goes ON
        _judge(place, what, "moved, power", outputs=2, sensor=False)
    _judge(4, what, "power", outputs=1, sensor=True)


@pytest.mark.parametrize("how", _CALLS)
@pytest.mark.parametrize("engine", ENGINES)
def test_a_close_is_not_forgotten_because_the_next_call_is_missing(engine: str, how: str) -> None:
    """The part is carried to the target from wherever the robot was moved.

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
def test_a_release_is_not_forgotten_either(how: str) -> None:
    """No second part is brought to the target, even if a sensor reports an empty hand.

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
    """The hand opens, and the robot returns to the source and closes it there.

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
    """The part has fallen. Holds shows this, and the next start fetches another part.

    Source: docs/explanation/fidelity.md: outputs are OFF after power-on
    """
    bench = _begun(3, "power cycle")
    assert bench.end == ("Error", 0x8001, False)
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", *_PLAIN]


def test_a_power_cycle_after_the_error_is_reported_at_the_next_start() -> None:
    """A person must look for the part first, since it may be anywhere.

    Source: errors.md, 16#8059.
    """
    bench = _begun(3, "refused")
    assert bench.end == ("Error", 0x8020, True)
    bench.power_cycle()
    assert not bench["Pick.Holds"]
    assert bench.work() == "8059"
    assert bench.work() == "Done"


def test_a_power_cycle_at_the_target_puts_the_part_down_there() -> None:
    """The next start places no second part. Source: fidelity.md: outputs are OFF after power-on."""
    bench = PartBench()
    bench["Pick.Gripper.PartInput"] = 30
    bench["Pick.Execute"] = True
    bench.until(lambda: bench["Pick.Stage"] == "PICK_STILL")
    bench.power_cycle()
    assert (bench["Pick.ErrorID"], bench.delivered) == (0x8001, 1)
    assert bench.work() == "Done"
    assert (bench.told.count("move 10"), bench.delivered) == (1, 1)


def test_a_power_cycle_leaves_a_hand_of_two_outputs_as_it_is() -> None:
    """Source: RCX_GRIPPER: OpenOutput is ON while it is open."""
    bench = _begun(5, "power cycle", outputs=2)
    assert (bench["Pick.Holds"], bench.held) == (True, True)
    assert bench.work() == "Done"
    assert bench.delivered == 1


def test_a_lost_link_with_a_part_in_the_hand_is_no_power_cycle() -> None:
    """The state is unknown while the link is lost. The outputs are read afterwards.

    Source: guide 4.5.1.
    """
    bench = _begun(3, "link loss")
    assert bench.end == ("Error", 0x8001, False)
    assert bench.work() == "Done"
    assert bench.told.count("move 10") == bench.delivered == 1


def test_a_power_cycle_without_a_call_of_the_block_is_seen_afterwards() -> None:
    """Some programs call the block in certain states only. Source: RCX_ARBITRATION, Losses."""
    bench = _begun(4, "no call, refused")
    bench.moved_by_hand()
    bench["Call"] = False
    bench.power_cycle()
    bench["Call"] = True
    assert bench.work() == "805E", "the part was released, or has fallen elsewhere"
    assert bench.work(HandEmpty=True) == "Done"


def test_an_unknown_state_of_the_hand_stays_an_error_until_hand_empty() -> None:
    """Both outputs are OFF and the close command had no end, so the hand may hold a part or not.

    With a sensor, HandEmpty is not needed.

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


def test_fingers_that_did_not_close_at_the_source_may_close_elsewhere() -> None:
    """The input came after the robot was moved, so it is unknown what the hand holds.

    Source: docs/reference/errors.md, 16#805A
    """
    bench = PartBench()
    bench["Pick.Gripper.ClosedInput"] = 43
    bench.fingers = False
    assert bench.work() == "805A"
    bench.moved_by_hand()
    bench.fingers = True
    assert bench.work() == "805E"


def test_where_the_target_was_reached_the_part_is_put_down_there_again() -> None:
    """The release was refused without being seen, so the robot moves to the target again.

    Source: its head.
    """
    bench = _begun(4, "no call, refused")
    assert bench.held
    bench.moved_by_hand()
    assert bench.work() == "Done"
    assert (bench.place, bench.delivered) == (TARGET, 1)


def test_a_power_cycle_that_begins_in_a_scan_without_a_call_is_reported_later() -> None:
    """The work ends because it was not called. The part has fallen wherever the robot was.

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


def test_a_power_cycle_after_an_error_at_the_target_puts_no_part_down_there() -> None:
    """The robot may have been moved after the error.

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
def test_of_two_outputs_a_hand_that_stayed_open_fetches_its_part_anew(place: int) -> None:
    """The close command was refused at the first or at the second output.

    Source: guide 4.5.1.
    """
    bench = _begun(place, "refused", outputs=2)
    assert bench.end == ("Error", 0x8020, False)
    before = len(bench.told)
    bench.moved_by_hand()
    assert bench.work() == "Done"
    assert bench.told[before:][:3] == ["read DO2", "read DO2", "DO(20) OFF"]
    assert (bench.told.count("move 10"), bench.delivered) == (2, 1)


def test_of_two_outputs_a_hand_that_is_closed_goes_on_with_its_part() -> None:
    """Source: head of FB_PickPlace: if they close it, the block continues the movement."""
    bench = _begun(5, "refused", outputs=2)
    bench.moved_by_hand()
    before = len(bench.told)
    assert bench.work() == "Done"
    assert bench.told[before:] == ["read DO2", "read DO2", "move 20", "DO(20) OFF", "DO(21) ON"]


@pytest.mark.parametrize("power", [False, True])
def test_where_fingers_closed_late_a_sensor_says_whether_there_is_a_part(power: bool) -> None:
    """If both outputs are OFF afterwards, the hand does not move.

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
def test_a_hand_that_another_block_closes_after_a_release(sensor: bool) -> None:
    """The release was refused, so closing changes nothing.

    Only a sensor can show whether there is a part.

    Source: docs/reference/errors.md, 16#805E
    """
    bench = _begun(4, "refused", sensor=sensor)
    bench.send(0x301, 0, 0x1020, 1)
    bench.until(lambda: bench.told[-1] == "DO(20) ON")
    bench.scan(5)
    assert bench.work() == ("Done" if sensor else "805E")
    assert bench.delivered == sensor


@pytest.mark.parametrize("outputs", [1, 2])
def test_after_a_release_and_a_loss_an_open_hand_of_two_outputs_has_released(outputs: int) -> None:
    """A hand with one output also opens without power, and the robot may have been elsewhere then.

    Source: head of FB_RcxPickMemory: without power one output opens the hand
    """
    bench = _begun(4 if outputs == 1 else 7, "lost-done", outputs=outputs)
    assert bench.delivered == 1
    bench.link_loss()
    assert bench.work() == ("805E" if outputs == 1 else "Done")
    assert bench.delivered == 1


@pytest.mark.parametrize("wrong", [0, 28])
def test_a_refused_start_does_not_hide_that_another_block_switches_the_hand(wrong: int) -> None:
    """The other block opens and closes the hand, so its content is unknown.

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
