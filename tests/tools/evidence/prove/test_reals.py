"""The assumptions of the proofs are true: limits of a sine, and the sign of a root's argument."""

from __future__ import annotations

from pathlib import Path

import pytest
import z3

from proving import library, statuses
from rcx_tools.evidence.prove import contract, overflow, safety
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.solve import ask
from rcx_tools.evidence.prove.summaries import SUMMARIES
from structured_text.prove import reals

pytestmark = pytest.mark.exhaustive

(_CONTRACT,), (_OVERFLOW,), (_SAFETY,) = (
    contract.PROPERTIES,
    overflow.PROPERTIES,
    safety.PROPERTIES,
)
_ROOT_OF = """FUNCTION_BLOCK FB_Root
  VAR_INPUT
    x, y : REAL;
  END_VAR
  VAR_OUTPUT
    Root : REAL;
  END_VAR
  VAR
    Sum  : REAL;
    Rest : INT;
  END_VAR

  Sum := {};
  IF Sum < 0.0 THEN
    Sum := 0.0;
  END_IF;
  Rest := 1;
  Root := SQRT({});
END_FUNCTION_BLOCK
"""


def _root(folder: Path, number: str, total: str = "x") -> Library:
    (folder / "FB_Root.st").write_text(_ROOT_OF.format(total, number), encoding="utf-8")
    return Library(folder)


@pytest.mark.parametrize("name", ["SIN", "COS", "ATAN"])
def test_a_sine_is_any_number_and_the_same_for_the_same_angle(name: str, tmp_path: Path) -> None:
    machine = library(tmp_path, "FC_RcxTickets").machine()
    angle, other = (reals.anything(pin, "REAL") for pin in ("angle", "other"))
    first, again, second = (SUMMARIES[name](machine, [one]).value for one in (angle, angle, other))
    assert ask((), first == again, 20.0).status == "proved"
    assert ask((), first == second, 20.0).status == "refuted"
    for pattern in (0x3F00_0000, 0x4000_0000, 0x7FC0_0000):  # 0.5, 2.0, NaN
        assert ask((), first != z3.BitVecVal(pattern, 32), 20.0).status == "refuted"


def test_a_sine_and_a_cosine_need_not_be_equal(tmp_path: Path) -> None:
    machine = library(tmp_path, "FC_RcxTickets").machine()
    angle = reals.anything("angle", "REAL")
    sine, cosine = (SUMMARIES[name](machine, [angle]).value for name in ("SIN", "COS"))
    assert ask((), sine == cosine, 20.0).status == "refuted"


@pytest.mark.parametrize("name", ["FB_ScaraForward", "FB_ScaraInverse", "FB_HandFromPoints"])
def test_blocks_with_sines_keep_their_contract_and_their_types(name: str, tmp_path: Path) -> None:
    copy = library(tmp_path, name)
    for item in (_CONTRACT, _OVERFLOW):
        assert statuses(item, copy, name.upper()) == {"proved"}


@pytest.mark.parametrize(
    "number", ["x * x", "x * x + y * y", "Sum", "Sum * Sum + Sum", "(x - y) * (x - y) * Sum"]
)
def test_squares_and_what_is_made_of_them_have_a_root(number: str, tmp_path: Path) -> None:
    assert statuses(_SAFETY, _root(tmp_path, number), "FB_ROOT") == {"proved"}


@pytest.mark.parametrize(
    "number", ["x", "x * y", "x * x + y", "x * x - y * y", "x * x * y", "0.0 - Sum", "Sum - 1.0"]
)
def test_what_can_be_below_zero_has_none(number: str, tmp_path: Path) -> None:
    assert statuses(_SAFETY, _root(tmp_path, number), "FB_ROOT") == {"refuted"}


def test_a_variable_of_a_block_may_be_called_rest(tmp_path: Path) -> None:
    assert statuses(_OVERFLOW, _root(tmp_path, "x * x"), "FB_ROOT") == {"proved"}
