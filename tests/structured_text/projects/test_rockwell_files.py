"""Copies, bit fields and shifts of ladder routines in an L5X, and instructions that are refused.

Expected values are computed by hand from Rockwell 1756-RM003N.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import main_body, program, read, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_MORE = {
    "other": "DINT[4]",
    "words": "INT[4]",
    "wide": "DINT[2]",
    "ctl": "CONTROL",
    "tm": "TIMER",
    "tms": "TIMER[2]",
}


def _program(folder: Path, *rungs: str, **values: int) -> BuiltinProgram:
    running = program(written(folder, rungs, tags=_MORE))
    for name, value in values.items():
        running.write(f"Main.{name}", value)
    return running


def _list(running: BuiltinProgram, name: str, size: int) -> list[object]:
    return [running.read(f"Main.{name}[{number}]") for number in range(size)]


def test_cop_copies_elements_from_an_index(tmp_path: Path) -> None:
    """Elements 1 and 2 of `list` go to the elements 2 and 3 of `other`."""
    running = _program(tmp_path, "COP(list[1],other[2],2);")
    for number in range(8):
        running.write(f"Main.list[{number}]", 10 + number)
    running.scan(0)
    assert _list(running, "other", 4) == [0, 0, 11, 12]


def test_cop_ends_at_the_end_of_the_destination(tmp_path: Path) -> None:
    """A length of 100 copies 4 elements, also if it is a tag. Source: 1756-RM003N, page 371."""
    running = _program(tmp_path, "COP(list[0],other[0],i);", "FLL(7,list[5],100);", i=100)
    for number in range(8):
        running.write(f"Main.list[{number}]", 10 + number)
    running.scan(0)
    assert _list(running, "other", 4) == [10, 11, 12, 13]
    assert _list(running, "list", 8) == [10, 11, 12, 13, 14, 7, 7, 7]


def test_cop_copies_whole_structures(tmp_path: Path) -> None:
    """A timer is copied with its members."""
    running = _program(tmp_path, "COP(tm,tms[1],1);")
    running.write("Main.tm.PRE", 250)
    running.scan(0)
    assert running.read("Main.tms[1].PRE") == 250


def test_cop_between_whole_numbers_copies_bytes(tmp_path: Path) -> None:
    """The lowest byte comes first: 16#04030201 is 1, 2, 3, 4; 16#FFFE0001 is 1, -2.

    Source: 1756-RM003N, page 371: a byte-to-byte copy.
    """
    rungs = ["COP(i,bytes,4);", "COP(bytes[0],j,1);", "COP(wide,words,4);", "COP(words[0],k,1);"]
    running = _program(tmp_path, *rungs, i=0x04030201)
    running.write("Main.wide[0]", 0xFFFE0001 - (1 << 32))
    running.write("Main.wide[1]", 0x7FFF0005)
    running.scan(0)
    assert _list(running, "bytes", 4) == [1, 2, 3, 4]
    assert running.read("Main.j") == 0x04030201
    assert _list(running, "words", 4) == [1, 0xFFFE, 5, 0x7FFF]
    assert running.read("Main.k") == 0xFFFE0001 - (1 << 32)


def test_cop_between_other_types_is_named(tmp_path: Path) -> None:
    """The routine is not read, and the rest of the project is."""
    body = main_body(written(tmp_path, ["NOP();", "COP(x,i,1);"]))
    assert isinstance(body, Foreign)
    assert "rung 1: COP between REAL and DINT is not supported" in body.why


def test_fll_converts_its_value(tmp_path: Path) -> None:
    """-2 in an array of INT is the word 16#FFFE; elements behind the length stay."""
    running = _program(tmp_path, "FLL(-2,words[1],2);")
    running.scan(0)
    assert _list(running, "words", 4) == [0, 0xFFFE, 0xFFFE, 0]


def test_btd_moves_a_field_of_bits(tmp_path: Path) -> None:
    """Bits 4 to 7 of 16#00A5 (10) go to the bits 8 to 11 of 16#F0FF; the others stay.

    Bits beyond the destination are lost: bits 0 to 3 of 5 from the bit 6 of a SINT on are 2#01.
    Source: 1756-RM003N, page 303.
    """
    running = _program(tmp_path, "BTD(i,4,j,8,4);", "BTD(i,0,s,6,4);", i=0xA5, j=0xF0FF)
    running.scan(0)
    assert running.read("Main.j") == 0xFAFF
    assert running.read("Main.s") == 0x40


def test_size_of_an_array(tmp_path: Path) -> None:
    """The array `list` has 8 elements."""
    running = _program(tmp_path, "SIZE(list,0,i);")
    running.scan(0)
    assert running.read("Main.i") == 8


def test_bsl_shifts_at_the_rising_edge(tmp_path: Path) -> None:
    """Of 34 bits, bit 33 goes to UL, bit 31 to the next word, and `b` to bit 0. It does so once.

    Source: 1756-RM003N, BSL.
    """
    running = _program(tmp_path, "XIC(a)BSL(wide[0],ctl,b,?);")
    running.write("Main.ctl.LEN", 34)
    running.write("Main.wide[0]", -(1 << 31))
    running.write("Main.wide[1]", 2)
    running.scan(0)
    for at in (10, 20):
        running.write("Main.a", True)
        running.write("Main.b", True)
        running.scan(at * 1000)
        assert _list(running, "wide", 2) == [1, 5]
        assert [running.read(f"Main.ctl.{name}") for name in ("UL", "EN", "DN", "POS")] == [
            True,
            True,
            True,
            34,
        ]


def test_bsr_shifts_at_the_rising_edge(tmp_path: Path) -> None:
    """Of 34 bits, bit 0 goes to UL, bit 32 to bit 31, and `b` to bit 33. Source: RM003N, BSR."""
    running = _program(tmp_path, "XIC(a)BSR(wide[0],ctl,b,?);")
    running.write("Main.ctl.LEN", 34)
    running.write("Main.wide[0]", 1)
    running.write("Main.wide[1]", 1)
    running.scan(0)
    running.write("Main.a", True)
    running.write("Main.b", True)
    running.scan(10_000)
    assert _list(running, "wide", 2) == [-(1 << 31), 2]
    assert running.read("Main.ctl.UL") is True


def test_gsv_leaves_its_destination_to_the_test(tmp_path: Path) -> None:
    """A note names the object and the tag; the value that the test sets stays."""
    file = written(
        tmp_path, ["GSV(Module,Card,EntryStatus,i);", "SSV(WallClockTime,,CSTOffset,i);"]
    )
    notes = [note.partition(": ")[2] for note in read(file).notes]
    assert notes == [
        "GSV of Module Card, EntryStatus does not read it, and i keeps its value; a test can "
        "set it",
        "SSV of WallClockTime, CSTOffset does not set it",
    ]
    running = program(file)
    running.write("Main.i", 0x4000)
    running.scan(0)
    assert running.read("Main.i") == 0x4000


def test_cop_of_an_element_with_two_indices(tmp_path: Path) -> None:
    """An element of a table is copied; several elements of it are not supported."""
    running = program(written(tmp_path, ["COP(table[1,2],i,1);"], tags={"table": "DINT[2,3]"}))
    running.write("Main.table[1,2]", 7)
    running.scan(0)
    assert running.read("Main.i") == 7
    body = main_body(written(tmp_path, ["COP(table[1,0],list,3);"], tags={"table": "DINT[2,3]"}))
    assert isinstance(body, Foreign)
    assert "COP of a part of an array with several dimensions is not supported" in body.why


def test_event_does_nothing_and_is_noted(tmp_path: Path) -> None:
    (note,) = read(written(tmp_path, ["EVENT(Fast);"])).notes
    assert note.endswith(
        "EVENT does not start the task Fast, because a task of events does not run"
    )


@pytest.mark.parametrize(
    "rung", ["MSG(m);", "MSO(axis,m);", "PID(p,i,0,j,0,0,0);", "GSV(A,b,C,i);"]
)
def test_an_instruction_for_what_is_outside_is_named(tmp_path: Path, rung: str) -> None:
    """The message says what to do: a body in Structured Text."""
    body = main_body(written(tmp_path, [rung]))
    assert isinstance(body, Foreign)
    assert f"rung 0: {rung[:3]}" in body.why
    assert "--replace" in body.why
