"""The blocks agree with the 100 worked examples of the guide.

The pins have the values that an example describes. The sent words, and the outputs for the printed
answer, must be those of the guide. If the words and the text of an example contradict each other,
`differs` in tests/data/worked_examples.toml says what is right.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import pytest

from block_answers import blank, same
from both_engines import ENGINES
from command_bench import BLOCKS, CommandBench, bench_of
from example_pins import EXAMPLE_BLOCKS, answer_pins, given_pins
from plc_bench import ROOT
from structured_text.engines.base import Value
from structured_text.output.toml_files import load_toml

_EXAMPLES: dict[int, dict[str, Any]] = {
    one["number"]: one for one in load_toml(ROOT / "tests/data/worked_examples.toml")["example"]
}
_JOGS = [number for number, (name, _) in EXAMPLE_BLOCKS.items() if name == "FB_Jog"]
_OTHERS = [number for number in EXAMPLE_BLOCKS if number not in _JOGS]


def _words(text: str) -> list[int]:
    words = [int(word, 16) for word in text.split()]
    return words + [0] * (16 - len(words))


def _compare(plc: CommandBench, expected: Mapping[str, Value]) -> None:
    for name, value in expected.items():
        assert same(plc.pin(name), value), f"{name} is {plc.pin(name)}, not {value}"


@pytest.mark.parametrize("engine", ENGINES, scope="module")
@pytest.mark.parametrize("number", _OTHERS)
def test_the_block_sends_the_words_of_the_example_and_reads_its_answer(
    engine: str, number: int
) -> None:
    """The block sends the printed words, and shows the printed answer.

    Source: remote command guide 4.2.1 to 4.9.3, the worked examples.
    """
    example = _EXAMPLES[number]
    name, more = EXAMPLE_BLOCKS[number]
    plc = bench_of(name, engine)
    given = given_pins(name, example["given"])
    answer = answer_pins(name, example.get("answer", {}))
    answers: Sequence[str] = [example["response"], example.get("meant_response", "")]
    for printed in filter(None, answers):
        status, *response = _words(printed)
        words = plc.send({**given, **more})
        assert words == _words(example.get("meant_command", example["command"]))
        plc.end(status, response)
        assert plc.pin("Done")
        _compare(plc, {**blank(BLOCKS[name]), **answer})
        plc.finish()


@cache
def _jog(engine: str) -> CommandBench:
    return CommandBench(["FB_Jog"], engine)


@pytest.mark.parametrize("engine", ENGINES, scope="module")
@pytest.mark.parametrize("number", _JOGS)
def test_a_jog_sends_the_words_of_the_example_and_shows_its_position(
    engine: str, number: int
) -> None:
    """A jog sends the printed words, and shows the position of its end with alarm 12.400.

    The block itself turns SI(06) OFF, which ends the jog.

    Source: remote command guide 4.2.6, examples
    """
    example = _EXAMPLES[number]
    name, more = EXAMPLE_BLOCKS[number]
    status, *response = _words(example["response"])
    answer = dict(example["answer"])
    assert (status, answer.pop("alarm")) == (0x4000, "12.400")
    plc = _jog(engine)
    plc.choose(name)
    plc.set({**given_pins(name, example["given"]), **more, "Enable": True})
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc.words == _words(example["command"])
    plc.answer(0x0100, scans=1)
    plc.set({"Enable": False})
    plc.scan()
    assert plc.inputs == ["SI00"]
    plc.end(status, response)
    assert not plc.pin("Error")
    neither = {"Pulses": [0] * 6, "PositionMm": [0.0] * 6}
    _compare(plc, {**neither, **answer_pins(name, answer)})


def test_all_hundred_examples_have_a_block() -> None:
    """Each of the 100 examples has a block, and six examples are corrected.

    Source: remote command guide 4.2.1 to 4.9.3, the worked examples.
    """
    assert list(EXAMPLE_BLOCKS) == sorted(_EXAMPLES) == list(range(1, 101))
    corrected = {number for number, one in _EXAMPLES.items() if "meant_command" in one}
    assert corrected == {29, 42, 43, 44, 47, 73}
    for number in corrected:
        example = _EXAMPLES[number]
        assert _words(example["meant_command"]) != _words(example["command"])
        assert example["differs"]
