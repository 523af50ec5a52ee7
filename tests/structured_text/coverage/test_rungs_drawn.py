"""The coverage page of an L5X draws its rungs, with what was energised at some time."""

from __future__ import annotations

import json
import re
from xml.etree import ElementTree

import pytest

from l5x_ladder import written
from structured_text import Bench
from structured_text.coverage.html import pages
from structured_text.coverage.measure import FileResult, measure
from structured_text.coverage.parts import merge, part_of
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.projects.sources import source_files

_RUNGS = (
    "XIC(a)XIO(b)[OTE(e),MOV(1,i)];",
    "XIC(a)XIC(b)[OTL(f),MOV(2,i)];",
    "EQU(i,1)XIC(a)TON(T1,1000,0);",
    "OTE(h);",
    "XIC(c)TON(T2,1000,0);",
)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> FileResult:
    """Return the coverage of two scans in which a is TRUE and b is FALSE."""
    folder = tmp_path_factory.mktemp("cell")
    file = written(folder, _RUNGS, tags={"T1": "TIMER", "T2": "TIMER"})
    collector = Collector(folder)
    with (
        counting(collector),
        Bench.build(source_files([file], None), engine="builtin") as bench,
    ):
        bench["Main.a"] = True
        bench.scan(2)
    part = json.loads(json.dumps(part_of(collector)))
    (found,) = measure(merge([part]), folder)
    return found


def _pictures(result: FileResult) -> list[ElementTree.Element]:
    (text,) = (text for name, text in pages([result], "p").items() if name != "index.html")
    return [ElementTree.fromstring(one) for one in re.findall(r"<svg.*?</svg>", text, re.DOTALL)]


def _texts(picture: ElementTree.Element) -> list[str]:
    return [one.text or "" for one in picture.iter("{http://www.w3.org/2000/svg}text")]


def _never(picture: ElementTree.Element) -> list[str]:
    return sorted(text for text in _texts(picture) if "never" in text)


def test_each_rung_is_drawn(result: FileResult) -> None:
    assert [_texts(one)[0] for one in _pictures(result)] == [f"Rung {k}" for k in range(5)]


def test_the_drawing_says_what_was_not_energised(result: FileResult) -> None:
    """In rung 0 all had power. Rung 1 never had power behind b. Rung 3 has no condition.

    The only contact in front of a box is a condition, too.
    """
    first, second, third, fourth, last = _pictures(result)
    assert _never(first) == ["a: never FALSE", "b: never TRUE", "e: never FALSE"]
    assert _never(second) == ["a: never FALSE", "b: never TRUE", "f: never set", "never executed"]
    assert _never(third) == ["a: never FALSE", "never FALSE", "never FALSE"]
    assert _never(fourth) == ["h: never FALSE"]
    assert _never(last) == ["c: never TRUE", "never TRUE"]


def test_a_box_with_power_has_a_thick_frame(result: FileResult) -> None:
    """MOV of rung 0 was executed, and MOV of rung 1 was not. EQU and TON had power."""
    frames = [
        [one.get("class") for one in picture.iter("{http://www.w3.org/2000/svg}rect")][1:]
        for picture in _pictures(result)
    ]
    assert frames == [["line on"], ["line"], ["line on", "line on"], [], ["line"]]


def test_functions_of_instructions_are_not_counted(result: FileResult) -> None:
    """The function for TON has 5 branches at least; all branches here are those of rungs 0 and 1.

    The prescan of the program has further ones. It is executed once.
    """
    rungs = [one for one in result.branches if "rung" in result.networks.get(one.line, "")]
    assert len(rungs) == 4
    assert not [one for one in result.branches if "Timer." in one.text]
