"""Ladder routines of an L5X: power, branches, bits, jumps and zones.

Expected values are read from the drawn rungs. Source: Rockwell 1756-RM003, bit instructions and
program control instructions.
"""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import pytest

from l5x_ladder import main_body, program, read, written
from structured_text.projects.model import Foreign
from structured_text.projects.rockwell.ladder.table import TABLE

_ROOT = Path(__file__).parents[3]


def _scan(folder: Path, *rungs: str, **values: object) -> dict[str, object]:
    """Return the tags after one scan that begins with some values."""
    running = program(written(folder, rungs))
    for name, value in values.items():
        running.write(f"Main.{name}", value)
    running.scan(0)
    names = [*"abcdefghijkstvwxyl"]
    return {name: running.read(f"Main.{name}") for name in names}


def test_series_and_branches_are_and_and_or(tmp_path: Path) -> None:
    """The coil has power if a, and either not b, or c and d. All 16 combinations are tried."""
    running = program(written(tmp_path, ["XIC(a)[XIO(b) ,XIC(c) XIC(d) ]OTE(e);"]))
    for scan, (a, b, c, d) in enumerate(product((False, True), repeat=4)):
        for name, value in zip("abcd", (a, b, c, d), strict=True):
            running.write(f"Main.{name}", value)
        running.scan(scan * 10_000)
        assert running.read("Main.e") is (a and (not b or (c and d)))


def test_a_rung_becomes_a_single_statement(tmp_path: Path) -> None:
    """The conditions of a rung are one expression; nested branches get parentheses."""
    file = written(tmp_path, ["XIC(a)[XIO(b),XIC(c)[XIC(d),XIC(f)]]OTE(e);", "XIC(a)OTL(b);"])
    assert main_body(file) == [
        "e := a AND (NOT b OR c AND (d OR f));",
        "IF a THEN",
        "  b := TRUE;",
        "END_IF;",
    ]


def test_lines_name_their_rung_and_comments_are_kept(tmp_path: Path) -> None:
    """Each line has the name of its rung as its network, and the rung's comment is a comment."""
    file = written(tmp_path, ["OTE(a);", "OTE(b);"])
    text = file.read_text(encoding="utf-8")
    text = text.replace(
        '"1" Type="N">', '"1" Type="N"><Comment><![CDATA[Lamp (*\non*)]]></Comment>'
    )
    file.write_text(text, encoding="utf-8")
    (unit,) = [unit for unit in read(file).units if unit.kind == "PROGRAM"]
    assert not isinstance(unit.piece.body, Foreign)
    body = [line for line in unit.piece.body if line.network]
    assert [line.text for line in body] == [
        "  (* Rung 0 *)",
        "  a := TRUE;",
        "  (* Rung 1: Lamp ( *",
        "     on* ) *)",
        "  b := TRUE;",
    ]
    assert [line.network for line in body] == ["rung 0"] * 2 + ["rung 1"] * 3


def test_an_instruction_behind_an_output_reads_its_new_value(tmp_path: Path) -> None:
    """OTE(b) sets b first; XIC(b) behind it is TRUE in the same scan."""
    assert _scan(tmp_path, "XIC(a)OTE(b)XIC(b)OTE(c);", a=True)["c"] is True


def test_a_condition_before_an_output_keeps_its_old_value(tmp_path: Path) -> None:
    """The power of XIO(a) is taken before OTL(a) changes a; d is set although a is TRUE then."""
    found = _scan(tmp_path, "XIO(a)OTL(a)OTE(d);")
    assert (found["a"], found["d"]) == (True, True)


def test_a_leg_keeps_its_power_while_other_legs_write(tmp_path: Path) -> None:
    """The first leg has power by b, before the second leg clears b; so e is set.

    The third leg reads b after it was cleared, and has no power.
    """
    found = _scan(tmp_path, "[XIC(b),OTU(b)AFI(),XIC(b)OTE(f)]OTE(e);", b=True)
    assert (found["b"], found["e"], found["f"]) == (False, True, False)


def test_outputs_of_one_branch_share_the_power(tmp_path: Path) -> None:
    """Outputs in parallel legs are executed from top to bottom with the same power.

    A variable holds it, because two statements use it; both latches are in one IF.
    """
    file = written(tmp_path, ["XIC(a)XIO(b)[OTE(c),XIC(d)OTE(e),OTL(f)OTL(g)];"])
    body = main_body(file)
    assert isinstance(body, list)
    assert body[1:] == [
        "c := RcxPower_1;",
        "e := RcxPower_1 AND d;",
        "IF RcxPower_1 THEN",
        "  f := TRUE;",
        "  g := TRUE;",
        "END_IF;",
    ]
    assert body[0] == "RcxPower_1 := a AND NOT b;"


def test_members_and_elements_are_told_apart(tmp_path: Path) -> None:
    """A write to list[1] or to bit 2 does not change list[0] or bit 1; an index that varies may."""
    constant = ["XIC(list[0].1)OTE(list[0].2)OTE(list[1].1)XIC(a)OTE(b);"]
    assert main_body(written(tmp_path, constant)) == [
        "list[0].2 := list[0].1;",
        "list[1].1 := list[0].1;",
        "b := list[0].1 AND a;",
    ]
    varying = main_body(written(tmp_path, ["XIC(list[0].1)OTE(list[i].1)OTE(b);"]))
    assert isinstance(varying, list)
    assert varying[0] == "RcxPower_1 := list[0].1;"


def test_a_leg_without_instructions_passes_power(tmp_path: Path) -> None:
    """An empty leg is a wire, so the branch has power whatever the other leg has."""
    assert _scan(tmp_path, "[XIC(a),]OTE(b);")["b"] is True


def test_afi_takes_the_power_away(tmp_path: Path) -> None:
    """Behind AFI an OTE is FALSE, and a latch stays as it is."""
    found = _scan(tmp_path, "AFI()XIC(a)OTE(b);", "AFI()OTL(c)OTU(d);", a=True, b=True, d=True)
    assert (found["b"], found["c"], found["d"]) == (False, False, True)
    assert _scan(tmp_path, "AFI OTE(b);", b=True)["b"] is False


def test_ons_passes_power_in_one_scan(tmp_path: Path) -> None:
    """The output is TRUE in the scan in which a comes; the first scan is not an edge."""
    running = program(written(tmp_path, ["XIC(a)ONS(h)OTE(b);"]))
    seen = []
    for scan, value in enumerate((True, True, False, True, True)):
        running.write("Main.a", value)
        running.scan(scan * 10_000)
        seen.append(running.read("Main.b"))
    assert seen == [False, False, False, True, False]


def test_empty_rungs_and_routines_are_legal(tmp_path: Path) -> None:
    """A rung `;`, a rung without text, and a routine without rungs do nothing."""
    file = written(tmp_path, [";", "", "NOP();", "JSR(Sub,0);", "OTE(a);"], routines={"Sub": []})
    running = program(file)
    running.scan(0)
    assert running.read("Main.a") is True


def test_jsr_executes_a_routine_with_power_only(tmp_path: Path) -> None:
    """The routine counts its calls. Without power it is not called, and its coil stays."""
    routines = {"Sub": ["SBR();", "ADD(i,1,i);", "XIC(c)OTE(d);", "RET();", "ADD(i,100,i);"]}
    running = program(written(tmp_path, ["XIC(a)JSR(Sub,0)OTE(b);"], routines=routines))
    seen = []
    for scan, (a, c) in enumerate([(False, True), (True, True), (False, False), (True, False)]):
        running.write("Main.a", a)
        running.write("Main.c", c)
        running.scan(scan * 10_000)
        seen.append(tuple(running.read(f"Main.{name}") for name in "ibd"))
    assert seen == [(0, False, False), (1, True, True), (1, False, True), (2, True, False)]


def test_a_routine_may_have_the_name_of_a_tag(tmp_path: Path) -> None:
    """The controller tells tags and routines apart; the method gets a name of its own."""
    file = written(tmp_path, ["JSR(a,0,0);"], routines={"a": ["OTE(a);"]})
    assert main_body(file) == ["a_Routine();"]
    running = program(file)
    running.scan(0)
    assert running.read("Main.a") is True


def test_a_program_without_its_main_routine_is_noted(tmp_path: Path) -> None:
    """An exported routine is not the main routine of its program, so nothing calls it."""
    file = written(tmp_path, ["OTE(a);"])
    text = file.read_text(encoding="utf-8").replace(' MainRoutineName="Main"', "")
    file.write_text(text, encoding="utf-8")
    assert "the program P has no main routine in this file" in read(file).notes[0]


def test_power_is_kept_over_a_call_of_a_routine(tmp_path: Path) -> None:
    """The routine clears a, but the power behind JSR is still that of a before the call."""
    file = written(tmp_path, ["XIC(a)JSR(Sub,0)OTE(b);"], routines={"Sub": ["OTU(a);"]})
    running = program(file)
    running.write("Main.a", True)
    running.scan(0)
    assert (running.read("Main.a"), running.read("Main.b")) == (False, True)


@pytest.mark.parametrize(
    ("a", "b", "expected"),
    [(False, False, (11, 1, 1)), (True, False, (10, 0, 1)), (False, True, (11, 0, 0))],
)
def test_a_jump_skips_the_rungs_up_to_its_label(
    tmp_path: Path, a: bool, b: bool, expected: tuple[int, ...]
) -> None:
    """Jumps may cross: a skips rungs 1 to 3, b skips rungs 3 and 4, which ends behind the label L.

    The rest of a rung behind a jump is not executed.
    """
    rungs = [
        "ADD(i,10,i)XIC(a)JMP(L);",
        "ADD(i,1,i);",
        "XIC(b)JMP(M)OTE(h);",
        "ADD(j,1,j);",
        "LBL(L)ADD(k,1,k);",
        "LBL(M);",
    ]
    found = _scan(tmp_path, *rungs, a=a, b=b)
    assert tuple(found[name] for name in "ijk") == expected


def test_a_jump_back_repeats_the_rungs(tmp_path: Path) -> None:
    """The loop adds 1 to 5; a jump out of the loop ends it at 3, and rung 4 is skipped."""
    rungs = [
        "CLR(i);",
        "LBL(Again)ADD(i,1,i);",
        "XIC(a)EQU(i,3)JMP(Out);",
        "ADD(j,i,j)LES(i,5)JMP(Again);",
        "ADD(k,1,k);",
        "LBL(Out)ADD(k,10,k);",
    ]
    assert [_scan(tmp_path, *rungs)[name] for name in "ijk"] == [5, 15, 11]
    assert [_scan(tmp_path, *rungs, a=True)[name] for name in "ijk"] == [3, 3, 10]


def test_tnd_and_ret_end_the_routine(tmp_path: Path) -> None:
    """Rungs behind TND are not executed while it has power."""
    rungs = ["XIC(a)TND();", "ADD(i,1,i);"]
    assert _scan(tmp_path, *rungs, a=True)["i"] == 0
    assert _scan(tmp_path, *rungs)["i"] == 1


def test_the_first_scan_ends_although_tnd_leaves_the_routine(tmp_path: Path) -> None:
    """S:FS is TRUE in the first scan only, also if TND leaves the routine in each scan."""
    running = program(written(tmp_path, ["XIC(S:FS)ADD(i,1,i);", "TND();"]))
    for scan in range(3):
        running.scan(scan * 10_000)
    assert running.read("Main.i") == 1


def test_a_zone_without_power_takes_the_power_of_its_rungs(tmp_path: Path) -> None:
    """In a zone without power an OTE is FALSE, and a latch stays. Behind the zone, power is back.

    Source: 1756-RM003, MCR.
    """
    rungs = ["XIC(a)MCR();", "OTE(b);", "XIO(c)OTE(d);", "OTL(e);", "MCR();", "OTE(f);"]
    found = _scan(tmp_path, *rungs, b=True, d=True)
    assert [found[name] for name in "bdef"] == [False, False, False, True]
    found = _scan(tmp_path, *rungs, a=True)
    assert [found[name] for name in "bdef"] == [True, True, True, True]


@pytest.mark.parametrize("kind", ["I", "IR", "rR", "rI", "e", "er"])
def test_a_rung_of_an_edit_is_left_out_with_a_note(tmp_path: Path, kind: str) -> None:
    """A rung that was inserted but not accepted is not executed.

    Source: 1756-RM084, ladder routines: types of rungs.
    """
    file = written(tmp_path, ["OTE(a);", f"{kind}|OTE(b);"])
    assert main_body(file) == ["a := TRUE;"]
    (note,) = read(file).notes
    assert f"rung 1 of Main is an edit that is not accepted ({kind}," in note


@pytest.mark.parametrize("kind", ["D", "R", "d", "rN"])
def test_a_rung_that_an_edit_would_replace_is_executed(tmp_path: Path, kind: str) -> None:
    """The old rung is executed until the edit is accepted; a note names it."""
    file = written(tmp_path, ["OTE(a);", f"{kind}|OTE(b);"])
    assert main_body(file) == ["a := TRUE;", "b := TRUE;"]
    assert "rung 1 of Main has an edit that is not accepted" in read(file).notes[0]


@pytest.mark.parametrize(
    ("rung", "message"),
    [
        ("XIC(a", "rung 0: ) of XIC is expected, not the end"),
        ("[XIC(a)OTE(b);", "rung 0: ] of a branch is expected, not ';'"),
        ("XIC(a)];", "rung 0: ']' is not expected here"),
        ("XIC a;", "rung 0: XIC has no list of operands"),
        ("AFI XIC;", "rung 0: XIC has no list of operands"),
        ("XIC(a)OTE(b);OTE(c);", "rung 0: 'O' is not expected here"),
        ("XIC(a[1)OTE(b);", "rung 0: ) in an operand of XIC closes nothing"),
        ("MOV('a,j);", "rung 0: a text has no end"),
        ("XIC(nowhere)OTE(a);", "rung 0: there is no tag nowhere in this file"),
        ("XIC(i)OTE(a);", "rung 0: i is not a BOOL, as Data Bit of XIC is"),
        ("XIC()OTE(a);", "rung 0: XIC has 0 operands, not 1: Data Bit"),
        ("XIC(?)OTE(a);", "rung 0: XIC has no Data Bit"),
        ("XIC(a b)OTE(a);", "rung 0: 'b' is not expected here"),
        ("XIX(a)OTE(b);", "rung 0: the instruction XIX is not supported"),
        ("JMP(L);", "rung 0: there is no label L"),
        ("OTE(a)LBL(L);", "rung 0: LBL is not the first instruction"),
        ("X|OTE(a);", "rung 0: the type 'X' of a rung is not known"),
        ("XPY(i);", "rung 0: XPY has 1 operands, not 3"),
        ("JSR(Sub,0);", "rung 0: there is no routine Sub in this program"),
    ],
)
def test_a_bad_rung_is_named_with_its_number(tmp_path: Path, rung: str, message: str) -> None:
    """The routine is not read, and the reason names rung and part; the line is that of the rung."""
    file = written(tmp_path, [rung])
    body = main_body(file)
    assert isinstance(body, Foreign)
    assert body.why.startswith(message)
    lines = file.read_text(encoding="utf-8").splitlines()
    assert "CDATA" in lines[body.at - 1] or "<Rung" in lines[body.at - 1]


def test_operands_may_have_line_breaks(tmp_path: Path) -> None:
    """White space and line breaks within a rung have no meaning."""
    assert _scan(tmp_path, "XIC(\na\n)\n[\nXIC( b ),\nXIC(c)]\nADD(i,\n5 +\n2,\n\ni)\n;", a=True)
    assert _scan(tmp_path, "ADD(i,\n5 +\n2,\n\ni)\n;")["i"] == 7


def test_a_bit_may_have_a_varying_number(tmp_path: Path) -> None:
    """`i.[j]` is the bit of i whose number is j; it is read, assigned, latched and unlatched."""
    rungs = [
        "XIC(i.[j])OTE(a);",
        "XIC(b)OTE(i.[j + 1]);",
        "OTL(v.[k])OTU(s.[0]);",
        "XIO(list[2].[j])OTE(c);",
    ]
    found = _scan(tmp_path, *rungs, i=0b01001, j=3, k=15, s=3)
    assert [found[name] for name in "aicvs"] == [True, 0b01001, True, -32768, 2]
    found = _scan(tmp_path, *rungs, i=0b10001, j=3, k=0, b=False)
    assert [found[name] for name in "aiv"] == [False, 0b00001, 1]
    found = _scan(tmp_path, *rungs, i=1, j=30, b=True)
    assert found["i"] == 1 - 2**31


def test_the_page_names_each_instruction() -> None:
    """The table of the language's page has every instruction, and the table has its source."""
    page = (_ROOT / "docs/reference/language.md").read_text(encoding="utf-8")
    section = page.partition("## Ladder of Logix")[2].partition("\n## ")[0]
    words = set(re.findall(r"\w+", section))
    assert set(TABLE) - words == set()
    assert all(entry.source.startswith(("1756-", "assumed")) for entry in TABLE.values())
