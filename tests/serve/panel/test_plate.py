"""The faceplate holds pressed keys, and releases them when their page is silent."""

from __future__ import annotations

from pathlib import Path

import pytest

from both_engines import ENGINES
from plc_bench import LIBRARY, ROOT
from rcx_harness.serve.panel.plate import HOLD_S, Plate, plates_of
from structured_text.engines import build
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.projects.needed import needed

_BENCH = ROOT / "tests/data/library/Operator.st"


class _Clock:
    """A clock with the seconds that the test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


def _program(source: Path = _BENCH, engine: str = "builtin") -> Program:
    return build([source, *needed([source], LIBRARY)], engine).program


@pytest.fixture
def clock() -> _Clock:
    """Return a clock that does not advance by itself."""
    return _Clock()


@pytest.fixture
def program() -> Program:
    """Return a program with one panel."""
    return _program()


@pytest.fixture
def plate(program: Program, clock: _Clock) -> Plate:
    """Return the program's panel."""
    (one,) = plates_of(program, clock)
    return one


def _down(program: Program) -> list[str]:
    return [name for name, on in program.read("Main.Panel.Key").items() if on]


def _scans(program: Program, plate: Plate, count: int) -> list[list[str]]:
    """Run `count` scans, and return the keys that the program sees pressed in each scan."""
    seen = []
    for _ in range(count):
        plate.exchange()
        seen.append(_down(program))
    return seen


def test_a_key_is_pressed_and_released_in_the_program(program: Program, plate: Plate) -> None:
    plate.press("p", 1, ["JogPlus"])
    assert _down(program) == [], "only the cell's thread touches the program"
    plate.exchange()
    assert _down(program) == ["JogPlus"]
    plate.exchange()
    assert _down(program) == ["JogPlus"]
    plate.press("p", 2, [])
    plate.exchange()
    assert _down(program) == []


def test_a_click_that_is_shorter_than_a_scan_is_there_for_one(
    program: Program, plate: Plate
) -> None:
    plate.press("p", 1, ["Start"])
    plate.press("p", 2, [])
    plate.press("p", 3, ["Start"])
    seen = []
    for _ in range(4):
        plate.exchange()
        seen.append(_down(program))
    assert seen == [["Start"], [], ["Start"], ["Start"]]


def test_a_page_that_falls_silent_releases_its_keys(
    program: Program, plate: Plate, clock: _Clock
) -> None:
    """If a page is silent, its keys are released: a lost browser must not move the robot."""
    plate.press("p", 1, ["JogPlus"])
    plate.exchange()
    clock.now += HOLD_S
    plate.exchange()
    assert _down(program) == ["JogPlus"]
    plate.press("p", 2, ["JogPlus"])
    clock.now += HOLD_S
    plate.exchange()
    assert _down(program) == ["JogPlus"], "the page was heard again"
    clock.now += 0.01
    plate.exchange()
    assert _down(program) == []


def test_waiting_keys_of_a_silent_page_are_not_pressed_later(
    program: Program, plate: Plate, clock: _Clock
) -> None:
    plate.press("p", 1, ["JogPlus"])
    plate.press("p", 2, [])
    plate.press("p", 3, ["JogPlus"])
    clock.now += HOLD_S + 0.01
    for _ in range(5):
        plate.exchange()
        assert _down(program) == []


def test_a_stop_is_not_lost_if_another_page_is_silent(
    program: Program, plate: Plate, clock: _Clock
) -> None:
    """Source: docs/how-to/network.md, a key is TRUE for at least one scan."""
    plate.press("a", 1, ["JogPlus"])
    plate.press("a", 2, [])
    plate.exchange()
    plate.exchange()
    clock.now += HOLD_S - 0.001
    plate.press("b", 1, ["Stop"])
    plate.press("b", 2, [])
    clock.now += 0.005
    assert _scans(program, plate, 3) == [["Stop"], [], []], "page a holds no key"
    plate.press("a", 3, ["JogPlus"])
    clock.now += HOLD_S - 0.001
    plate.press("b", 3, ["Stop"])
    plate.press("b", 4, [])
    clock.now += 0.005
    assert _scans(program, plate, 3) == [["Stop"], [], []], "page a holds a key"


@pytest.mark.parametrize("late_s", [0.1, 10.0])
def test_a_click_stays_pressed_until_the_next_scan_however_late(
    program: Program, plate: Plate, clock: _Clock, late_s: float
) -> None:
    """Source: docs/how-to/network.md, a key is TRUE for at least one scan."""
    plate.press("p", 1, ["Stop"])
    clock.now += 0.08
    plate.press("p", 2, [])
    clock.now += late_s
    assert _scans(program, plate, 3) == [["Stop"], [], []]


def test_a_silent_page_that_holds_keys_still_presses_only_stop(
    program: Program, plate: Plate, clock: _Clock
) -> None:
    """If a page is silent while it holds keys, only Stop is still pressed for a scan; a jog ends.

    Source: docs/how-to/network.md, a key is TRUE for at least one scan.
    """
    stop: list[list[str]] = [["JogPlus"], ["Stop", "JogPlus"], ["JogPlus"], [], ["JogPlus"]]
    for beat, keys in enumerate(stop):
        plate.press("p", beat, keys)
    plate.press("q", 1, ["Teach"])
    clock.now += HOLD_S - 0.1
    plate.press("q", 2, ["Teach"])
    clock.now += 0.2
    assert _scans(program, plate, 4) == [["Stop"], [], ["Teach"], ["Teach"]]


def test_a_silent_page_that_holds_stop_presses_it_for_a_scan(
    program: Program, plate: Plate, clock: _Clock
) -> None:
    """Source: docs/how-to/network.md, a key is TRUE for at least one scan."""
    plate.press("p", 1, ["Stop"])
    clock.now += HOLD_S + 0.01
    assert _scans(program, plate, 3) == [["Stop"], [], []]


def test_a_message_that_comes_too_late_does_not_press_again(program: Program, plate: Plate) -> None:
    plate.press("p", 2, [])
    plate.press("p", 1, ["JogPlus"])
    plate.exchange()
    assert _down(program) == []


@pytest.mark.parametrize("others", [0, 200])
def test_a_late_message_of_a_silent_page_does_not_press_again(
    program: Program, plate: Plate, clock: _Clock, others: int
) -> None:
    """A late message of a page that was silent presses no key again.

    Other pages may have connected in the meantime.

    Source: docs/how-to/network.md, a key is TRUE as long as it is held.
    """
    plate.press("p", 1, ["JogPlus"])
    plate.press("p", 3, [])
    assert _scans(program, plate, 2) == [["JogPlus"], []]
    for number in range(others):
        plate.press(f"p{number}", 1, [])
    clock.now += HOLD_S + 0.01
    plate.exchange()
    plate.press("p", 2, ["JogPlus"])
    assert _scans(program, plate, 2) == [[], []]


def test_two_pages_hold_their_own_keys(program: Program, plate: Plate, clock: _Clock) -> None:
    plate.press("a", 1, ["JogPlus"])
    plate.exchange()
    clock.now += 0.3
    plate.press("b", 1, ["Stop"])
    plate.exchange()
    assert _down(program) == ["Stop", "JogPlus"]
    clock.now += 0.3
    plate.exchange()
    assert _down(program) == ["Stop"], "page a is silent"


def test_a_key_that_a_stimulus_holds_is_left_alone(program: Program, plate: Plate) -> None:
    program.write("Main.Panel.Key.Teach", True)
    plate.press("p", 1, ["Start"])
    plate.exchange()
    assert _down(program) == ["Start", "Teach"]


def test_a_page_that_sends_too_much_ends_with_its_last_word(program: Program, plate: Plate) -> None:
    for beat in range(200):
        plate.press("p", beat, ["Start"] if beat % 2 else [])
    for _ in range(100):
        plate.exchange()
    assert _down(program) == ["Start"]


def test_a_stop_among_too_many_keys_is_pressed_for_a_scan(program: Program, plate: Plate) -> None:
    """Source: docs/how-to/network.md, a key is TRUE for at least one scan."""
    for beat in range(200):
        plate.press("p", beat, ["Stop"] if beat == 10 else ["Start"] if beat % 2 else [])
    assert _scans(program, plate, 100).count(["Stop"]) == 1
    assert _down(program) == ["Start"]


def test_only_so_many_pages_hold_keys(plate: Plate, clock: _Clock) -> None:
    for number in range(16):
        plate.press(f"p{number}", 1, ["Stop"])
    with pytest.raises(InputError, match="too many pages hold keys"):
        plate.press("one more", 1, ["Stop"])
    plate.press("one more", 1, [])
    plate.press("p3", 2, [])
    plate.press("one more", 2, ["Stop"])
    with pytest.raises(InputError, match="too many pages hold keys"):
        plate.press("p3", 3, ["Stop"])
    clock.now += HOLD_S + 0.01
    plate.press("p3", 3, ["Stop"])


def test_an_unknown_key_is_refused(plate: Plate) -> None:
    with pytest.raises(InputError, match="there is no key 'Begin'"):
        plate.press("p", 1, ["Begin"])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        *(("Automatic", True), ("Stepwise", True), ("Frame", "JOG_TOOL"), ("Units", "UNIT_MM")),
        *(("Language", "LANGUAGE_JAPANESE"), ("RobotNumber", 4), ("Axis", 6), ("Percent", 100)),
        *(("Amount", 10_000), ("Point", 29_999), ("ProgramNumber", 100)),
    ],
)
def test_a_selection_is_written_and_shown(
    program: Program, plate: Plate, name: str, value: object
) -> None:
    """Source: RCX_PANEL."""
    plate.choose(name, value)
    plate.exchange()
    assert program.read(f"Main.Panel.{name}") == value
    assert plate.shown()[name] == value


@pytest.mark.parametrize(
    ("name", "value", "takes"),
    [
        ("Automatic", 1, "true or false"),
        ("Frame", "JOG_UP", "JOG_PULSES, JOG_CARTESIAN, JOG_TOOL"),
        ("Frame", ["JOG_TOOL"], "JOG_PULSES"),
        ("Axis", 7, "0 to 6"),
        ("Axis", True, "0 to 6"),
        ("Percent", -1, "0 to 100"),
        ("Percent", None, "0 to 100"),
    ],
)
def test_a_value_that_a_selection_does_not_take_is_refused(
    plate: Plate, name: str, value: object, takes: str
) -> None:
    with pytest.raises(InputError, match=f"{name} cannot be .*use {takes}"):
        plate.choose(name, value)


def test_outputs_of_fb_operator_cannot_be_selected(plate: Plate) -> None:
    for name in ("Lamp", "Key", "MessageID", "Nothing"):
        with pytest.raises(InputError, match=f"there is no selection '{name}'"):
            plate.choose(name, True)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_message_is_shown_as_readable_text(engine: str, clock: _Clock) -> None:
    """Source: spec/errors.toml, 16#8001 in Japanese; STRING carries UTF-8."""
    program = _program(engine=engine)
    (plate,) = plates_of(program, clock)
    program.write("Main.Connected", False)
    plate.choose("Language", "LANGUAGE_JAPANESE")
    plate.exchange()
    program.scan(0)
    program.scan(10_000)
    plate.exchange()
    shown = plate.shown()
    assert (shown["name"], shown["Message"]["Name"]) == ("Main.Panel", "未接続")
    assert shown["Lamp"]["Connected"] is False
    assert shown["Position"] == [0.0] * 6


def _several(tmp_path: Path) -> Program:
    file = tmp_path / "Several.st"
    file.write_text(
        """FUNCTION_BLOCK FB_Side
  VAR_IN_OUT
    Given : RCX_PANEL;
  END_VAR
  VAR
    Own : RCX_PANEL;
  END_VAR
  Own.Axis := Given.Axis;
END_FUNCTION_BLOCK
PROGRAM Several
  VAR
    Left  : RCX_PANEL;
    Side  : FB_Side;
    Right : RCX_PANEL;
  END_VAR
  Side(Given := Left);
END_PROGRAM
""",
        encoding="utf-8",
    )
    return _program(file)


def test_every_panel_of_a_program_is_found_by_its_type(tmp_path: Path) -> None:
    """All panels of a program are found by their type, also inside a block.

    A pin through which a panel is passed is not a panel.
    """
    found = [plate.path for plate in plates_of(_several(tmp_path))]
    assert sorted(found) == ["Main.Left", "Main.Right", "Main.Side.Own"]


def test_a_program_without_a_panel_is_told_what_to_declare() -> None:
    program = _program(ROOT / "tests/data/library/Bench.st")
    with pytest.raises(InputError, match=r"--panel: the program has no variable .*RCX_PANEL"):
        plates_of(program)
