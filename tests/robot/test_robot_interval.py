"""Changes of dedicated inputs are 100 ms apart, and the reserved area is not written."""

from __future__ import annotations

import pytest

from robot_master import Master, powered_up, servos_on


def test_100_ms_between_two_changes_are_enough() -> None:
    """Rule: interval. Source: manual chapter 5, 3.1, caution."""
    master = Master()
    master.run(300)
    for name in ("SI00", "SI06", "SI01"):
        master.turn_and_wait(name, True, 100)
    assert master.on("SO02")
    assert master.texts() == []


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        pytest.param(
            [("SI16", True, 95), ("SI01", True, 5)],
            "SI(01) Servo ON input ON 95 ms after SI(16) Alarm reset input ON",
            id="another input after 95 ms",
        ),
        pytest.param(
            [("SI16", True, 50), ("SI16", False, 5)],
            "SI(16) Alarm reset input OFF 50 ms after SI(16) Alarm reset input ON",
            id="the same input after 50 ms",
        ),
        pytest.param(
            [("SI06", False, 50), ("SI16", True, 5)],
            "SI(16) Alarm reset input ON 50 ms after SI(06) Stop input OFF",
            id="an input after a switch-off of SI(06)",
        ),
        pytest.param(
            [("SI01", True, 0), ("SI15", True, 5)],
            "SI(01) Servo ON input ON and SI(15) Program reset input ON in the same exchange",
            id="two inputs in the same exchange",
        ),
        pytest.param(
            [("SI06", False, 0), ("SI01", True, 0), ("SI16", True, 5)],
            "SI(01) Servo ON input ON and SI(16) Alarm reset input ON in the same exchange",
            id="two inputs in the exchange of a switch-off",
        ),
    ],
)
def test_a_change_that_comes_too_early_is_not_recognised_and_is_reported(
    changes: list[tuple[str, bool, float]], text: str
) -> None:
    """The interval applies to changes of the same input and of different inputs.

    Rule: interval, interval-strict, interval-stops.
    Source: manual chapter 5, 3.1, caution
    """
    master = powered_up()
    for name, on, ms in changes:
        master.turn_and_wait(name, on, ms)
    assert master.texts() == [f"interval: {text}, at least 100 ms are needed; not recognised"]
    master.run(300)
    assert (master.on("SO02"), master.on("SO14")) == (False, False)


def test_a_switch_off_of_si00_or_si06_is_taken_at_once() -> None:
    """SI(00) and SI(06) may turn OFF together at any time without a violation.

    Rule: interval-stops.
    """
    master = servos_on()
    master.turn_and_wait("SI12", True, 50)
    master.turn("SI00", False)
    master.turn("SI06", False)
    master.run(5)
    assert master.on("SO00")
    assert not master.on("SO02")
    assert master.texts() == []


def test_another_input_in_the_exchange_of_a_switch_off_is_not_recognised() -> None:
    """The other change is ignored without a violation, because it may come from an earlier packet.

    Rule: interval-stops.
    """
    master = powered_up()
    master.turn("SI06", False)
    master.turn("SI01", True)
    master.run(200)
    assert not master.on("SO02")
    assert master.texts() == []


def test_without_an_interval_another_input_in_the_exchange_of_a_switch_off_is_taken() -> None:
    """Rule: interval-stops, interval-strict."""
    master = powered_up(min_interval=0)
    master.turn("SI06", False)
    master.turn("SI01", True)
    master.run(200)
    assert master.on("SO02")


@pytest.mark.parametrize(("late", "emergency"), [(True, False), (False, True)])
def test_an_unrecognised_level_is_taken_after_the_interval(late: bool, emergency: bool) -> None:
    """Rule: interval-levels."""
    master = Master(late_levels=late)
    master.run(300)
    master.turn_and_wait("SI06", True, 50)
    master.turn_and_wait("SI00", True, 100)
    assert master.on("SO00")
    master.run(50)
    assert master.on("SO00") is emergency
    assert len(master.texts()) == 1


def test_an_edge_that_was_not_recognised_never_acts() -> None:
    """After the interval, the input counts only as a level. A new edge needs an OFF first.

    Rule: interval-levels, interval-strict.
    """
    master = Master()
    master.run(300)
    master.turn_and_wait("SI06", True, 150)
    master.turn_and_wait("SI00", True, 50)
    master.turn_and_wait("SI01", True, 500)
    assert not master.on("SO02")
    master.turn_and_wait("SI01", False)
    master.turn_and_wait("SI01", True)
    assert master.on("SO02")


def test_a_key_sets_the_interval() -> None:
    """Rule: interval-strict."""
    master = Master(min_interval=0)
    master.run(300)
    master.turn("SI00", True)
    master.turn_and_wait("SI06", True, 10)
    master.turn_and_wait("SI01", True, 60)
    assert master.on("SO02")
    assert master.texts() == []


@pytest.mark.parametrize(
    ("at", "value", "where"),
    [
        (32, 0x04, "n+32 bit 2"),
        (32, 0x80, "n+32 bit 7"),
        (33, 0x02, "n+33 bit 1"),
        (33, 0x08, "n+33 bit 3"),
        (46, 0x01, "n+46 = 16#01"),
        (47, 0xFF, "n+47 = 16#FF"),
    ],
)
def test_the_reserved_area_is_not_written(at: int, value: int, where: str) -> None:
    """Each change is reported once. Rule: reserved. Source: manual chapter 5, 1, note 1."""
    master = Master()
    master.run(300)
    master.si[at] |= value
    master.run(50)
    assert master.texts() == [f"reserved: the master writes to the reserved area: {where}"]
    master.si[at] = 0
    master.run(50)
    assert master.texts() == []


def test_general_purpose_inputs_may_change_at_any_time() -> None:
    """Source: manual chapter 5, 2."""
    master = Master(size=256)
    master.run(300)
    for at in [*range(34, 46), *range(48, 256)]:
        master.si[at] = 0xFF
        master.run(5)
    assert master.texts() == []


def test_a_level_that_was_not_recognised_is_taken_exactly_after_the_interval() -> None:
    """The interval counts from the last change, even if that change was not recognised.

    Rule: interval-levels, interval-strict.
    """
    master = powered_up(sequence_delay=0)
    master.turn_and_wait("SI16", True, 50)
    master.turn_and_wait("SI10", True, 100)
    assert not master.on("SO12")
    master.run(5)
    assert master.on("SO12")


def test_an_input_whose_switch_off_was_not_recognised_makes_no_edge_when_it_is_on_again() -> None:
    """The controller did not recognise the switch-off, so the input was ON all the time.

    Rule: interval-levels, interval-strict.
    """
    master = powered_up()
    master.turn_and_wait("SI16", True, 50)
    master.turn_and_wait("SI16", False, 50)
    master.robot.inject("alarm")
    master.run(50)
    master.turn_and_wait("SI16", True, 300)
    assert master.on("SO03")
    assert len(master.texts()) == 1
    master.turn_and_wait("SI16", False)
    master.turn_and_wait("SI16", True)
    assert not master.on("SO03")


@pytest.mark.parametrize("lost", [False, True])
def test_the_interval_counts_from_no_change_before_the_first_image(lost: bool) -> None:
    """The first image after power-on or a loss may change inputs without the interval.

    Rule: link-first-image.
    """
    master = Master()
    if lost:
        master.power_up()
        master.turn_and_wait("SI16", True, 20)
        master.connected = False
        master.run(20)
        master.connected = True
    master.run(10)
    master.turn_and_wait("SI10", True, 20)
    assert master.on("SO12")
    assert master.texts() == []
