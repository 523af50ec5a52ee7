"""The solver's translation of the library is compared with the built-in engine, in part.

The tests also check that the comparison detects faults.
"""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import z3

import proving
from rcx_tools.evidence.prove.agreement import jobs as agreeing
from rcx_tools.evidence.prove.agreement.bench import Subject, missing
from rcx_tools.evidence.prove.agreement.comparing import MATIEC_SCANS, SCANS, agree
from rcx_tools.evidence.prove.evaluate import program
from rcx_tools.evidence.results import ROOT
from structured_text.projects.needed import needed
from structured_text.prove import standard
from structured_text.prove.machine import Machine

pytestmark = pytest.mark.exhaustive

_FILES = sorted((ROOT / "plc/lib").rglob("*.st"))
_PART = ("FC_RCXTICKETS", "FC_RCXREALBITS", "FB_SERVOON", "FB_RCXJOB", "FB_WRITEWORD")


@pytest.fixture(scope="module")
def library() -> Subject:
    """Return the part of plc/lib that the compared blocks need."""
    own = [file for file in _FILES if file.stem.upper() in _PART]
    return Subject.of([*needed(own, _FILES), *own])


@pytest.mark.parametrize("name", _PART)
def test_the_translation_of_a_block_agrees_with_the_engine(library: Subject, name: str) -> None:
    outcome = agree(library, name, 60)
    assert outcome.disagreement == ""
    assert (outcome.scans, outcome.faults) == (60, 0)


def test_every_pou_of_the_library_is_compared_in_100_000_scans() -> None:
    """Every POU of the library is compared in at least 300 scans.

    In total, these are at least 100,000 scans.
    """
    pous = [file for file in _FILES if file.parent.name != "types"]
    assert min(SCANS, MATIEC_SCANS) >= 300
    assert SCANS * len(pous) >= 100_000


def test_the_same_seed_gives_the_same_scans(library: Subject) -> None:
    one, other = (agree(library, "FB_SERVOON", 20, 7) for _ in range(2))
    assert (one.scans, one.faults, one.open) == (other.scans, other.faults, other.open)


@pytest.fixture(scope="module")
def bench() -> Subject:
    """Return a comparison of a few sources with matiec."""
    if reason := missing():
        pytest.skip(reason)
    files = [
        path
        for name in ("FC_RcxTickets", "FB_ServoOn", "FB_EmergencyStop")
        for path in (ROOT / "plc/lib").rglob(f"{name}.st")
    ]
    files = needed(files, sorted((ROOT / "plc/lib").rglob("*.st"))) + files
    return Subject.of(files, matiec=True)


@pytest.mark.parametrize("name", ["FC_RCXTICKETS", "FB_SERVOON", "FB_EMERGENCYSTOP"])
def test_the_translation_agrees_with_matiec(bench: Subject, name: str) -> None:
    outcome = agree(bench, name, 20, engine="matiec")
    assert (outcome.disagreement, outcome.scans) == ("", 20)


def _tried(tmp_path: Path, body: str, *, matiec: bool = False) -> Subject:
    file = tmp_path / "tried.st"
    file.write_text(
        "FUNCTION_BLOCK FB_TRIED\n  VAR_INPUT A, B : INT; END_VAR\n"
        "  VAR R : INT; N : ARRAY [0..3] OF INT; T : R_TRIG; END_VAR\n"
        f"  {body}\nEND_FUNCTION_BLOCK\n"
    )
    return Subject.of([file], matiec=matiec)


def test_a_wrong_translation_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong translation is reported with seed, scan, variable and both values."""
    subject = _tried(tmp_path, "T(CLK := A > 3);")
    assert agree(subject, "FB_TRIED", 50).disagreement == ""
    monkeypatch.setattr(
        standard, "run", lambda machine, path, _: machine.store([(True, (*path, "Q"))], None, True)
    )
    told = agree(subject, "FB_TRIED", 50).disagreement
    assert told.startswith("FB_TRIED, builtin, seed 1, scan ")
    assert told.endswith("B.T.Q is True, on the engine False")


def test_a_wrong_translation_is_found_on_matiec(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if reason := missing():
        pytest.skip(reason)
    subject = _tried(tmp_path, "T(CLK := A > 3);", matiec=True)
    assert agree(subject, "FB_TRIED", 50, engine="matiec").disagreement == ""
    monkeypatch.setattr(
        standard, "run", lambda machine, path, _: machine.store([(True, (*path, "Q"))], None, True)
    )
    told = agree(subject, "FB_TRIED", 50, engine="matiec").disagreement
    assert told.endswith("B.T.Q is True, on the engine False")


def test_a_fault_of_only_one_side_is_detected(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run-time fault that only one side has is reported.

    Engine and translation stop in nearly every scan: only 4 of 65536 indices are legal.
    """
    subject = _tried(tmp_path, "N[B] := A;")
    outcome = agree(subject, "FB_TRIED", 20)
    assert outcome.disagreement == ""
    assert outcome.faults > 0
    monkeypatch.setattr(Machine, "oblige", lambda *_: None)
    assert "goes on, the engine does not" in agree(subject, "FB_TRIED", 20).disagreement


def test_a_comparison_that_cannot_be_made_is_not_an_agreement(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A comparison in which every result is undetermined does not count as agreement."""
    subject = _tried(tmp_path, "R := A;")

    def opened(self: Machine, *_: object) -> None:
        self.oblige("time", True)

    monkeypatch.setattr(Machine, "assign", opened)
    told = agree(subject, "FB_TRIED", 5).disagreement
    assert told.endswith("only 0 of 5 scans could be compared")


def test_the_report_says_how_much_was_compared_on_matiec() -> None:
    """The report says how much was compared on matiec.

    The figures by hand: two blocks with 300 and 310 scans, and a function with 20.
    """
    scans = {"A": (300, True), "B": (310, True), "C": (20, False)}
    rows = [
        {
            "pou": name,
            "block": block,
            "engines": {"builtin": {"scans": 600}, "matiec": {"scans": count}},
            "disagreement": "",
        }
        for name, (count, block) in scans.items()
    ]
    figures = agreeing.summary(rows)
    assert (figures["scans"], figures["blocks"], figures["functions"]) == (1800, 2, 1)
    told = figures["matiec"]["says"]
    if reason := missing():
        assert told == f"not compared on matiec ({reason})"
    else:
        assert told.startswith("on matiec (compiler ")
        assert told.endswith(") 630 scans, at least 300 of each block")


def test_the_key_of_a_stored_result_depends_on_the_compiler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The key of a stored result depends on the compiler.

    It differs without matiec, with one version of matiec, and with another version.
    """
    few = proving.library(tmp_path, "FC_RcxTickets")
    keys = set()
    for state in ("", "one", "other"):
        monkeypatch.setattr(agreeing, "compiler_state", lambda state=state: state)
        keys |= {job.key for job in agreeing.comparisons(few)}
    assert len(keys) == 3


def test_terms_are_evaluated_as_the_solver_does() -> None:
    """Solver terms are evaluated as by the solver, at random values and at limits."""
    x, y = z3.BitVecs("x y", 16)
    f, g = z3.BitVecs("f g", 32)
    single = [z3.fpBVToFP(one, z3.Float32()) for one in (f, g)]
    double = [z3.fpFPToFP(z3.RNE(), one, z3.Float64()) for one in single]
    near, wide = z3.RNE(), z3.Concat(f, g)
    numbers = [
        x + y, x - y, x * y, -x, ~x, x & y, x | y, x ^ y, z3.UDiv(x, y), x / y, z3.SRem(x, y),
        z3.URem(x, y), x % y, z3.Concat(x, y), z3.Extract(9, 3, x), z3.SignExt(5, x),
        z3.ZeroExt(4, x), x << (y & 31), z3.LShR(x, y & 31), z3.RotateLeft(x, 3),
        z3.RotateLeft(x, y), z3.If(x < y, x, y), z3.fpToSBV(near, double[0], z3.BitVecSort(64)),
        *(z3.fpToIEEEBV(call(near, *pair))
          for call in (z3.fpAdd, z3.fpSub, z3.fpMul, z3.fpDiv) for pair in (single, double)),
        z3.fpToIEEEBV(z3.fpSqrt(near, single[0])),
        z3.fpToIEEEBV(z3.fpRoundToIntegral(near, double[0])),
        z3.fpToIEEEBV(z3.fpRoundToIntegral(z3.RTZ(), double[0])),
        z3.fpToIEEEBV(z3.fpSignedToFP(near, wide, z3.Float32())),
        z3.fpToIEEEBV(z3.fpUnsignedToFP(near, wide, z3.Float32())),
        z3.fpToIEEEBV(z3.fpSignedToFP(near, wide, z3.Float64())),
    ]  # fmt: skip
    truths = [
        x < y, z3.ULT(x, y), x <= y, x >= y, z3.UGE(x, y), z3.Xor(x < y, x == y),
        z3.BVMulNoOverflow(x, y, True), z3.BVMulNoUnderflow(x, y), z3.BVSubNoOverflow(x, y),
        z3.fpLT(*single), z3.fpEQ(*single), single[0] == single[1], z3.fpGEQ(*double),
    ]  # fmt: skip
    terms = [*numbers, *(z3.If(one, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1)) for one in truths)]
    written = program(terms)
    draw = random.Random(1)
    limits = (0, 1, 0xFFFF, 0x8000, 0x7FFF)
    special = (0, 1 << 31, 1, 0x7F80_0000, 0xFF80_0000, 0x7FC0_0000, 0x3F80_0000, 0x4EFF_FFFF)
    for _ in range(40):
        given = {name: draw.choice((*limits, draw.getrandbits(16))) for name in "xy"}
        given |= {name: draw.choice((*special, *[draw.getrandbits(32)] * 8)) for name in "fg"}
        pairs = [(one, z3.BitVecVal(given[str(one)], one.size())) for one in (x, y, f, g)]
        got = written.run([given[name] for name in written.inputs])
        for term, value in zip(terms, got, strict=True):
            expected = z3.simplify(z3.substitute(term, *pairs))
            if z3.is_bv_value(expected):  # otherwise the result is undetermined
                assert value == expected.as_long(), (term, given)
