"""Tests use the controller to hold outputs, inject events, take snapshots and repeat runs."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import pytest

from rcx_harness.robot import EVENTS, Controller, Point, RobotConfig, Violation
from rcx_harness.spec.wire import CYCLE_US
from robot_master import Master, powered_up
from structured_text.errors import InputError

#: Arguments of the events that need some.
ARGUMENTS = {"parallel_input": {"port": 6, "on": 1}}


def test_a_held_output_does_not_answer_until_it_is_released() -> None:
    master = powered_up()
    master.robot.hold("SO02")
    master.pulse("SI01")
    assert not master.on("SO02")
    master.robot.release("SO02")
    master.run(5)
    assert master.on("SO02")


def test_a_held_status_also_holds_the_response_back() -> None:
    master = powered_up()
    master.robot.hold("Status")
    master.send(0x0501)
    master.run(100)
    assert master.words == (0,) * 16
    master.robot.release("Status")
    master.run(5)
    assert master.words[:3] == (0x0200, 0, 0x0108)


@pytest.mark.parametrize(
    ("name", "value", "at", "byte"),
    [
        ("SO03", 1, 32, 0b0001_1011),
        ("SO(01)", 0, 32, 0b0001_0001),
        ("SO04_MpRdy", 0, 32, 0b0000_0011),
        ("SO15", 1, 33, 0b0010_0011),
        ("SO20", 1, 34, 0x01),
        ("SO(77)", 1, 39, 0x80),
        ("SO100", 1, 40, 0x01),
        ("SO157", 1, 45, 0x80),
        ("Status", 0x0300, 1, 0x03),
        ("SOW(15)", 0x1234, 30, 0x34),
        ("SOW127", 0xABCD, 255, 0xAB),
        ("SOW(2)", 0x0000, 5, 0x00),
        ("SOW(2)", 0xFFFF, 5, 0xFF),
    ],
)
def test_any_output_can_be_forced(name: str, value: int, at: int, byte: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2 (addresses)."""
    master = Master(size=256)
    master.run(300)
    before = master.so
    master.robot.force(name, value)
    master.run(5)
    assert master.so[at] == byte
    master.robot.release(name)
    master.run(5)
    assert master.so == before


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("SOW(2)", -1),
        ("SOW(2)", 0x10000),
        ("SO99", 1),
        ("SO160", 1),
        ("SO18", 1),
        ("SI01", 1),
        ("SO02", 2),
        ("SOW(24)", 1),
        ("Status", 0x10000),
    ],
)
def test_an_output_that_cannot_be_forced_is_refused(name: str, value: int) -> None:
    with pytest.raises(InputError):
        Controller().force(name, value)


def test_an_unknown_output_is_refused_with_near_names() -> None:
    with pytest.raises(InputError, match="did you mean SO02_ServoOn"):
        Controller().hold("SO02_ServoOnn")


@pytest.mark.parametrize(
    ("event", "args", "message"),
    [
        ("emergencystop", {}, "did you mean emergency_stop"),
        ("alarm", {"group": 12}, "needs category; write"),
        ("parallel_input", {}, "needs port and on; write"),
        (
            "alarm",
            {"group": 12, "category": "x"},
            "category = 'x' of event 'alarm' is not a number",
        ),
        (
            "alarm",
            {"group": 12, "category": 70000},
            "category = 70000 of event 'alarm' is not a number from 0 to 65535",
        ),
        ("warning", {"group": 1}, "takes no arguments"),
    ],
)
def test_a_wrong_event_is_refused(event: str, args: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Controller().inject(event, **args)


@pytest.mark.parametrize("event", sorted(EVENTS))
def test_every_event_may_happen_at_any_time(event: str) -> None:
    args = ARGUMENTS.get(event, {})
    for boot in (0, 300):
        master = Master()
        master.run(boot)
        master.robot.inject(event, **args)
        master.run(50)
    assert EVENTS[event]


def test_the_controller_cycle_is_5_ms() -> None:
    """Rule: cycle. Source: manual chapter 5, 4."""
    assert CYCLE_US == 5000


def test_an_area_of_the_wrong_size_is_refused() -> None:
    with pytest.raises(InputError, match="the area has 48 bytes, not 256"):
        Controller().cycle(0, bytes(256))


def test_drain_violations_returns_each_violation_once() -> None:
    master = Master()
    master.run(300)
    master.si[46] = 1
    master.run(10)
    text = "the master writes to the reserved area: n+46 = 16#01"
    assert master.robot.drain_violations() == [Violation(300_000, "reserved", text)]
    assert master.robot.drain_violations() == []
    assert len(master.robot.violations) == 1


def _random_life(seed: int, robot: Controller, start: int, cycles: int) -> list[bytes]:
    """Apply random bits, words, connection losses and events.

    Return the areas that the controller sends.
    """
    rng = random.Random(seed)
    si = bytearray(48)
    answers = []
    for k in range(cycles):
        if rng.random() < 0.1:
            si[rng.choice((32, 33))] ^= 1 << rng.randrange(8)
        if rng.random() < 0.05:
            si[0:2] = rng.choice((0, 0, 0x0001, 0x0100, 0x0505, 0x0604)).to_bytes(2, "little")
        if rng.random() < 0.02:
            si[rng.randrange(2, 32)] = rng.choice((0, 1, 19))
        if rng.random() < 0.01:
            event = rng.choice(sorted(EVENTS.keys() - {"alarm"}))
            robot.inject(event, **ARGUMENTS.get(event, {}))
        lost = rng.random() < 0.02
        answers.append(robot.cycle((start + k) * 5000, None if lost else bytes(si)))
    return answers


def _busy_robot(seed: int) -> Controller:
    points = {19: Point((5000, 0, 0, 0, 0, 0))}
    config = RobotConfig(
        points=points,
        boot_time=20,
        emergency_stop_delay=(0, 60),
        servo_on_delay=(5, 90),
        command_delay=(0, 60),
        min_interval=20,
    )
    return Controller(config, seed)


@pytest.mark.parametrize("seed", range(3))
def test_two_controllers_with_the_same_seed_and_calls_send_the_same_bytes(seed: int) -> None:
    first, second = _busy_robot(seed), _busy_robot(seed)
    assert _random_life(seed, first, 0, 2000) == _random_life(seed, second, 0, 2000)
    assert first.violations == second.violations != []


@pytest.mark.parametrize("seed", range(3))
def test_a_restored_snapshot_goes_on_as_the_original_did(seed: int) -> None:
    robot = _busy_robot(seed)
    _random_life(seed, robot, 0, 500)
    snapshot = robot.snapshot()
    original = _random_life(seed + 1, robot, 500, 1000)
    violations = list(robot.violations)
    for _ in range(2):
        robot.restore(snapshot)
        assert _random_life(seed + 1, robot, 500, 1000) == original
        assert robot.violations == violations


def test_an_idle_cycle_gives_the_area_of_the_previous_cycle() -> None:
    robot = Controller(RobotConfig(boot_time=0))
    on, off = bytes([0] * 32 + [0x41] + [0] * 15), bytes([0] * 32 + [0x40] + [0] * 15)
    images = [on, on, off, on] + [on] * 40
    areas = [robot.cycle(k * 5000, image) for k, image in enumerate(images)]
    assert areas[-1] is areas[-2]


def test_a_snapshot_of_another_robot_is_refused() -> None:
    with pytest.raises(InputError):
        Controller().restore(Controller(RobotConfig(size=256)).snapshot())
    with pytest.raises(InputError):
        Controller().restore(object())


@pytest.mark.parametrize("seed", range(3))
def test_skipping_idle_cycles_changes_no_answer(seed: int) -> None:
    """Skipping idle cycles gives the same answers as executing each cycle."""
    lazy, diligent = _busy_robot(seed), _busy_robot(seed)
    work = diligent.cycle

    def cycle(now_us: int, si: bytes | None) -> bytes:
        # reading the positions may change them, so the next cycle must be executed
        assert diligent.origins is not None
        return work(now_us, si)

    diligent.cycle = cycle  # type: ignore[method-assign]
    assert _random_life(seed, lazy, 0, 3000) == _random_life(seed, diligent, 0, 3000)


@pytest.mark.parametrize(
    ("act", "at", "byte"),
    [
        (lambda robot: robot.force("SO(20)", 1), 34, 1),
        (lambda robot: robot.write_port("SO(20)", 1), 34, 1),
        (lambda robot: robot.inject("warning"), 33, 0b0010_0011),
        (lambda robot: robot.origins.__setitem__(0, False), 33, 0b0000_0001),
    ],
    ids=["force", "write_port", "inject", "origins"],
)
def test_changes_before_the_first_cycle_show_in_it(
    act: Callable[[Controller], None], at: int, byte: int
) -> None:
    """Data are changed before the first cycle of a booted controller, and before a later cycle.

    Source: manual chapter 1, 4.1
    """
    first, later = Controller(), Controller()
    act(first)
    assert first.cycle(0, None)[at] == byte
    later.cycle(0, None)
    act(later)
    assert later.cycle(CYCLE_US, None)[at] == byte
