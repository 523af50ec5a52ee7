"""Each clause of the blocks' contract is broken alone, and its legal neighbours pass.

An artificial program shows the monitor the pins of one block, scan by scan. Expected results are by
hand from the contract: exactly one of Busy, Done, Error (CommandAborted) while Execute is TRUE,
Active only with Busy, an end for exactly one scan after Execute has fallen, ErrorID exactly with
Error.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pytest

from rcx_harness.watch.contract import ContractMonitor
from structured_text.language.types import BlockType, ElementaryType, Type, Variable

EDGE = "Execute Done Busy Active CommandAborted Error ErrorID"
LEVEL = "Enable Valid Busy Error ErrorID"
PLAIN = "Error ErrorID"


def _kind(pin: str) -> ElementaryType:
    return ElementaryType("WORD" if pin == "ErrorID" else "BOOL")


class _Pins:
    """A program with one block B, in `Main` or in a block `Outer` of `Main`."""

    engine = "made up"

    def __init__(self, pins: str, inner: bool) -> None:
        names = pins.split()
        block = BlockType("FB_B", tuple(Variable(pin, _kind(pin), "VAR_INPUT") for pin in names))
        if inner:
            outer = BlockType("FB_OUTER", (Variable("B", block, "VAR"),))
            self.main = BlockType("P", (Variable("Outer", outer, "VAR"),))
        else:
            self.main = BlockType("P", (Variable("B", block, "VAR"),))
        self.now: dict[str, Any] = {}

    def instances(self) -> Mapping[str, Type]:
        return {"Main": self.main}

    def reader(self, paths: Sequence[str]) -> Callable[[], tuple[Any, ...]]:
        pins = [path.rpartition(".")[2] for path in paths]
        return lambda: tuple(
            self.now.get(pin, 0) if pin == "ErrorID" else bool(self.now.get(pin)) for pin in pins
        )


def judge(
    scans: str, pins: str = EDGE, *, steady: bool = True, inner: bool = False
) -> list[tuple[int, str]]:
    """Return the violations of a block, each with its scan.

    Args:
        scans: A word for each scan. A word has a letter for each pin that is TRUE: B Busy, D Done,
            E Error, V Valid, A Active, C CommandAborted, X Execute, N Enable, and I if ErrorID is
            not 0.
        pins: The pins that the block has.
        steady: Whether the program calls the block in every scan.
        inner: Whether the block is inside of another block.
    """
    letters = {"X": "Execute", "I": "ErrorID", "N": "Enable", "C": "CommandAborted", "A": "Active"}
    letters |= {"D": "Done", "B": "Busy", "E": "Error", "V": "Valid"}
    program = _Pins(pins, inner)
    names = {"FB_OUTER.B", "P.OUTER"} if inner else {"P.B"}
    monitor = ContractMonitor(program, names if steady else ())  # type: ignore[arg-type]
    found = []
    for number, word in enumerate(scans.split()):
        program.now = {letters[one]: 0x8001 if one == "I" else 1 for one in word if one != "-"}
        for violation in monitor.scan(number * 10_000, number):
            begin = f"plc, scan {number}: contract: Main.{'Outer.' if inner else ''}B: "
            assert violation.text.startswith(begin)
            assert violation.rule == "contract"
            found.append((number, violation.text.removeprefix(begin)))
    return found


LEGAL = [
    "- - XB XBA XBA XD XD D - -",
    "XB B BA D - XD D -",  # Execute falls at once: the end is shown for one scan
    "XB B D - -",
    "XD XD D - XD D -",
    "XEI XEI EI - -",
    "XB XBA XEI EI - XB XC XC C - -",
    "XB XBA B B XBA XD D -",  # an edge while busy is ignored
    "XB D XB XD -",  # the block may start again at once
    "XB XD XD - -",
    "XB XEI EI XD -",
]


@pytest.mark.parametrize("scans", LEGAL)
def test_a_block_that_keeps_the_contract_breaks_no_clause(scans: str) -> None:
    assert judge(scans) == []
    assert judge(scans, inner=True) == []


TOGETHER = "are true together; expected at most one"
ID = "Error is true exactly when ErrorID is not 0"
FELL = "Busy fell without an end; expected Done or Error for at least one scan"
NOTHING = "no Busy, Done or Error in the call of the rising edge"
LONGER = "is shown for more than one scan after Execute has fallen"
UNASKED = "without a rising edge of Execute"
GONE = "is gone while Execute is true"


@pytest.mark.parametrize(
    ("scans", "finding"),
    [
        ("- XB XBD XD", (2, f"Busy and Done {TOGETHER}")),
        ("- XB XBEI XEI", (2, f"Busy and Error {TOGETHER}")),
        ("- XB XBC XC", (2, f"Busy and CommandAborted {TOGETHER}")),
        ("- XB XDEI -", (2, f"Done and Error {TOGETHER}")),
        ("- XB XDC -", (2, f"Done and CommandAborted {TOGETHER}")),
        ("- XB XEIC -", (2, f"Error and CommandAborted {TOGETHER}")),
        ("- XB XBDEI XD", (2, f"Busy and Done and Error {TOGETHER}")),
        ("- XB XDA XD", (2, "Active is true without Busy")),
        ("- XB XEIA XEI", (2, "Active is true without Busy")),
        ("- XB XCA XC", (2, "Active is true without Busy")),
        ("- A -", (1, "Active is true without Busy")),
        ("- XB XE XEI", (2, f"Error is TRUE with ErrorID 16#0000; {ID}")),
        ("- XB XDI XD", (2, f"Error is FALSE with ErrorID 16#8001; {ID}")),
        ("- XBI XB XD", (1, f"Error is FALSE with ErrorID 16#8001; {ID}")),
        ("- I -", (1, f"Error is FALSE with ErrorID 16#8001; {ID}")),
        ("- XB B - -", (3, FELL)),
        ("- XB X -", (2, FELL)),
        ("- X -", (1, NOTHING)),
        ("- XD D X -", (3, NOTHING)),
        ("- XD X -", (2, f"Done {GONE}")),
        ("- XEI X -", (2, f"Error {GONE}")),
        ("- XC X -", (2, f"CommandAborted {GONE}")),
        ("- XD D D -", (3, f"Done {LONGER}")),
        ("- XEI EI EI EI -", (3, f"Error {LONGER}")),
        ("- XC C C -", (3, f"CommandAborted {LONGER}")),
        ("- XB B D D -", (4, f"Done {LONGER}")),
        ("- B D -", (1, f"Busy {UNASKED}")),
        ("- D -", (1, f"Done {UNASKED}")),
        ("- EI -", (1, f"Error {UNASKED}")),
        ("- XD XB XD", (2, f"Busy {UNASKED}")),
        ("- XD XEI XEI", (2, f"Error {UNASKED}")),
        ("- XD B D -", (2, f"Busy {UNASKED}")),
    ],
)
def test_each_clause_of_an_edge_block_is_reported_alone(
    scans: str, finding: tuple[int, str]
) -> None:
    assert judge(scans) == [finding]
    assert judge(scans, inner=True) == [finding]


@pytest.mark.parametrize(
    "scans", ["- X XB XD", "- XD X XD", "- XD D D -", "- B D -", "- XD XB XD", "- XD B D -"]
)
def test_clauses_about_execute_need_a_certain_call(scans: str) -> None:
    assert judge(scans, steady=False) == []


@pytest.mark.parametrize("scans", ["- NB B V -", "- N NV -", "- NEI EI -"])
def test_clauses_about_enable_need_a_certain_call(scans: str) -> None:
    assert judge(scans, LEVEL, steady=False) == []


def test_an_inner_block_may_be_called_twice_if_its_call_is_not_certain() -> None:
    """An inner block may be called twice in a scan, so its end may be missing.

    A block that the program calls in every scan must show its end.
    """
    assert judge("- XB B -", steady=False, inner=True) == []
    assert judge("- XB B -", steady=False) == [(3, FELL)]


def test_a_lasting_fault_is_reported_once_and_again_when_it_returns() -> None:
    assert [scan for scan, _ in judge("- XBA XDA XDA XD XDA -", steady=False)] == [2, 5]


@pytest.mark.parametrize(
    ("scans", "findings"),
    [
        ("- N- NB NB NV NV - NV -", [(1, "no Valid, Busy or Error while Enable is true")]),
        ("- NB NVB NV -", [(2, f"Valid and Busy {TOGETHER}")]),
        ("- NB NVEI NV -", [(2, f"Valid and Error {TOGETHER}")]),
        ("- NB NBEI NV -", [(2, f"Busy and Error {TOGETHER}")]),
        ("- NV V -", [(2, "Valid is true while Enable is FALSE")]),
        ("- NB B -", [(2, "Busy is true while Enable is FALSE")]),
        ("- NEI EI -", [(2, "Error is true while Enable is FALSE")]),
        ("- NE NEI -", [(1, f"Error is TRUE with ErrorID 16#0000; {ID}")]),
        ("- NVI NV -", [(1, f"Error is FALSE with ErrorID 16#8001; {ID}")]),
        ("- NB NV NEI - NEI NB NV -", []),
    ],
)
def test_each_clause_of_a_level_block_is_reported_alone(
    scans: str, findings: list[tuple[int, str]]
) -> None:
    assert judge(scans, LEVEL) == findings


@pytest.mark.parametrize(
    ("scans", "findings"),
    [
        ("- EI EI -", []),
        ("- E EI -", [(1, f"Error is TRUE with ErrorID 16#0000; {ID}")]),
        ("- I I -", [(1, f"Error is FALSE with ErrorID 16#8001; {ID}")]),
    ],
)
def test_any_block_with_an_error_has_its_number(
    scans: str, findings: list[tuple[int, str]]
) -> None:
    assert judge(scans, PLAIN) == findings


def test_a_block_without_some_pins_is_judged_by_those_it_has() -> None:
    short = "Execute Done Busy Error"
    assert judge("- XB XE E -", short) == []
    assert judge("- XB XDE -", short) == [(2, f"Done and Error {TOGETHER}")]
    assert judge("- E E -", "Error") == [], "without ErrorID, any block may be meant"


def test_a_block_passed_by_reference_is_judged_where_it_is_declared() -> None:
    """A block passed as VAR_IN_OUT is judged only where it is declared."""
    block = BlockType(
        "FB_B", tuple(Variable(pin, _kind(pin), "VAR_INPUT") for pin in PLAIN.split())
    )
    using = BlockType("FB_USER", (Variable("Ref", block, "VAR_IN_OUT"),))
    program = _Pins(PLAIN, inner=False)
    program.main = BlockType("P", (Variable("B", block, "VAR"), Variable("User", using, "VAR")))
    watched = ContractMonitor(program).instances  # type: ignore[arg-type]
    assert [one.path for one in watched] == ["Main.B"]
