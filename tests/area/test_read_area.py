"""FB_ReadArea reads the controller's outputs from the process image."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench
from rcx_harness import spec
from structured_text.output.toml_files import load_toml

#: Dedicated outputs as in chapter 5, 2: (byte from m, bit, field of RCX_SO).
PRINTED = [
    (32, 0, "SO00_EmergencyStop"),
    (32, 1, "SO01_CpuOk"),
    (32, 2, "SO02_ServoOn"),
    (32, 3, "SO03_Alarm"),
    (32, 4, "SO04_MpRdy"),
    (33, 0, "SO10_AutoMode"),
    (33, 1, "SO11_ReturnToOriginComplete"),
    (33, 2, "SO12_SequenceRunning"),
    (33, 3, "SO13_ProgramRunning"),
    (33, 4, "SO14_ProgramReset"),
    (33, 5, "SO15_Warning"),
]


@pytest.mark.parametrize(("byte", "bit", "name"), PRINTED)
def test_each_dedicated_output_is_read_from_its_bit_and_no_other(
    byte: int, bit: int, name: str
) -> None:
    """Source: manual chapter 5, 2, bit output."""
    plc = PlcBench()
    plc.so[byte] = 1 << bit
    plc.scan()
    assert [field for field, on in plc["Robot.SO"].items() if on] == [name]


@pytest.mark.parametrize(("byte", "bit"), [(32, 5), (32, 6), (32, 7), (33, 6), (33, 7)])
def test_reserved_bits_of_the_dedicated_outputs_are_ignored(byte: int, bit: int) -> None:
    """Source: manual chapter 5, 1, reserved area."""
    plc = PlcBench()
    plc.so[byte] = 1 << bit
    plc.scan()
    assert not any(plc["Robot.SO"].values())


@pytest.mark.parametrize(("size", "m"), [(48, 0), (48, 1), (48, 464), (256, 0), (256, 256)])
def test_words_are_little_endian_at_any_legal_offset(size: int, m: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2; guide chapter 1, 1.1."""
    plc = PlcBench(size=size, m=m)
    plc.so[0:2] = bytes([0x00, 0x02])
    plc.so[2:4] = bytes([0x67, 0x45])
    plc.so[30:32] = bytes([0x23, 0x01])
    plc.so[32] = 0x02
    plc.scan()
    assert plc["Robot.SO.SO01_CpuOk"] is True
    assert plc["Robot.Status"] == 0x0200
    assert plc["Robot.Response[1]"] == 0x4567
    assert plc["Robot.Response[2]"] == 0
    assert plc["Robot.Response[15]"] == 0x0123
    assert plc["ReadArea.Error"] is False


@pytest.mark.parametrize("size", [0, 47, 49, 255, 257, -48])
def test_a_size_other_than_48_or_256_is_refused(size: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2."""
    plc = PlcBench()
    plc["ReadArea.Size"] = size
    plc.outputs(SO01=True, scans=1)
    assert plc["ReadArea.Error"] is True
    assert plc["ReadArea.ErrorID"] == 0x8030
    assert plc["Robot.Connected"] is False
    assert plc["Robot.SO.SO01_CpuOk"] is False


@pytest.mark.parametrize(("size", "m"), [(48, -1), (48, 465), (256, 257), (48, 32767)])
def test_an_area_that_leaves_the_image_is_refused(size: int, m: int) -> None:
    plc = PlcBench()
    plc["ReadArea.Size"], plc["ReadArea.m"] = size, m
    plc.scan()
    assert plc["ReadArea.ErrorID"] == 0x8031
    assert plc["Robot.Connected"] is False


def test_an_image_may_be_as_small_as_its_area() -> None:
    """Source: manual chapter 1, 4.1: 48 bytes."""
    plc = PlcBench()
    plc.change("ReadArea.ImageSize", to=48)
    assert plc["ReadArea.ErrorID"] == 0
    plc.change("ReadArea.ImageSize", to=47)
    assert plc["ReadArea.ErrorID"] == 0x8031


def test_the_scans_of_robots_in_one_image_have_different_numbers() -> None:
    """The scan numbers of a robot begin at its offset m.

    A block that is given another RCX_REF therefore detects the change.

    Source: head of FB_RcxTakeHead, Start.
    """
    plc = PlcBench(m=48)
    for scan in (49, 50, 51):
        plc.scan()
        assert plc["Robot.Inner.Scan"] == scan
        assert plc["Robot.Inner.Elapsed"] == (0 if scan == 49 else 10)


def test_without_connection_no_data_of_the_area_are_used() -> None:
    """Source: manual chapter 1, 5.2: communication is disabled in the connection error state."""
    plc = PlcBench()
    plc.answer(0x4000, [0x000C, 0x0258])
    plc.outputs(SO00=True, SO02=True, scans=1)
    assert plc["Robot.Status"] == 0x4000
    plc.change("Connected", to=False)
    assert plc["Robot.Status"] == 0
    assert plc["Robot.Response"] == [0] * 15
    assert not any(plc["Robot.SO"].values())
    assert plc["Robot.Connected"] is False


_OPEN = """PROGRAM Open
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    InputWords : RCX_IMAGE_WORDS;
    Robot : RCX_REF;
    ReadArea : {0};
    ServoOn : FB_ServoOn;
    Status : FB_Status;
    WriteArea : FB_WriteArea;
  END_VAR
  ReadArea(Robot := Robot, Image := {1});
  ServoOn(Robot := Robot);
  Status(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("block", "image"), [("FB_ReadArea", "InputArea"), ("FB_ReadAreaWords", "InputWords")]
)
def test_an_unwired_connected_pin_means_no_connection(block: str, image: str) -> None:
    """If pin Connected is not wired, it is FALSE, so that a lost link cannot stay unnoticed.

    Source: manual chapter 1, 5.2: communication is disabled in the connection error state.
    """
    plc = PlcBench(program=_OPEN.format(block, image))
    plc.outputs(SO01=True, SO04=True)
    plc.change("ServoOn.Execute", "Status.Enable", to=True, scans=100)
    assert plc["Robot.Connected"] is False
    assert plc.inputs == []
    assert (plc["ServoOn.Error"], plc["ServoOn.ErrorID"]) == (True, 0x8001)
    assert (plc["Status.Error"], plc["Status.ErrorID"]) == (True, 0x8001)


@pytest.mark.parametrize("language", ["", "_ja"])
def test_the_text_of_no_connection_names_the_pin_that_is_to_be_wired(language: str) -> None:
    table = load_toml(spec.folder() / "errors.toml")["error"]
    (row,) = (row for row in table if row["id"] == 0x8001)
    assert "FB_ReadArea.Connected" in row[f"cause{language}"]
    wire = {"": "Wire the scanner's status to FB_ReadArea.Connected", "_ja": "Connectedに"}
    assert row[f"remedy{language}"].startswith(wire[language])


@pytest.mark.parametrize(
    ("low", "high", "value"),
    [
        (0x1111, 0x0001, 69905),  # SOD(2) of chapter 3, 2.2
        (0x0010, 0x0001, 65552),  # SID(2) of chapter 3, 2.1
        (0x4567, 0x0123, 19088743),  # guide chapter 1, 1.1
        (0xB1E0, 0xFFFF, -20000),  # axis data of guide 4.3.1
        (0x0000, 0x8000, -2147483648),
        (0xFFFF, 0x7FFF, 2147483647),
    ],
)
def test_double_words_are_signed_with_the_lower_word_first(low: int, high: int, value: int) -> None:
    """Source: manual chapter 3, 2.1 and 2.2; guide chapter 1, 1.1."""
    plc = PlcBench()
    plc["LowWord"], plc["HighWord"] = low, high
    plc.scan()
    assert plc["DoubleWord"] == value
