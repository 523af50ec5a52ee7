"""The page of a file has a drawing of each rung, with what was energised at some time."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from drawing import drawing
from network_elements import coil, contact, ladder
from structured_text import Bench
from structured_text.coverage.html import pages
from structured_text.coverage.measure import measure
from structured_text.coverage.parts import merge, part_of
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.language.source import Extract
from structured_text.projects.sources import SourceFiles

#: Network 1 of the program in `drawing`.
_RUNG = ladder(
    contact("1", "Start", "0"),
    contact("2", "Lamp", "0"),
    contact("3", "Stop", "1", "2", negated=True),
    coil("4", "Lamp", "3"),
    title="a<b & c",
)


@pytest.fixture
def page(tmp_path: Path) -> str:
    """Return the page after three scans in which Start is TRUE and Stop is FALSE."""
    plain = drawing(tmp_path)
    source = Extract.make(plain, plain.lines, plain.title, diagrams=(("Main", _RUNG),))
    collector = Collector(tmp_path)
    files = SourceFiles((source,), (), None)
    with counting(collector), Bench.build(files, engine="builtin") as bench:
        bench["Main.Start"] = True
        bench.scan(3)
    part = json.loads(json.dumps(part_of(collector)))
    made = pages(measure(merge([part]), tmp_path), "p")
    (text,) = (text for name, text in made.items() if name != "index.html")
    return text


def test_a_drawing_says_which_values_did_not_occur(page: str) -> None:
    """Start was always TRUE and Stop always FALSE. So Lamp was always TRUE as a coil.

    The contact of Lamp was FALSE in the first scan, and TRUE in the next ones.
    """
    (picture,) = re.findall(r"<svg.*?</svg>", page, re.DOTALL)
    root = ElementTree.fromstring(picture)
    texts = [one.text for one in root.iter("{http://www.w3.org/2000/svg}text")]
    assert texts[0] == "Network 1: a<b & c"
    assert sorted(text or "" for text in texts[1:]) == [
        "Lamp",
        "Lamp: never FALSE",
        "Start: never FALSE",
        "Stop: never TRUE",
    ]


def test_the_drawing_stands_between_the_heading_and_the_statements(page: str) -> None:
    heading, drawn = page.index(">Main, rung 1<"), page.index("<svg")
    assert heading < drawn < page.index("Lamp := (Start OR Lamp) AND NOT Stop;", heading)
    assert "a contact is thick if it was" in page
