"""Random routines with jumps behave as an interpreter that goes from rung to rung.

The interpreter executes JMP as a controller does: it goes on at the label, and knows nothing of
loops and guards.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from l5x_ladder import program, read, written
from structured_text.projects.model import Foreign

_BITS = "abcd"
#: A rung: its label, the conditions of its jump, the target, and the number that it adds.
_Rung = tuple[bool, str, int, int]
_LIMIT = 12


def _rungs(rng: random.Random, count: int) -> list[_Rung]:
    found: list[_Rung] = []
    for number in range(count):
        bit = rng.choice(_BITS) if rng.random() < 0.6 else ""
        found.append((rng.random() < 0.7, bit, rng.randrange(count), number + 1))
    return found


def _texts(rungs: list[_Rung]) -> list[str]:
    texts = ["CLR(k);"]
    for number, (_, bit, target, added) in enumerate(rungs):
        text = f"LBL(L{number})CPT(i,(i * 7 + {added}) MOD 100003)"
        if bit:
            back = target <= number
            limit = f"ADD(k,1,k)LES(k,{_LIMIT})" if back else ""
            text += f"[{limit}XIC({bit})JMP(L{target})OTU({bit}),CPT(j,(j * 5 + {added}) MOD 1009)]"
        texts.append(f"{text};")
    return texts


def _execute(rungs: list[_Rung], state: dict[str, int]) -> None:
    state["k"], number = 0, 0
    while number < len(rungs):
        _, bit, target, added = rungs[number]
        state["i"] = (state["i"] * 7 + added) % 100003
        if bit:
            jumps = True
            if target <= number:
                state["k"] += 1
                jumps = state["k"] < _LIMIT
            if jumps and state[bit]:
                number = target
                continue
            state["j"] = (state["j"] * 5 + added) % 1009
        number += 1


@pytest.mark.parametrize("seed", range(8))
def test_random_jumps_go_to_their_labels(tmp_path: Path, seed: int) -> None:
    """Jumps cross each other, and lead into and out of loops; five scans with random conditions.

    The rest of a rung behind a jump, also other legs of its branch, is not executed.
    """
    rng = random.Random(seed)
    rungs = _rungs(rng, 9)
    running = program(written(tmp_path, _texts(rungs)))
    state = dict.fromkeys([*_BITS, "i", "j", "k"], 0)
    for scan in range(5):
        for bit in _BITS:
            state[bit] = int(rng.random() < 0.5)
            running.write(f"Main.{bit}", bool(state[bit]))
        running.scan(scan * 10_000)
        _execute(rungs, state)
        assert {name: running.read(f"Main.{name}") for name in state} == state


def test_each_line_of_a_jump_names_its_rungs(tmp_path: Path) -> None:
    """The guard is executed if rung 1 is skipped, so it is not a part of rung 1."""
    rungs = ["XIC(a)JMP(Over);", "OTE(b);", "LBL(Over)OTE(c);", "XIC(d)JMP(Over);"]
    (unit,) = [one for one in read(written(tmp_path, rungs)).units if one.kind == "PROGRAM"]
    body = unit.piece.body
    assert not isinstance(body, Foreign)
    found = {line.text.strip(): line.network for line in body}
    assert found["RcxSkip_Over := FALSE;"] == "jumps"
    assert found["IF NOT RcxSkip_Over THEN"] == "jump over rung 1"
    assert found["REPEAT"] == found["END_REPEAT;"] == "loop of rung 2 to rung 3"
    assert [line.text for line in body if not line.network] == ["  RcxPrescan();"]
