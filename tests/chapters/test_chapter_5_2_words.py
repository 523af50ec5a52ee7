"""The sentences of chapter 5, 2, about word inputs and word outputs."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell, steps_once

Start = Callable[..., ChapterCell]


def _move_to_19(cell: ChapterCell) -> None:
    """Move to point 19 at 50 % of the speed."""
    cell["Command.Code"], cell["Data[1]"], cell["Data[3]"], cell["Data[4]"] = 1, 4, 50, 19
    assert cell.execute("Command") == 0


def test_siw0_is_the_remote_command_area(start: Start) -> None:
    """The word contains the code, and the controller executes it.

    Source: manual chapter 5, 2, SIW(0)
    """
    cell = start().settle()
    cell["Command.Code"] = 0x0501
    assert cell.execute("Command") == 0
    codes = [one.rcx_si[0:2] for one in cell.cell.trace.cycles() if one.rcx_si and one.rcx_si[0]]
    assert set(codes) == {b"\x01\x05"}


def test_siw1_is_the_command_data_area_of_the_remote_command(start: Start) -> None:
    """SIW(1) has the command's first data word, and is 0 without a command.

    Source: manual chapter 5, 2, SIW(1).
    """
    cell = start().servo_on()
    _move_to_19(cell)
    images = [one.rcx_si for one in cell.cell.trace.cycles() if one.rcx_si]
    assert {image[2:4] for image in images if image[0]} == {b"\x04\x00"}
    assert images[-1][2:4] == b"\x00\x00"


@pytest.mark.parametrize(
    ("number", "size"), [(2, 48), (9, 48), (15, 48), (2, 256), (24, 256), (127, 256)]
)
def test_siw_words_input_word_data_to_the_robot_program(
    start: Start, number: int, size: int
) -> None:
    """A robot program reads SIW words as unsigned numbers, in both sizes of the area.

    Source: manual chapter 5, 2, SIW(2) to SIW(15), SIW(24) to SIW(127)
    """
    cell = start(size=size, **steps_once(f"A=SIW({number})"))
    cell["Number"], cell["Value"] = number, 0xFEDC
    cell.run_short_program()
    assert cell.robot.program.variables["A"] == 0xFEDC


@pytest.mark.parametrize(("number", "size"), [(2, 48), (14, 48), (24, 256), (126, 256)])
def test_sid_double_words_input_double_word_data_to_the_robot_program(
    start: Start, number: int, size: int
) -> None:
    """A robot program reads SID double words as signed numbers.

    Source: manual chapter 5, 2, SID(2) to SID(14), SID(24) to SID(126).
    """
    cell = start(size=size, **steps_once(f"A=SID({number})"))
    cell["WritesDouble"], cell["Number"], cell["DoubleValue"] = True, number, -70_000
    cell.run_short_program()
    assert cell.robot.program.variables["A"] == -70_000


def test_siw2_to_siw15_are_the_command_data_area_of_a_remote_command(start: Start) -> None:
    """While a command is sent, SIW(4) contains command data.

    After the command, SIW(4) contains the word for the robot program again.

    Source: manual chapter 5, 2, SIW(2) to SIW(15)
    """
    cell = start()
    cell["Number"], cell["Value"] = 4, 0xFEDC
    cell.servo_on()
    _move_to_19(cell)
    cell.run("100ms")
    images = [one.rcx_si for one in cell.cell.trace.cycles() if one.rcx_si]
    assert {image[8:10] for image in images if image[0]} == {b"\x13\x00"}
    assert images[-1][8:10] == b"\xdc\xfe"


def test_sow0_and_sow1_are_for_status_and_response_of_remote_commands(start: Start) -> None:
    """Robot programs cannot write SOW(0) and SOW(1).

    Source: manual chapter 5, 2, SOW(0) and SOW(1).
    """
    cell = start().settle()
    for name in ("SOW(0)", "SOW(1)", "SOD(0)"):
        with pytest.raises(Exception, match="not a general-purpose word"):
            cell.robot.write_port(name, 1)
    cell["Command.Code"] = 0x0101
    cell["Data[2]"] = 7  # point 7 is not defined
    cell["Command.Execute"] = True
    cell.cell.run_until(lambda: cell["Command.Error"] is True, within="1s")
    # The guide only names the alarm. The number 6.204 is assumed: docs/explanation/fidelity.md,
    # alarm-names.
    assert (cell["Command.AlarmGroup"], cell["Command.AlarmCategory"]) == (6, 204)


@pytest.mark.parametrize(("number", "size"), [(2, 48), (15, 48), (24, 256), (127, 256)])
def test_sow_words_output_word_data_of_the_robot_program(
    start: Start, number: int, size: int
) -> None:
    """Source: manual chapter 5, 2, SOW(2) to SOW(15), SOW(24) to SOW(127)."""
    cell = start(size=size, **steps_once(f"SOW({number})=&HFEDC"))
    cell["Number"] = number
    cell.run_short_program()
    assert cell["ReadWord.Valid"] is True
    assert cell["ReadWord.Value"] == 0xFEDC


@pytest.mark.parametrize(("number", "size"), [(2, 48), (14, 48), (24, 256), (126, 256)])
def test_sod_double_words_output_double_word_data_of_the_robot_program(
    start: Start, number: int, size: int
) -> None:
    """Source: manual chapter 5, 2, SOD(2) to SOD(14), SOD(24) to SOD(126)."""
    cell = start(size=size, **steps_once(f"SOD({number})=-70000"))
    cell["Number"] = number
    cell.run_short_program()
    assert cell["ReadDouble.Value"] == -70_000


def test_sow2_to_sow15_are_the_response_area_of_a_remote_command(start: Start) -> None:
    """While SOW(2) contains a response, the PLC's reading block shows no valid word.

    The block never shows the response as the robot program's word.

    Source: manual chapter 5, 2, SOW(2) to SOW(15)
    """
    cell = start(**steps_once("SOW(2)=&HFEDC"))
    cell.run_short_program()
    assert cell["ReadWord.Value"] == 0xFEDC
    cell["Command.Code"] = 0x0501
    cell["Command.Execute"] = True
    shown = set()
    while cell["Command.Done"] is False:
        cell.cell.scan()
        shown.add((cell["ReadWord.Valid"], cell["ReadWord.Value"]))
    assert cell["Command.Response[2]"] == 0x0108
    assert shown <= {(True, 0xFEDC), (False, 0)}
    cell.run("100ms")
    assert (cell["ReadWord.Valid"], cell["ReadWord.Value"]) == (True, 0xFEDC)
