"""Instructions for texts in ladder of an L5X.

Source: Rockwell 1756-RM003, ASCII string instructions.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import main_body, program, written
from structured_text.projects.model import Foreign

_TAGS = dict.fromkeys(("p", "q", "r"), "STRING")


@pytest.mark.parametrize(
    ("rung", "expected"),
    [
        ("MOVE('abc',r);", "abc"),
        ("MOVE('ab',p)MOVE('cd',q)CONCAT(p,q,r);", "abcd"),
        ("MOVE('abcdef',p)MID(p,2,3,r);", "cd"),
        ("MOVE('abcdef',p)DELETE(p,2,3,r);", "abef"),
        ("MOVE('abef',p)MOVE('cd',q)INSERT(p,q,3,r);", "abcdef"),
        ("DTOS(-120,r);", "-120"),
        ("RTOS(2.5,r);", "2.5"),
        ("MOVE('abcabc',p)MOVE('bc',q)FIND(p,q,3,i)EQU(i,5)MOVE('found',r);", "found"),
        ("XIC(a)MOVE('abc',r);", ""),
        ("MOVE('ab',p)MOVE('ab',q)EQU(p,q)MOVE('same',r);", "same"),
    ],
)
def test_a_text_is_made(tmp_path: Path, rung: str, expected: str) -> None:
    """The start of a part is counted from 1; without power nothing is written."""
    running = program(written(tmp_path, [rung], tags=_TAGS))
    running.scan(0)
    assert running.read("Main.r") == expected


@pytest.mark.parametrize(
    ("rung", "why"),
    [
        ("CONCAT(p,?,r);", "rung 0: CONCAT has no Source B"),
        ("CONCAT(p,q);", "rung 0: CONCAT has 2 operands, not 3: Source A, Source B, Destination"),
        ("CONCAT(p,i,r);", "rung 0: a text is needed here"),
        ("DTOS(1,i);", "rung 0: i is not a tag for a single number"),
    ],
)
def test_a_wrong_text_operand_is_named(tmp_path: Path, rung: str, why: str) -> None:
    """The reason has the rung and the operand."""
    body = main_body(written(tmp_path, [rung], tags=_TAGS))
    assert isinstance(body, Foreign)
    assert body.why.startswith(why)
