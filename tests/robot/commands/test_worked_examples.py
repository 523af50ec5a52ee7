"""The controller answers the 100 worked examples with their printed answers.

tests/data/worked_examples.toml has the words, and the initial state that the guide's prose assumes.
Its `differs` entries say where the printed words and the prose disagree.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from example_states import found, in_state
from robot_master import NORMAL_END, Master, abnormal_end
from structured_text.output.toml_files import load_toml

_FILE = Path(__file__).resolve().parents[2] / "data" / "worked_examples.toml"
EXAMPLES: Mapping[int, Mapping[str, Any]] = {
    example["number"]: example for example in load_toml(_FILE)["example"]
}
JOGS = [number for number, example in EXAMPLES.items() if "stopped_by" in example.get("state", {})]
OTHERS = [number for number in EXAMPLES if number not in JOGS]

#: Examples in which print and prose disagree, with the controller's reaction to the printed words.
HOLDS, SAME, REFUSED, KNOB, NONE = (
    "the print holds",
    "the printed words and the words of the prose end alike",
    "the printed words are refused, the words of the prose are accepted",
    "the printed answer needs a name that is filled with zeros",
    "no answer is printed, so the section's table gives it",
)
DIFFERENT = {
    9: HOLDS,  # The prose names the target point of another example.
    10: HOLDS,  # The prose does not give the unit of the output.
    29: SAME,  # 0x0032 is all robots, 0x1032 robot 1; there is only one robot.
    42: SAME,  # Push force and time are 50 in print, 100 in the prose.
    43: SAME,  # the same
    44: SAME,  # the same
    47: SAME,  # A comment may be filled with zeros or with spaces.
    54: HOLDS,  # The robot number is in a word that is described as not used.
    57: HOLDS,  # The command adds, it does not assign.
    70: HOLDS,  # The command reads an input, so that nothing is output.
    72: HOLDS,  # The task number has no effect with this method.
    73: REFUSED,  # The flag is 0x0100, but its bits 15 to 3 are fixed 0.
    74: KNOB,  # A name may be filled with zeros or with spaces.
    79: HOLDS,  # Bit 0 of the flag is 1, although it is not used.
    92: HOLDS,  # 2:334 means 2.334.
    97: HOLDS,  # The label of WI1 is also used for WI3.
    98: NONE,
}


def _words(text: str) -> tuple[int, ...]:
    words = tuple(int(word, 16) for word in text.split())
    return words + (0,) * (16 - len(words))


def _meant(example: Mapping[str, Any], side: str) -> tuple[int, ...]:
    """Return the words of `command` or `response`, corrected where the print is wrong."""
    return _words(example.get(f"meant_{side}", example[side]))


def _section(number: int) -> str:
    return f"{number:03}: {EXAMPLES[number]['section']} {EXAMPLES[number]['title']}"


@pytest.mark.parametrize("number", OTHERS, ids=_section)
def test_the_command_of_the_example_is_answered_as_printed(number: int) -> None:
    """All words from m to m+30 agree with the print, and no rule is violated.

    The controller also has the effect that the prose describes.

    Rule: versions, flag-bit-0, millimetres.
    Source: remote command guide 4.2.1 to 4.9.3, examples
    """
    example = EXAMPLES[number]
    master = in_state(example.get("state", {}))
    assert master.execute(*_meant(example, "command")) == _meant(example, "response")
    effect = example.get("effect", {})
    assert found(master, effect) == effect
    assert not master.texts()


def _jog(example: Mapping[str, Any], start: list[int]) -> tuple[Master, tuple[int, ...]]:
    """Jog from `start` until the stop input goes OFF after 100 ms, and return the words."""
    state = example["state"]
    master = in_state({"start_pulses": start})
    master.send(*_words(example["command"]))
    master.run(100)
    assert master.status == 0x0100
    master.turn(state["stopped_by"], False)
    return master, master.finish()


@pytest.mark.parametrize("number", JOGS, ids=_section)
def test_the_jog_of_the_example_stops_with_12_400_where_the_print_says(number: int) -> None:
    """The start position is not printed, so a first jog measures where the second jog must start.

    Rule: jog-stop.
    Source: remote command guide 4.2.6, examples
    """
    example = EXAMPLES[number]
    state = example["state"]
    place = [round(1000 * v) for v in state.get("stopped_mm", ())] or state["stopped_pulses"]
    first, _ = _jog(example, place)
    way = first.robot.positions[0] - place[0]
    assert way < 0, "axis 1, minus direction"
    master, answer = _jog(example, [place[0] - way, *place[1:]])
    assert answer == _words(example["response"])
    assert master.robot.positions == place[:4]
    master.send()
    master.turn(state["stopped_by"], True)
    master.run(150)
    assert master.status == 0


def test_the_table_names_every_example_where_print_and_prose_disagree() -> None:
    """The table has exactly the examples with a `differs` entry.

    If the printed words differ, the table has their result.
    """
    assert {number for number, example in EXAMPLES.items() if "differs" in example} == {*DIFFERENT}
    meant = {number for number, example in EXAMPLES.items() if "meant_command" in example}
    assert meant == {number for number, what in DIFFERENT.items() if what in (SAME, REFUSED)}
    assert [*EXAMPLES] == [*range(1, 101)]


@pytest.mark.parametrize(
    "number", [number for number, what in DIFFERENT.items() if what == SAME], ids=_section
)
def test_the_printed_command_ends_as_the_meant_one(number: int) -> None:
    """Source: remote command guide 4.2.12, 4.2.23, 4.3.2, examples."""
    example = EXAMPLES[number]
    master = in_state(example.get("state", {}))
    assert _words(example["command"]) != _meant(example, "command")
    assert master.execute(*_words(example["command"])) == _words(example["response"])
    effect = example.get("effect", {})
    assert found(master, effect) == effect


def test_a_flag_whose_fixed_bits_are_set_resets_no_program() -> None:
    """The example prints 0x0100, but bits 15 to 3 are fixed 0.

    Source: remote command guide 4.6.3, command flag
    """
    (number,) = (number for number, what in DIFFERENT.items() if what == REFUSED)
    example = EXAMPLES[number]
    master = in_state(example["state"])
    assert master.execute(*_words(example["command"])) == abnormal_end("4.2")
    before = [{"program": 1, "task": 1, "priority": 32, "line": 5}]
    assert found(master, {"registered": before}) == {"registered": before}


def test_a_program_name_may_be_filled_with_zeros_as_printed() -> None:
    """Rule: program-info-details. Source: remote command guide 4.6.4, example."""
    (number,) = (number for number, what in DIFFERENT.items() if what == KNOB)
    example = EXAMPLES[number]
    master = in_state(example["state"], name_filler="zeros")
    assert master.execute(*_words(example["command"])) == _words(example["response"])


def test_where_no_answer_is_printed_it_is_a_normal_end_without_data() -> None:
    """Source: remote command guide 4.9.1, status."""
    (number,) = (number for number, what in DIFFERENT.items() if what == NONE)
    assert EXAMPLES[number]["response"] == ""
    assert _meant(EXAMPLES[number], "response") == NORMAL_END


def test_the_push_of_the_print_lasts_50_ms_and_that_of_the_prose_100_ms() -> None:
    """The time counts from the moment when the axis reaches the workpiece.

    Source: remote command guide 4.2.23, examples, push time-period
    """
    example = EXAMPLES[44]
    for words, ms in ((example["command"], 50), (example["meant_command"], 100)):
        master = in_state(example["state"])
        master.send(*_words(words))
        while master.robot.positions[2] != example["state"]["workpiece"]["pulses"]:
            master.run(5)
        since_us = master.now_us
        master.finish()
        assert master.now_us - since_us == ms * 1000


def test_the_move_to_point_19_of_chapter_2_ends_normally() -> None:
    """The command requests no position, so all response words are 0.

    Source: remote command guide chapter 2, example
    """
    master = in_state({"points": {"19": {"pulses": [100000, 0, 0, 0, 0, 0]}}})
    assert master.execute(0x0001, 0x0004, 0x0000, 0x0032, 0x0013) == NORMAL_END
    assert master.robot.positions == [100000, 0, 0, 0]
