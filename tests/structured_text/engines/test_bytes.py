"""Tests of the bytes of process images, and of calculated indices, on every engine."""

from __future__ import annotations

from pathlib import Path

import pytest

from both_engines import ENGINES
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.errors import InputError

_SOURCE = """PROGRAM Plant
  VAR
    B : ARRAY [0..7] OF BYTE;
    W : ARRAY [1..4] OF WORD;
    K : INT;
    U : UINT;
    Below : ARRAY [-2..2] OF INT;
  END_VAR
  B[K + 1] := BYTE#16#55;
  W[U - UINT#1] := WORD#16#1234;
  Below[K - 2] := 7;
END_PROGRAM
"""


@pytest.fixture(params=ENGINES)
def plant(request: pytest.FixtureRequest, tmp_path: Path) -> Program:
    file = tmp_path / "Plant.st"
    file.write_text(_SOURCE, encoding="utf-8")
    return build([file], request.param).program


def test_a_part_of_an_array_is_read_and_written_as_bytes(plant: Program) -> None:
    """Words are read and written little endian, for any lower bound of the array.

    Source: engines.base.Program.read_bytes and write_bytes.
    """
    plant.write_bytes("Main.B", b"\x01\x02", 3)
    assert plant.read_bytes("Main.B") == bytes([0, 0, 0, 1, 2, 0, 0, 0])
    assert plant.read_bytes("Main.B", 3, 2) == b"\x01\x02"
    assert plant.read_bytes("Main.B", 4) == bytes([2, 0, 0, 0])
    plant.write_bytes("Main.W", b"\x34\x12", 2)
    assert plant.read("Main.W") == [0, 0x1234, 0, 0]
    assert plant.read_bytes("Main.W", 2, 4) == b"\x34\x12\0\0"


@pytest.mark.parametrize(
    ("path", "data", "start"),
    [("Main.B", b"12", 7), ("Main.W", b"12", 1), ("Main.W", b"1", 2), ("Main.W", b"12", 8)],
)
def test_bytes_that_do_not_fit_into_an_array_are_refused(
    plant: Program, path: str, data: bytes, start: int
) -> None:
    """Bytes that do not fit into the array are refused, and nothing is written.

    Source: engines.base.Program.write_bytes: whole elements, within the array.
    """
    with pytest.raises(InputError, match=f"{path} holds 8 bytes and cannot take {len(data)} from"):
        plant.write_bytes(path, data, start)
    assert plant.read_bytes(path) == bytes(8)


def test_a_calculated_index_selects_the_element(plant: Program) -> None:
    """An expression as an index selects the right element.

    Source: IEC 61131-3, 6.5.1.
    """
    plant.write("Main.K", 4)
    plant.write("Main.U", 3)
    plant.scan(0)
    assert plant.read_bytes("Main.B") == bytes([0, 0, 0, 0, 0, 0x55, 0, 0])
    assert plant.read("Main.W") == [0, 0x1234, 0, 0]
    assert plant.read("Main.Below") == [0, 0, 0, 0, 7]


@pytest.mark.parametrize(
    ("k", "u", "told"),
    [
        (7, 2, "index 8 is outside 0..7"),
        (32767, 2, "index -32768 is outside 0..7"),
        (-2, 2, "index -1 is outside 0..7"),
        (0, 0, "index 65535 is outside 1..4"),
        (0, 1, "index 0 is outside 1..4"),
        (5, 2, "index 3 is outside -2..2"),
    ],
)
def test_an_index_wraps_before_its_check(tmp_path: Path, k: int, u: int, told: str) -> None:
    """An index of INT 32767 + 1 wraps to -32768 before the bounds are checked.

    matiec is left out, because its C code does not check bounds.

    Source: IEC 61131-3, 6.5.1, and the arithmetic of test_arithmetic.py.
    """
    file = tmp_path / "Plant.st"
    file.write_text(_SOURCE, encoding="utf-8")
    plant = build([file], "builtin").program
    plant.write("Main.K", k)
    plant.write("Main.U", u)
    with pytest.raises(InputError, match=told):
        plant.scan(0)
