"""The bridge exchanges data in a fixed order and in time, and handles failures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import pytest

from rcx_harness.bridge.core import Limits, Lost, Registers, State, words_of
from rcx_harness.bridge.figures import Figures, figures_text, plc_text, robot_text, state_text
from rcx_harness.bridge.loop import Loop, RobotLink
from rcx_harness.bridge.plc import PlcError, PlcLink
from rcx_harness.enip.originator.scanner import ScannerStatistics
from structured_text.errors import InputError

_ANSWERS = bytes(range(48))


@dataclass
class Room(PlcLink):
    """A simulated PLC with a clock. It records the loop's calls in their order."""

    now_us: int = 0
    done: list[tuple[str, object]] = field(default_factory=list)
    connected: bool = False
    fails: set[str] = field(default_factory=set)
    answer_us: int = 2_000
    words: list[int] = field(default_factory=lambda: [0] * 25)

    def clock(self) -> int:
        """Return the simulated time [us]."""
        return self.now_us

    def connect(self) -> None:
        """Simulate a connection to the PLC."""
        self._do("connect")
        self.connected = True

    def read(self) -> tuple[int, ...]:
        """Increment the heartbeat, and return all words of the PLC."""
        self._do("read")
        self.words[24] += 1
        return tuple(self.words)

    def write(self, words: Sequence[int]) -> None:
        """Record the words that are written to the PLC."""
        self._do("write", tuple(words))

    def _do(self, what: str, value: object = None) -> None:
        self.now_us += self.answer_us
        self.done.append((what, value))
        if what in self.fails:
            self.connected = False
            raise PlcError(f"{what} failed")

    def names(self) -> list[str]:
        """Return the names of the recorded calls, and clear the record."""
        names = [name for name, _ in self.done]
        self.done.clear()
        return names


class Robot(RobotLink):
    """A simulated robot. It records its calls in the same list as the PLC's calls."""

    def __init__(self, room: Room) -> None:
        self.room = room
        self.there = True
        self.valid_us: int | None = None
        self.image = b""

    def read(self) -> bytes | Lost:
        """Return the robot's area, or Lost if the robot is not connected."""
        return _ANSWERS if self.there else Lost("cut")

    def write(self, image: bytes, valid_us: int | None) -> None:
        """Record the image that is written to the robot."""
        self.room.done.append(("robot", image))
        self.image, self.valid_us = image, valid_us


@pytest.fixture
def room() -> Room:
    return Room()


@pytest.fixture
def robot(room: Room) -> Robot:
    return Robot(room)


@pytest.fixture
def news() -> list[tuple[State, str]]:
    return []


@pytest.fixture
def loop(room: Room, robot: Robot, news: list[tuple[State, str]]) -> Loop:
    return Loop(
        *(room, robot, Registers(), Limits()),
        on_state=lambda state, reason: news.append((state, reason)),
        clock_us=room.clock,
    )


def run(loop: Loop, room: Room) -> None:
    """Exchange data until the bridge runs, then clear the recorded calls."""
    for _ in range(100):
        room.now_us += 6_000
        if loop.turn().state is State.RUN:
            room.done.clear()
            return
    raise AssertionError(loop.reason)


def test_the_robot_is_written_before_the_plc(loop: Loop, room: Room) -> None:
    loop.turn()
    assert room.names() == ["connect", "read", "robot", "write"]
    loop.turn()
    assert room.names() == ["read", "robot", "write"]


def test_the_plcs_words_and_its_life_word_are_written_together(loop: Loop, room: Room) -> None:
    run(loop, room)
    actions = loop.turn()
    assert dict(room.done)["write"] == (*words_of(_ANSWERS), actions.life)
    room.words[:3] = [0x0201, 0, 0xFFFE]
    assert loop.turn().to_robot == b"\x01\x02\x00\x00\xfe\xff" + bytes(42)


def test_the_plcs_words_expire_but_zeros_do_not(loop: Loop, room: Room, robot: Robot) -> None:
    """The PLC's words expire after 200 ms, so a bridge that hangs cannot keep the robot moving."""
    loop.turn()
    assert robot.valid_us is None
    run(loop, room)
    assert robot.valid_us == 200_000, "the words must expire after 200 ms"
    room.fails.add("read")
    loop.turn()
    assert robot.valid_us is None


def test_if_reading_fails_the_robot_receives_zeros_in_the_same_exchange(
    loop: Loop, room: Room, robot: Robot
) -> None:
    run(loop, room)
    room.words[16] = 0x41
    assert loop.turn().to_robot[32] == 0x41
    room.done.clear()
    room.fails.add("read")
    loop.turn()
    assert room.names() == ["read", "robot"]
    assert robot.image == bytes(48)


def test_if_writing_fails_the_robot_receives_zeros_before_the_next_request(
    loop: Loop, room: Room, robot: Robot
) -> None:
    run(loop, room)
    room.fails.add("write")
    loop.turn()
    room.done.clear()
    loop.turn()
    assert room.names() == ["robot"]
    assert robot.image == bytes(48)
    assert (loop.state, loop.reason) == (State.NO_PLC, "write failed")


def test_the_connection_to_a_missing_plc_is_retried_after_half_a_second(
    loop: Loop, room: Room
) -> None:
    room.fails.add("connect")
    loop.turn()
    assert room.names() == ["connect", "robot"]
    room.now_us += 499_999
    loop.turn()
    assert room.names() == ["robot"]
    assert loop.reason == "connect failed", "the reason must not change"
    room.now_us += 1
    loop.turn()
    assert room.names() == ["connect", "robot"]


def test_a_refused_request_is_repeated_at_once_on_the_same_connection(
    loop: Loop, room: Room
) -> None:
    run(loop, room)
    room.fails.add("read")
    loop.turn()
    room.connected = True
    room.names()
    loop.turn()
    assert room.names() == ["read", "robot"]


def test_each_change_of_state_is_reported_once(
    loop: Loop, room: Room, robot: Robot, news: list[tuple[State, str]]
) -> None:
    run(loop, room)
    told = "it is being informed that there was no connection"
    assert news == [(State.CLEARING, told), (State.RUN, "")]
    robot.there = False
    for _ in range(3):
        loop.turn()
    assert news[2:] == [(State.NO_ROBOT, "cut")]


def test_at_the_end_plc_and_robot_receive_zeros(loop: Loop, room: Room, robot: Robot) -> None:
    run(loop, room)
    loop.end()
    assert room.done == [("robot", bytes(48)), ("write", (0,) * 25)]
    assert robot.valid_us is None
    room.connected = False
    loop.end()
    assert room.names()[2:] == ["robot"], "only the robot must get data"


def test_an_error_of_the_last_write_is_ignored(loop: Loop, room: Room) -> None:
    run(loop, room)
    room.fails.add("write")
    loop.end()


def test_figures_count_only_successful_exchanges(loop: Loop, room: Room) -> None:
    """Failed exchanges do not change the figures.

    Reading and writing take 2 ms each, and there is an exchange every 10 ms.
    """
    run(loop, room)
    for _ in range(20):
        room.now_us += 6_000
        loop.turn()
    rate = loop.figures.look(room.now_us + 3_000)
    assert (rate.median_us, rate.age_us) == (4_000, 3_000)
    assert rate.max_us == 6_000, "the longest exchange includes the connect"
    assert rate.per_second == pytest.approx(100.0)
    room.fails.add("read")
    loop.turn()
    after = loop.figures.look(room.now_us)
    assert (after.per_second, after.max_us) == (rate.per_second, rate.max_us)


def test_the_99th_percentile_differs_from_the_longest() -> None:
    figures = Figures()
    for k in range(100):
        figures.add(k * 10_000, 1_000 if k < 98 else 50_000 + k)
    rate = figures.look(990_000)
    assert (rate.median_us, rate.p99_us, rate.max_us, rate.age_us) == (1_000, 50_099, 50_099, 0)
    assert Figures().look(5).age_us is None


_SEEN = ScannerStatistics(
    sent=10,
    received=10,
    missing=3,
    dropped=0,
    skipped=0,
    gap_median_us=10_000,
    gap_p99_us=10_400,
    gap_max_us=12_000,
)


def test_the_figures_are_one_line() -> None:
    figures = Figures()
    for k in range(11):
        figures.add(k * 10_000, 500)
    assert figures_text(figures.look(104_000), (_SEEN, 2_500)) == (
        "PLC 100.0 exchanges/s, round trip 0.5 ms median 0.5 ms p99 0.5 ms longest, data 4.0 ms "
        "old; robot 100.0 packets/s, one every 10.0 ms median 10.4 ms p99 12.0 ms longest, "
        "3 missing, data 2.5 ms old"
    )


def test_old_figures_are_not_shown() -> None:
    figures = Figures()
    assert plc_text(figures.look(0)) == "PLC: no exchange yet"
    figures.add(0, 500)
    assert plc_text(figures.look(1_500_000)) == "PLC: no exchange for 1.5 s"
    assert robot_text(None) == robot_text((_SEEN, None)) == "robot: no packet yet"
    assert robot_text((_SEEN, 2_000_000)) == "robot: no packet for 2.0 s"


def test_48_bytes_need_one_request_and_256_bytes_need_two() -> None:
    """One Modbus request can read 125 registers or write 123, so 256 bytes need two requests.

    A double word is never divided between two requests.
    """
    assert list(Registers(0, 1024, 48).parts(1024)) == [(1024, 25)]
    assert list(Registers(100, 1024, 256).parts(100)) == [(100, 120), (220, 9)]


@pytest.mark.parametrize(
    ("registers", "message"),
    [
        ((0, 1024, 64), "an area of 64 bytes does not exist"),
        ((-1, 1024, 48), "--read -1: there are no registers -1 to 23"),
        ((0, 65_512, 48), "--write 65512: there are no registers 65512 to 65536"),
        ((0, 24, 48), "the registers 0 to 24 and 24 to 48 overlap"),
        ((1024, 1000, 48), "the registers 1024 to 1048 and 1000 to 1024 overlap"),
    ],
)
def test_impossible_registers_are_rejected(registers: tuple[int, int, int], message: str) -> None:
    with pytest.raises(InputError) as refused:
        Registers(*registers)
    assert message in str(refused.value)


def test_the_last_registers_and_adjacent_areas_are_accepted() -> None:
    assert Registers(0, 65_511, 48).text(65_511) == "65511 to 65535"
    assert Registers(25, 0, 48).words == 24


def test_a_state_is_shown_with_its_reason() -> None:
    assert state_text(State.RUN, "") == "running"
    assert state_text(State.NO_PLC, "x") == "no PLC: x"
