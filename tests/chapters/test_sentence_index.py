"""For each section of the manual, there are at least as many tests as sentences."""

from __future__ import annotations

import ast
import re
from collections import Counter
from pathlib import Path

from rcx_harness.spec import signals

#: Number of sentences in each section that state a behaviour, counted by hand.
SENTENCES = {
    "1, 5": 1,  # about servo OFF at power-on
    "1, 5, 1": 4,  # about communication, SI(00) and SI(06), SAFETY connector, parallel I/O
    "1, 5, 2": 5,  # about communication, SI(00), SI(06), SAFETY connector, parallel I/O
    "1, 5, 2, first note": 1,
    "1, 5, 2, second note": 1,
    "1, 5, 3": 7,  # 2 causes, communication, SI(00), SI(06), SAFETY connector, parallel I/O
    "1, 5, 3, note": 1,
    "3, 1": 14,  # 4 conditions, servo OFF, 4 about a connection, 5 about a missing one
    "5, 2, SO(00)": 1,
    "5, 2, SO(01)": 1,
    "5, 2, SO(02)": 1,
    "5, 2, SO(03)": 1,
    "5, 2, SO(04)": 2,
    "5, 2, SO(10)": 2,
    "5, 2, SO(11)": 1,
    "5, 2, SO(12)": 1,
    "5, 2, SO(13)": 1,
    "5, 2, SO(14)": 2,
    "5, 2, SO(15)": 1,
    "5, 2, SO(20) to SO(157)": 1,
    "5, 2, SO(20) to SO(157) and note": 1,
    "5, 2, SI(00)": 2,
    "5, 2, SI(01)": 4,  # about switch-on, edge, SI(00), all emergency stops
    "5, 2, SI(06)": 2,
    "5, 2, SI(10)": 2,
    "5, 2, SI(12)": 2,
    "5, 2, SI(14)": 3,
    "5, 2, SI(15)": 3,
    "5, 2, SI(16)": 3,
    "5, 2, SI(17)": 2,  # about the two values of the parameter DI17 mode
    "5, 2, SI(17), ABS": 3,  # about switch-on, mark method, incomplete mark method
    "5, 2, SI(17), ABS and ABS/ORG": 1,  # SI(17) acts at its rising edge
    "5, 2, SI(17), ABS/ORG": 2,  # about the axes that move, and their order
    "5, 2, SI(17), first note": 1,
    "5, 2, SI(17), second note": 1,
    "5, 2, SI(17), last note": 1,
    "5, 2, SI(20) to SI(157)": 2,
    "5, 2, SIW(0)": 1,
    "5, 2, SIW(1)": 1,
    "5, 2, SIW(2) to SIW(15)": 1,
    "5, 2, SIW(2) to SIW(15), SIW(24) to SIW(127)": 1,
    "5, 2, SID(2) to SID(14), SID(24) to SID(126)": 1,
    "5, 2, SOW(0) and SOW(1)": 1,
    "5, 2, SOW(2) to SOW(15)": 1,
    "5, 2, SOW(2) to SOW(15), SOW(24) to SOW(127)": 1,
    "5, 2, SOD(2) to SOD(14), SOD(24) to SOD(126)": 1,
    "5, 3.1": 1,  # about servo OFF at power-on
    "5, 3.1, caution": 5,  # 100 ms, shorter, same input, different inputs, answered inputs
    "5, 3.1, initial servo ON process": 3,
    "5, 3.1, shift to emergency stop": 1,
    "5, 3.1, servo ON process from emergency stop status": 2,
    "5, 3.2, AUTO mode changeover process": 2,
    "5, 3.2, program reset process": 2,
    "5, 3.2, program execution process": 1,
    "5, 3.2 and 3.3, program execution process": 1,
    "5, 3.2, note": 1,
    "5, 3.3, program execution process": 1,
    "5, 3.3, program stop process using stop input": 1,
    "5, 3.3, program execution after stopping program with stop input": 1,
    "5, 3.3, note": 2,
}


def _sections() -> Counter[str]:
    """Count the tests of each section by the `Source:` lines of their docstrings."""
    found: Counter[str] = Counter()
    for file in Path(__file__).parent.glob("test_chapter_*.py"):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
                text = ast.get_docstring(node) or ""
                sources = re.search(r"Source: manual (.+?)\.?\Z", " ".join(text.split()))
                assert sources, f"{file.name}: {node.name} has no source"
                parts = sources[1].split("; ")
                found.update(part.removeprefix("chapter ") for part in parts)
    return found


def test_every_sentence_of_chapters_1_5_and_3_1_and_5_2_and_5_3_has_a_test() -> None:
    found = _sections()
    missing = {
        section: f"{found[section]} tests, {count} sentences"
        for section, count in SENTENCES.items()
        if found[section] < count
    }
    assert not missing


def test_every_dedicated_signal_has_a_test_of_its_own_section() -> None:
    found = _sections()
    every = (*signals().output, *signals().input)
    assert [one.signal for one in every if not found[f"5, 2, {one.signal}"]] == []
