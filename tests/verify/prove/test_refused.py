"""A construct that has no solver terms is refused with its name, and never approximated."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.evidence.prove.agreement.bench import Subject
from rcx_tools.evidence.prove.agreement.comparing import agree
from structured_text.prove.logic import UnsupportedError

_REFUSED = {
    "R := SIN(R);": "the standard function SIN",
    "R := LN(R);": "the standard function LN",
    "R := R ** R;": "[*][*] of REAL",
    "S := RIGHT(S, 2);": "the standard function RIGHT",
    "S := INSERT(S, 'a', 1);": "the standard function INSERT",
    "S := DELETE(S, 1, 1);": "the standard function DELETE",
    "S := REPLACE(S, 'a', 1, 1);": "the standard function REPLACE",
    "I := FIND(S, S);": "FIND searches a text",
    "S := INT_TO_STRING(I);": "INT_TO_STRING",
    "I := STRING_TO_INT(S);": "STRING_TO_INT",
    "D := DT_TO_DATE(M);": "the conversion DT_TO_DATE needs a constant",
    "I := 0; WHILE I < 5000 DO I := I + 1; END_WHILE;": "a loop has more than 4096 rounds",
}


@pytest.mark.parametrize("body", _REFUSED)
def test_a_function_without_terms_is_refused_by_name(tmp_path: Path, body: str) -> None:
    file = tmp_path / "tried.st"
    file.write_text(
        "FUNCTION_BLOCK FB_TRIED\n"
        "  VAR R : REAL; S : STRING; I : INT; D : DATE; M : DT; END_VAR\n"
        f"  {body}\nEND_FUNCTION_BLOCK\n"
    )
    with pytest.raises(UnsupportedError, match=_REFUSED[body]):
        agree(Subject.of([file]), "FB_TRIED", 1)
