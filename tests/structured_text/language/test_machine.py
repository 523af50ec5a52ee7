"""A whole program in the manner of TwinCAT, and what does not run such programs."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector
from structured_text.errors import InputError
from structured_text.language import portability
from structured_text.language.load import load
from structured_text.language.parser import parse_portable

_MACHINE = Path(__file__).parent / "machine.st"


def test_the_machine_moves_its_axes() -> None:
    """The servo takes 4 mm a scan, its override cut to 1; the stepper half of 1 mm."""
    program = BuiltinProgram.build(load([_MACHINE]))

    far = []
    for scan in range(12):
        program.scan(scan * 10_000)
        far.append(program.read("Main.Group.Far"))

    assert far == [5.5, 5.0, 4.5, 4.0, 3.5, 3.0, 2.5, 2.0, 1.5, 1.0, 0.5, 0.0]
    assert program.read("Main.Group.Done") is True
    assert program.read("Main.Steps") == 12
    assert program.read("Main.Where") == 6.0
    assert program.read("Main.Servo._override") == 1.0
    # Two samples a scan; the last two scans are in the buffer of four.
    assert program.read("Main.Log.Count") == 24
    assert program.read("Main.Samples") == [
        {"Axis": 1, "Value": 6.0},
        {"Axis": 2, "Value": 5.5},
        {"Axis": 1, "Value": 6.0},
        {"Axis": 2, "Value": 6.0},
    ]
    assert program.read("Main.Axes") == ["Main.Servo", "", "Main.Stepper"]
    assert program.read("Main.Servo._log") == "Main.Log"


def test_another_instance_goes_on_from_a_snapshot() -> None:
    first = BuiltinProgram.build(load([_MACHINE]))
    for scan in range(5):
        first.scan(scan * 10_000)
    second = first.instance()
    second.restore(first.snapshot())
    for scan in range(5, 12):
        first.scan(scan * 10_000)
        second.scan(scan * 10_000)
    assert second.snapshot() == first.snapshot()
    assert second.read("Main.Where") == 6.0


def test_coverage_counts_methods_and_properties() -> None:
    collector = Collector()
    program = BuiltinProgram.build(load([_MACHINE]), collector)
    program.scan(0)
    counts = {one.pou.name.upper(): one.counts.counters for one in collector.counted}
    assert counts["FB_STEPPER.STEPS.GET"] == [1]
    assert counts["FB_AXISBASE.OVERRIDE.SET"] == [2]
    assert counts["FB_SERVO.STEP"] == [1]
    # Both axes are enabled: the branch with RETURN is not run, the rest twice.
    assert counts["FB_AXISBASE.MOVETO"][1] == 0
    assert 2 in counts["FB_AXISBASE.MOVETO"]


@pytest.mark.parametrize(
    ("source", "construct"),
    [
        ("FUNCTION_BLOCK F METHOD M ; END_METHOD END_FUNCTION_BLOCK", "a METHOD"),
        (
            "FUNCTION_BLOCK F PROPERTY P : INT GET P := 1; END_GET END_PROPERTY END_FUNCTION_BLOCK",
            "a PROPERTY",
        ),
        ("INTERFACE I END_INTERFACE", "an INTERFACE"),
        ("FUNCTION_BLOCK F EXTENDS G END_FUNCTION_BLOCK", "EXTENDS"),
        ("TYPE S EXTENDS R : STRUCT A : INT; END_STRUCT; END_TYPE", "EXTENDS"),
        ("FUNCTION_BLOCK F IMPLEMENTS I END_FUNCTION_BLOCK", "IMPLEMENTS"),
        ("FUNCTION_BLOCK ABSTRACT F END_FUNCTION_BLOCK", "an access specifier"),
        ("FUNCTION_BLOCK F THIS^.X := 1; END_FUNCTION_BLOCK", "THIS or SUPER"),
        ("FUNCTION_BLOCK F SUPER^(); END_FUNCTION_BLOCK", "THIS or SUPER"),
        ("FUNCTION_BLOCK F VAR P : POINTER TO INT; END_VAR END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F VAR P : REF_TO INT; END_VAR END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F P^ := 1; END_FUNCTION_BLOCK", "POINTER TO"),
        ("FUNCTION_BLOCK F VAR P : REFERENCE TO INT; END_VAR END_FUNCTION_BLOCK", "REFERENCE TO"),
        ("FUNCTION_BLOCK F R REF= X; END_FUNCTION_BLOCK", "REFERENCE TO"),
        ("NAMESPACE N END_NAMESPACE", "a NAMESPACE"),
        ("USING N;", "a NAMESPACE"),
    ],
)
def test_the_portable_subset_refuses_it_by_name(source: str, construct: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_portable(source, Path("program.st"))
    named = str(caught.value).split("does not take ")[1].split("; ")
    assert construct in ", ".join(named[:2])


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("USING N;", "a NAMESPACE;"),
        ("FUNCTION_BLOCK F EXTENDS G R REF= X; END_FUNCTION_BLOCK", "EXTENDS; also REFERENCE TO;"),
    ],
)
def test_a_refusal_names_every_construct(source: str, told: str) -> None:
    with pytest.raises(InputError, match=f"does not take {told}"):
        parse_portable(source, Path("program.st"))


def test_the_rules_of_the_library_name_it() -> None:
    found = {finding.text for finding in portability.lint([_MACHINE], binding=True)}
    for construct in ("a METHOD", "a PROPERTY", "an INTERFACE", "EXTENDS", "POINTER TO"):
        assert any(construct in text for text in found), construct
