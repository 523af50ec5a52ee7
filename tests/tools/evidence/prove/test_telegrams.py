"""The proofs that telegrams are legal use the second reading, and detect seeded bugs."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import z3

from example_pins import EXAMPLE_BLOCKS, given_pins
from pin_reading import Pins, every_block
from plc_bench import ROOT
from rcx_tools.evidence.prove import telegrams
from rcx_tools.evidence.prove.legality import legal
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.pin_telegrams import Expected
from rcx_tools.evidence.prove.solve import ask
from second_reading import every_reading
from structured_text.engines.base import Value
from structured_text.output.toml_files import load_toml
from structured_text.prove.logic import PROVED
from structured_text.prove.texts import Text

_BUGS = {
    bug["name"]: bug
    for bug in load_toml(ROOT / "tests/tools/evidence/proof_bugs/telegrams.toml")["bug"]
}


@cache
def _examples() -> Mapping[int, tuple[dict[str, Any], list[int]]]:
    """Return the values in the text of each worked example, and its 16 words, without misprints."""
    found = {}
    for one in load_toml(ROOT / "tests/data/worked_examples.toml")["example"]:
        words = [int(word, 16) for word in one.get("meant_command", one["command"]).split()]
        found[one["number"]] = (one["given"], words + [0] * (16 - len(words)))
    return found


def _is_legal(words: Sequence[int]) -> bool:
    code, *data = (z3.BitVecVal(word, 16) for word in words)
    return bool(z3.is_true(z3.simplify(legal(code, data, [words[0] & 0xFFF]))))


def test_each_worked_example_is_legal() -> None:
    """Source: remote command guide 4.2.1 to 4.9.3, the worked examples."""
    wrong = [number for number, (_, words) in _examples().items() if not _is_legal(words)]
    assert not wrong
    assert len(_examples()) == 100


@pytest.mark.exhaustive
def test_proof_and_second_reading_agree_on_a_changed_bit_of_an_example() -> None:
    """If a bit of an example is changed, proof and second reading agree whether it is legal.

    One bit makes the telegram illegal. Another bit, if there is one, keeps it legal.

    Source: remote command guide 4.2.1 to 4.9.3, the tables of the commands.
    """
    wrong = []
    for number, (_, words) in _examples().items():
        reading = every_reading()[words[0] & 0xFFF]
        wanted = {True, False}
        for step in range(30):
            place = (97 * number + 41 * step) % 240
            changed = list(words)
            changed[1 + place // 16] ^= 1 << place % 16
            good = not reading.problem(changed)
            if good in wanted:
                wanted.remove(good)
                if _is_legal(changed) is not good:
                    wrong.append(f"{number}: bit {place % 16} of n+{2 + place // 16 * 2}")
        assert False not in wanted, f"{number}: every change is legal"
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize(
    ("number", "words", "good"),
    [
        (1, {2: 0xC000}, False),  # 4.2.1: position in pulses and in mm
        (1, {2: 0x8000}, True),
        (1, {2: 0x0020, 20: 0}, False),  # acceleration is 1 to 100 if it is designated
        (1, {2: 0x0020, 20: 100}, True),
        (1, {2: 0x0002, 6: 10001}, False),  # speed is at most 100.00 %
        (1, {2: 0x0002, 6: 10000}, True),
        (2, {4: 0x0300}, False),  # only one arch axis
        (32, {4: 101}, False),  # 4.2.14: 1 to 100 %
        (42, {16: 0xFC17}, False),  # 4.2.23: -1000 to 1000 %; this is -1001
        (42, {16: 0xFC18}, True),
        (47, {8: 0x7F41}, False),  # 4.3.2: characters 0x20 to 0x7E
        (47, {20: 0x0000, 22: 0x2020}, False),  # only 0x00 after a 0x00
        (47, {20: 0x0000, 22: 0x0000}, True),
        (49, {6: 181, 8: 181, 10: 1}, True),  # 4.3.3: 181 * 181 = 32761
        (49, {6: 182, 8: 182, 10: 1}, False),
        (49, {6: 0x4000, 8: 0x4000, 10: 0x10}, False),  # 2 ^ 32
        (56, {4: 32}, False),  # 4.4.1: 0 to 31 and 256 to 287
        (56, {4: 256}, True),
        (60, {4: 267, 6: 1, 8: 32768}, False),  # 4.4.2: push time is at most 32767 ms
        (60, {4: 261, 6: 1, 8: 1}, False),  # this parameter does not exist
        (67, {4: 0x1080}, False),  # 4.5.1: port 8 does not exist
        (67, {4: 0x0020}, False),  # DI cannot be written
        (73, {12: 0x6141}, False),  # 4.6.3: upper case letters, digits and _
        (73, {12: 0x2041}, False),  # no space inside a name
    ],
)
def test_a_value_beyond_its_limits_is_illegal(
    number: int, words: dict[int, int], good: bool
) -> None:
    """A telegram with a value beyond its limits is illegal.

    The telegram is one of the worked examples, with other words n+2 to n+30.

    Source: remote command guide 4.2.1, 4.2.14, 4.2.23, 4.3.2, 4.3.3, 4.4.1, 4.4.2, 4.5.1, 4.6.3.
    """
    changed = list(_examples()[number][1])
    for at, word in words.items():
        changed[at // 2] = word
    assert _is_legal(changed) is good


@pytest.mark.parametrize("number", [1, 29, 42, 67, 94])
def test_a_robot_that_does_not_exist_is_illegal(number: int) -> None:
    """A telegram for a robot that does not exist is illegal.

    Robots 1 to 4 exist if the section has a robot designation, otherwise none.

    Source: remote command guide 1.1, and the tables of 4.2.1, 4.2.12, 4.2.23, 4.5.1 and 4.8.1.
    """
    words = list(_examples()[number][1])
    highest = 0 if number in (67, 94) else 4
    for robot in range(16):
        words[0] = words[0] & 0xFFF | robot << 12
        assert _is_legal(words) is (robot <= highest), f"robot {robot}"


@dataclass(frozen=True)
class _Known:
    """A call of a block whose pins have known values."""

    reading: Pins
    given: Mapping[str, Value]

    def pin(self, name: str, place: int = 0) -> Any:
        value = self.given[name]
        one = value[place] if isinstance(value, list) else value
        rows = [row for row in self.reading.inputs if row.pin == name]
        if isinstance(one, bool):
            return z3.BoolVal(one)
        if isinstance(one, float):
            return z3.BitVecVal(struct.unpack("<I", struct.pack("<f", one))[0], 32)
        if isinstance(one, int):
            wide = rows and rows[0].places[0].width == 32
            return z3.BitVecVal(one, 32 if wide else 16)
        assert isinstance(one, str)
        codes = one.encode()
        return Text(
            z3.BitVecVal(len(codes), 16),
            126,
            lambda i: z3.BitVecVal(codes[i] if i < len(codes) else 0, 8),
        )

    def member(self, name: str, member: str) -> Any:
        return z3.BoolVal(self.given[name] == member)


@pytest.mark.parametrize("number", [*range(1, 101)])
def test_the_pins_of_an_example_give_its_words(number: int) -> None:
    """Source: remote command guide 4.2.1 to 4.9.3, the worked examples."""
    name, more = EXAMPLE_BLOCKS[number]
    given, words = _examples()[number]
    reading = every_block()[name]
    pins: dict[str, Value] = {"RobotNumber": 0}
    pins |= {row.pin: row.initial for row in reading.inputs}
    if reading.select[0]:
        pins[reading.select[0]] = reading.select[1]
    expected = Expected(_Known(reading, pins | given_pins(name, given) | more), reading)
    said = [z3.simplify(word).as_long() for word in (expected.code(), *expected.data())]
    assert said == words


def _library(folder: Path, block: str, bug: str = "") -> Library:
    """Return the part of plc/lib that one block needs, perhaps with a bug."""
    whole = Library((ROOT / "plc/lib").resolve())
    sources = {file.stem: file for file in sorted(whole.folder.rglob("*.st"))}
    needed, waiting = set(), [block]
    while waiting:
        name = waiting.pop()
        if name not in needed:
            needed.add(name)
            text = sources[name].read_text(encoding="utf-8")
            waiting += [other for other in sources if other in text]
    for name in needed:
        target = folder / sources[name].relative_to(whole.folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(sources[name], target)
    if bug:
        file = folder / _BUGS[bug]["file"]
        text = file.read_text(encoding="utf-8")
        assert text.count(_BUGS[bug]["old"]) == 1
        file.write_text(text.replace(_BUGS[bug]["old"], _BUGS[bug]["new"]), encoding="utf-8")
    return Library(folder.resolve())


def _not_proved(library: Library, block: str) -> dict[str, list[str]]:
    """Return for each property the goals that are not proved."""
    return {
        item.name: [
            goal.name
            for goal in item.goals(library, block.upper())
            if ask(goal.assumed, goal.claim, 20).status != PROVED
        ]
        for item in telegrams.PROPERTIES
    }


@pytest.mark.exhaustive
def test_the_telegrams_of_a_block_are_legal_and_agree_with_the_pins(tmp_path: Path) -> None:
    """Source: remote command guide 4.4.4."""
    block = "FB_AssignPointElementMm"
    assert not any(_not_proved(_library(tmp_path, block), block).values())


@pytest.mark.exhaustive(but=["torque-up-to-1000"])
@pytest.mark.parametrize("bug", ["torque-up-to-1000", "rounded-before-it-is-scaled"])
def test_a_bug_breaks_the_property_that_it_should_and_no_other(bug: str, tmp_path: Path) -> None:
    """Source: remote command guide 4.2.22 and 4.4.4."""
    block = Path(_BUGS[bug]["file"]).stem
    found = _not_proved(_library(tmp_path, block, bug), block)
    assert [name for name, goals in found.items() if goals] == _BUGS[bug]["breaks"]
