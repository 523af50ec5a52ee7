"""The bridge decides in each exchange which data it sends to the PLC and to the robot.

A scene has a PLC, a robot and the bridge between them. `Scene.go` runs one exchange.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest

from rcx_harness.bridge.core import (
    Actions,
    Bridge,
    Limits,
    Lost,
    PlcSeen,
    State,
    area_of,
    words_of,
)

_MS = 1_000
_PERIOD_US = 10 * _MS
_LIMITS = Limits(gap_us=100 * _MS, beat_us=500 * _MS, hold_us=200 * _MS)
#: A PLC area in which SI(00), SI(06) (byte 32) and SI(20) (byte 34) are ON. Code and data are 0.
_REQUESTING = bytes(32) + bytes([0x41, 0x00, 0x01]) + bytes(13)
_NOT_REQUESTING = bytes(34) + bytes([0x01]) + bytes(13)
#: An area of the robot: status 0x0200, SOW(2) = 0x1234, and SO(01) CPU_OK is ON.
_ANSWERS = b"\x00\x02\x00\x00\x34\x12" + bytes(26) + b"\x02" + bytes(15)
_ZERO = bytes(48)


@dataclass
class Scene:
    """A simulated PLC, a simulated robot, and the latest actions of the bridge between them."""

    limits: Limits = _LIMITS
    area: bytes = _NOT_REQUESTING
    beats: bool = True
    plc_there: bool = True
    robot_there: bool = True
    now_us: int = 0
    beat: int = 0
    bridge: Bridge = field(init=False)
    last: Actions = field(init=False)

    def __post_init__(self) -> None:
        self.bridge = Bridge(len(self.area), self.limits)

    def go(self, times: int = 1, after_us: int = _PERIOD_US) -> Actions:
        """Run `times` exchanges at intervals of `after_us`, and return the last actions."""
        for _ in range(times):
            self.now_us += after_us
            self.beat = (self.beat + self.beats) & 0xFFFF
            plc = PlcSeen(self.area, self.beat, self.now_us) if self.plc_there else Lost("gone")
            robot = _ANSWERS if self.robot_there else Lost("cut")
            self.last = self.bridge.step(self.now_us, plc, robot)
            if self.last.state is not State.RUN:
                self.assert_safe()
        return self.last

    def assert_safe(self) -> None:
        """Check that the bridge sends only zeros to the robot and to the PLC."""
        assert self.last.to_robot == _ZERO
        assert self.last.to_plc == (0,) * 24
        assert self.last.life == 0

    def until_run(self, most: int = 100) -> int:
        """Exchange data until the bridge runs, and return the number of exchanges."""
        for count in range(1, most + 1):
            if self.go().state is State.RUN:
                return count
        raise AssertionError(
            f"{most} exchanges, but the state is still {self.last.state}: {self.last.reason}"
        )


@pytest.fixture
def scene() -> Scene:
    return Scene()


@pytest.fixture
def running(scene: Scene) -> Scene:
    scene.until_run()
    scene.area = _REQUESTING
    assert scene.go().to_robot == _REQUESTING
    return scene


def test_words_are_little_endian() -> None:
    """Byte m is the low byte of SOW(0), and byte m + 1 is the high byte.

    Source: manual chapter 1, 4.1.
    """
    assert words_of(_ANSWERS)[:4] == (0x0200, 0x0000, 0x1234, 0x0000)
    assert words_of(_ANSWERS)[16] == 0x0002
    assert area_of(words_of(_ANSWERS)) == _ANSWERS


def test_at_the_start_the_plc_receives_zeros_for_the_hold_time() -> None:
    """The PLC receives zeros for 200 ms before the bridge runs, so it runs in the 22nd exchange."""
    assert Scene().until_run() == 22


def test_while_the_bridge_runs_both_areas_pass_and_the_life_word_changes(
    running: Scene,
) -> None:
    first = running.go()
    assert (first.to_robot, first.to_plc, first.reason) == (_REQUESTING, words_of(_ANSWERS), "")
    assert running.go().life == first.life + 1


def test_the_life_word_is_never_0_while_the_bridge_runs() -> None:
    scene = Scene()
    scene.until_run()
    lives = [scene.go(after_us=1).life for _ in range(0x10000)]
    assert 0 not in lives
    assert max(lives) == 0xFFFF
    assert 1 in lives, "the life word must wrap from 65535 to 1"


def test_after_a_loss_of_the_plc_the_robot_receives_zeros_at_once(running: Scene) -> None:
    """If the PLC is lost, the next packet to the robot is zero, with SI(00) and SI(06) OFF.

    Source: manual chapter 1, 5.2.
    """
    running.plc_there = False
    assert running.go().state is State.NO_PLC
    assert running.last.reason == "gone"


def test_after_a_loss_of_the_robot_the_plc_receives_zeros_at_once(running: Scene) -> None:
    running.robot_there = False
    assert running.go().state is State.NO_ROBOT
    assert running.last.reason == "cut"


@pytest.mark.parametrize("side", ["plc_there", "robot_there"])
def test_after_a_loss_the_plc_must_clear_code_and_dedicated_inputs(
    running: Scene, side: str
) -> None:
    """After a loss, neither a command nor SI(00) may turn ON again by itself."""
    setattr(running, side, False)
    running.go()
    setattr(running, side, True)
    assert running.go(100).state is State.CLEARING
    assert running.last.reason == "it still holds dedicated inputs, 16#0041"
    running.area = b"\x01\x00" + bytes(46)
    assert running.go().reason == "it still holds the remote command 16#0001"
    running.area = _NOT_REQUESTING
    assert running.go().state is State.RUN
    assert running.last.to_robot == _NOT_REQUESTING, "general-purpose inputs may stay ON"


@pytest.mark.parametrize(
    "word", [k for k in range(24) if k not in (0, 16)], ids=lambda k: f"word {k}"
)
def test_only_the_code_and_the_dedicated_inputs_must_be_clear(word: int) -> None:
    area = bytearray(48)
    area[2 * word] = 1
    assert Scene(area=bytes(area)).until_run() == 22


@pytest.mark.parametrize("at", [0, 1, 32, 33])
def test_each_byte_of_code_and_dedicated_inputs_must_be_clear(at: int) -> None:
    area = bytearray(48)
    area[at] = 0x80
    scene = Scene(area=bytes(area))
    assert scene.go(100).state is State.CLEARING


def test_a_short_loss_of_the_robot_is_shown_to_the_plc_for_the_whole_hold_time(
    scene: Scene,
) -> None:
    """The hold time ensures that FB_ReadArea.Connected is FALSE for at least one scan."""
    scene.until_run()
    scene.robot_there = False
    scene.go()
    scene.robot_there = True
    assert scene.until_run() == 21, "one exchange until the first answer, then 200 ms"


def test_after_a_loss_of_the_plc_the_hold_time_begins_with_the_first_write(
    scene: Scene,
) -> None:
    scene.until_run()
    scene.plc_there = False
    scene.go(1000)
    scene.plc_there = True
    assert scene.until_run() == 22


def test_after_each_loss_of_the_plc_the_hold_time_begins_again() -> None:
    scene = Scene()
    for _ in range(10):
        scene.plc_there = True
        assert scene.go(20).state is State.CLEARING
        scene.plc_there = False
        assert scene.go().state is State.NO_PLC


def test_time_without_a_robot_counts_for_the_hold_time() -> None:
    """Without a robot the PLC receives zeros. This time counts as hold time."""
    scene = Scene(robot_there=False)
    scene.go(50)
    scene.robot_there = True
    assert scene.until_run() == 1


def test_the_bridge_restarts_only_if_the_program_has_run_since_the_loss() -> None:
    """The bridge waits for two changes of the heartbeat.

    The first change may come from a scan before the loss.
    """
    scene = Scene(beats=False, limits=Limits(_LIMITS.gap_us, 60_000 * _MS, _LIMITS.hold_us))
    assert scene.go(100).reason == "its program has not run since"
    scene.beat += 1
    assert scene.go().reason == "its program has not run since"
    scene.beat += 1
    assert scene.go().state is State.RUN


def test_a_constant_heartbeat_is_a_loss_of_the_plc(running: Scene) -> None:
    """The PLC counts as lost if its Modbus server answers, but its program has stopped."""
    running.beats = False
    assert running.go(50).state is State.RUN, "500 ms are within the limit"
    assert running.go().state is State.STANDING
    assert running.last.reason == f"its heartbeat has been {running.beat} for 510 ms"
    assert running.go(1000).state is State.STANDING
    running.beats, running.area = True, _NOT_REQUESTING
    assert running.go().state is State.CLEARING
    assert running.until_run() == 20, "the hold time is 200 ms"


def test_a_slow_heartbeat_is_accepted(running: Scene) -> None:
    running.beats = False
    for _ in range(10):
        assert running.go(49).state is State.RUN
        running.beat += 1
        assert running.go().state is State.RUN


def test_without_heartbeat_monitoring_the_word_is_ignored() -> None:
    scene = Scene(beats=False, limits=Limits(_LIMITS.gap_us, 0, _LIMITS.hold_us))
    assert scene.until_run() == 22
    scene.area = _REQUESTING
    assert scene.go(10_000).state is State.RUN


def test_a_heartbeat_may_wrap_to_0() -> None:
    scene = Scene(beat=0xFFF0)
    scene.until_run()
    assert scene.go(0x20).state is State.RUN


def test_a_long_gap_between_two_readings_is_a_loss_of_the_plc(running: Scene) -> None:
    """After a long gap between two readings, two changes of inputs could be sent together.

    Source: manual chapter 5, 3, caution: 100 ms between two changes.
    """
    assert running.go(after_us=100 * _MS).state is State.RUN
    assert running.go(after_us=100 * _MS + 1).state is State.NO_PLC
    assert running.last.reason == "100.001 ms between two readings; limit 100 ms"
    running.area = _NOT_REQUESTING
    assert running.go().state is State.CLEARING
    running.until_run()


def test_the_gap_is_measured_from_the_last_request_to_this_answer(scene: Scene) -> None:
    scene.until_run()
    asked_us = scene.now_us
    scene.beat += 1
    plc = PlcSeen(_NOT_REQUESTING, scene.beat, asked_us + 60 * _MS)
    actions = scene.bridge.step(asked_us + 101 * _MS, plc, _ANSWERS)
    assert actions.state is State.NO_PLC


def test_a_gap_is_accepted_while_the_bridge_sends_zeros() -> None:
    scene = Scene()
    scene.go()
    assert scene.go(after_us=5_000 * _MS).state is State.CLEARING
    assert scene.until_run() == 20


def test_if_plc_and_robot_are_lost_the_plc_is_reported(running: Scene) -> None:
    running.plc_there = running.robot_there = False
    assert running.go().state is State.NO_PLC


def test_areas_of_256_bytes_pass() -> None:
    area = bytes(48) + bytes(range(208))
    scene = Scene(area=area)
    seen = (PlcSeen(area, beat, 10 * _MS * beat) for beat in range(1, 40))
    last = [scene.bridge.step(one.asked_us, one, area) for one in seen][-1]
    assert (last.state, last.to_robot, last.to_plc) == (State.RUN, area, words_of(area))
