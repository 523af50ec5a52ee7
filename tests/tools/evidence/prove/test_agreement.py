"""The comparison of the translation with the built-in engine: a part of it, and that it finds."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import z3

from rcx_harness.engine.needed import needed
from rcx_harness.verify.prove import standard
from rcx_tools.evidence.prove.agreement import SCANS, Subject, agree
from rcx_tools.evidence.prove.agreement_matiec import Bench, missing
from rcx_tools.evidence.prove.evaluate import program
from rcx_tools.evidence.results import ROOT

_PART = ("FC_RCXTICKETS", "FC_RCXREALBITS", "FB_SERVOON", "FB_RCXJOB", "FB_WRITEWORD")


@pytest.fixture(scope="module")
def library() -> Subject:
    return Subject.of(sorted((ROOT / "plc/lib").rglob("*.st")))


@pytest.mark.parametrize("name", _PART)
def test_the_translation_of_a_block_agrees_with_the_engine(library: Subject, name: str) -> None:
    outcome = agree(library, name, 60)
    assert outcome.disagreement == ""
    assert (outcome.scans, outcome.faults) == (60, 0)


def test_every_pou_of_the_library_is_compared_in_100_000_scans(library: Subject) -> None:
    """At least 300 of each, and those of `make prove` are more."""
    pous = [name for name in library.project.pous if not name.endswith("_BENCH")]
    assert SCANS >= 300
    assert SCANS * len(pous) >= 100_000


def test_the_same_seed_gives_the_same_scans(library: Subject) -> None:
    one, other = (agree(library, "FB_SERVOON", 20, 7) for _ in range(2))
    assert (one.scans, one.faults, one.open) == (other.scans, other.faults, other.open)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> tuple[Subject, Bench]:
    """A few sources on matiec."""
    if reason := missing():
        pytest.skip(reason)
    files = [
        path
        for name in ("FC_RcxTickets", "FB_ServoOn", "FB_EmergencyStop")
        for path in (ROOT / "plc/lib").rglob(f"{name}.st")
    ]
    files = needed(files, sorted((ROOT / "plc/lib").rglob("*.st"))) + files
    subject = Subject.of(files)
    return subject, Bench.of(files, subject.project)


@pytest.mark.parametrize("name", ["FC_RCXTICKETS", "FB_SERVOON", "FB_EMERGENCYSTOP"])
def test_the_translation_agrees_with_matiec(bench: tuple[Subject, Bench], name: str) -> None:
    outcome = agree(bench[0], name, 20, bench=bench[1])
    assert (outcome.disagreement, outcome.scans) == ("", 20)


def _tried(tmp_path: Path, body: str) -> Subject:
    file = tmp_path / "tried.st"
    file.write_text(
        "FUNCTION_BLOCK FB_TRIED\n  VAR_INPUT A, B : INT; END_VAR\n"
        "  VAR R : INT; N : ARRAY [0..3] OF INT; T : R_TRIG; END_VAR\n"
        f"  {body}\nEND_FUNCTION_BLOCK\n"
    )
    return Subject.of([file])


def test_a_wrong_translation_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block that is translated wrongly is told with seed, scan, variable and both values."""
    subject = _tried(tmp_path, "T(CLK := A > 3);")
    assert agree(subject, "FB_TRIED", 50).disagreement == ""
    monkeypatch.setattr(
        standard, "run", lambda machine, path, _: machine.store([(True, (*path, "Q"))], None, True)
    )
    told = agree(subject, "FB_TRIED", 50).disagreement
    assert told.startswith("FB_TRIED, seed 1, scan ")
    assert told.endswith("B.T.Q is True, on the engine False")


def test_a_wrong_translation_is_found_on_matiec(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if reason := missing():
        pytest.skip(reason)
    subject = _tried(tmp_path, "T(CLK := A > 3);")
    on_matiec = Bench.of([tmp_path / "tried.st"], subject.project)
    assert agree(subject, "FB_TRIED", 50, bench=on_matiec).disagreement == ""
    monkeypatch.setattr(
        standard, "run", lambda machine, path, _: machine.store([(True, (*path, "Q"))], None, True)
    )
    told = agree(subject, "FB_TRIED", 50, bench=on_matiec).disagreement
    assert told.endswith("B.T.Q is True, on the engine False")


def test_a_fault_that_only_one_side_has_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    subject = _tried(tmp_path, "IF A = 2 THEN N[B] := 1; END_IF;")
    outcome = agree(subject, "FB_TRIED", 200)
    assert (outcome.disagreement, outcome.faults > 0) == ("", True)
    monkeypatch.setattr("rcx_harness.verify.prove.machine.Machine.oblige", lambda *_: None)
    assert "the engine does not" in agree(subject, "FB_TRIED", 200).disagreement


def test_terms_are_evaluated_as_the_solver_does() -> None:
    """Every operation, on random values and on limits."""
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
            if z3.is_bv_value(expected):  # else it is left open
                assert value == expected.as_long(), (term, given)
