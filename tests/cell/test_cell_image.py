from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, InputError, RobotConfig

Build = Callable[..., Cell]


def write(folder: Path, declarations: str) -> Path:
    file = folder / "Variants.st"
    file.write_text(
        "TYPE\n  RCX_IMAGE : ARRAY [0..511] OF BYTE;\nEND_TYPE\n"
        "TYPE\n  RCX_WORD_IMAGE : ARRAY [0..255] OF WORD;\nEND_TYPE\n"
        f"PROGRAM Variants\n{declarations}\n  VAR\n    k : UINT;\n  END_VAR\n  k := k + UINT#1;\n"
        "END_PROGRAM\n"
    )
    return file


@pytest.fixture
def located(build_cell: Build, repository: Path, tmp_path: Path) -> Build:
    program = repository / "tests" / "cell" / "programs" / "Located.st"

    def build(**options: object) -> Cell:
        return build_cell(program, lib=tmp_path, robot=RobotConfig(boot_time=0.0), **options)

    return build


def test_located_words_and_bits_are_the_process_image(located: Build) -> None:
    """Located variables use the areas: %IW1 is bytes 2 and 3, and %QX32.0 is bit 0 of byte 32.

    Source: manual chapter 5, 1 (addresses of the words and bits).
    """
    cell = located()
    cell.run("50ms")
    assert cell["Main.CpuOk"] is True
    cell["Main.Emergency"] = True
    cell["Main.Speed"] = 0x1234
    cell["Main.Code"] = 0x0FFF
    cell.run("50ms")
    sampled = cell.trace.cycles()[-1].rcx_si
    assert (sampled[0:2].hex(), sampled[6:8].hex(), sampled[32]) == ("ff0f", "3412", 1)
    assert cell["Main.Status"] == 0x4000


def test_located_arrays_are_the_process_image(build_cell: Build, tmp_path: Path) -> None:
    """A located array of 48 bytes contains the inputs, and one of 24 words contains the outputs.

    The low byte of a word comes first.

    Source: manual chapter 5, 1 (addresses of the words and bits).
    """
    text = """PROGRAM Arrays
  VAR
    In AT %IB0 : ARRAY [0..47] OF BYTE;
    Out AT %QW0 : ARRAY [1..3, 1..8] OF UINT;
  END_VAR
  Out[1, 2] := TO_UINT(In[1]);
END_PROGRAM
"""
    (tmp_path / "Arrays.st").write_text(text, encoding="utf-8")
    cell = build_cell(
        tmp_path / "Arrays.st", lib=tmp_path, robot=RobotConfig(boot_time=0.0), engine="builtin"
    )
    cell.run("50ms")
    cell["Main.Out[1,1]"] = 0x0FFF
    cell["Main.Out[3,1]"] = 0x0001
    cell.run("50ms")
    sampled = cell.trace.cycles()[-1].rcx_si
    assert (sampled[0:4].hex(), sampled[32:34].hex()) == ("ff0f4000", "0100")
    assert cell["Main.In"][0:2] == [0x00, 0x40]
    assert (cell["Main.In[1]"], cell["Main.Out[1,2]"]) == (0x40, 0x40)


def test_a_negative_word_is_read_into_a_signed_variable(located: Build) -> None:
    cell = located()
    cell.run("20ms")
    cell.robot.force("SOW(1)", 0xFFFE)
    cell.run("50ms")
    assert cell["Main.Group"] == -2


def test_an_offset_without_located_variables_is_refused(located: Build) -> None:
    with pytest.raises(InputError, match="no located variable lies in the area at m = 100"):
        located(m=100)


def test_output_variables_that_overlap_are_refused(build_cell: Build, tmp_path: Path) -> None:
    program = write(
        tmp_path,
        "  VAR\n    A AT %IW0 : WORD;\n    B AT %QW0 : WORD;\n    C AT %QX1.0 : BOOL;\n  END_VAR",
    )
    with pytest.raises(InputError, match=r"Main\.C and Main\.B overlap in the area to the robot"):
        build_cell(program, lib=tmp_path)


def test_areas_that_overlap_in_one_memory_are_refused(build_cell: Build, tmp_path: Path) -> None:
    program = write(tmp_path, "  VAR\n    A AT %MW0 : WORD;\n    B AT %MW20 : WORD;\n  END_VAR")
    with pytest.raises(InputError, match="the areas at m = 0 and n = 40 overlap in %M"):
        build_cell(program, lib=tmp_path, m=0, n=40)


def test_adjacent_areas_in_one_memory_are_accepted(build_cell: Build, tmp_path: Path) -> None:
    program = write(tmp_path, "  VAR\n    A AT %MW0 : WORD;\n    B AT %MX80.0 : BOOL;\n  END_VAR")
    cell = build_cell(program, lib=tmp_path, m=0, n=48, robot=RobotConfig(boot_time=0.0))
    cell.run("50ms")
    cell["Main.B"] = True
    cell.run("50ms")
    assert cell.trace.cycles()[-1].rcx_si[32] == 1


def test_an_image_of_words_needs_even_offsets(build_cell: Build, tmp_path: Path) -> None:
    program = write(
        tmp_path,
        "  VAR\n    InputArea : RCX_WORD_IMAGE;\n    OutputArea : RCX_WORD_IMAGE;\n  END_VAR",
    )
    cell = build_cell(program, lib=tmp_path, m=4, n=2, robot=RobotConfig(boot_time=0.0))
    cell["Main.OutputArea[1]"] = 0x0FFF
    cell.run("100ms")
    assert cell.trace.cycles()[-1].rcx_si[0:2].hex() == "ff0f"
    assert cell["Main.InputArea[2]"] == 0x4000
    with pytest.raises(InputError, match=r"m = 3 is odd, but Main\.InputArea is an array of WORD"):
        build_cell(program, lib=tmp_path, m=3)


@pytest.mark.parametrize(
    ("declarations", "message"),
    [
        ("", "the program has no process image"),
        ("  VAR\n    InputArea : RCX_IMAGE;\n  END_VAR", "has Main.InputArea, but needs both"),
        (
            "  VAR\n    InputArea : RCX_IMAGE;\n    OutputArea : INT;\n  END_VAR",
            "Main.OutputArea is not an array of BYTE or WORD",
        ),
    ],
)
def test_a_program_without_a_process_image_is_refused(
    build_cell: Build, tmp_path: Path, declarations: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        build_cell(write(tmp_path, declarations), lib=tmp_path)
