"""FB_WriteArea: what goes into the process image, and what is left alone."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench

#: Dedicated inputs as chapter 5, 2 prints them: (byte from n, bit, field of RCX_SI).
PRINTED = [
    (32, 0, "SI00_EmergencyStop"),
    (32, 1, "SI01_ServoOn"),
    (32, 6, "SI06_Stop"),
    (33, 0, "SI10_SequenceControl"),
    (33, 2, "SI12_AutoStart"),
    (33, 4, "SI14_ReturnToOriginIncr"),
    (33, 5, "SI15_ProgramReset"),
    (33, 6, "SI16_AlarmReset"),
    (33, 7, "SI17_ReturnToOriginAbs"),
]


@pytest.mark.parametrize(("byte", "bit", "name"), PRINTED)
def test_each_dedicated_input_goes_to_its_bit_and_no_other(byte: int, bit: int, name: str) -> None:
    """Source: manual chapter 5, 2, bit input."""
    plc = PlcBench()
    plc["EmergencyStopOk"] = plc["StopOk"] = False
    plc.scan(13)
    if name == "SI00_EmergencyStop":
        plc["EmergencyStopOk"] = True
    elif name == "SI06_Stop":
        plc["StopOk"] = True
    else:
        plc[f"Robot.Request.{name}"] = True
    plc.scan()
    assert plc.image[byte] == 1 << bit
    assert plc.image[32:34].count(0) == 1


@pytest.mark.parametrize(("size", "n"), [(48, 0), (48, 3), (48, 464), (256, 0), (256, 256)])
def test_only_bytes_n_to_n_plus_33_are_written(size: int, n: int) -> None:
    """General-purpose bytes belong to the user, the reserved ones to nobody.

    Source: manual chapter 1, 4.1 and 4.2; chapter 5, 1, reserved area.
    """
    plc = PlcBench(size=size, n=n)
    plc.program.write_bytes("Main.OutputArea", bytes([0xA5] * 512))
    plc.outputs(SO01=True)
    plc["First.Code"] = 0x0001
    plc["First.Data"] = [0xFFFF] * 15
    plc["First.Execute"] = True
    plc.scan(60)
    assert plc.words == [0x0001] + [0xFFFF] * 15
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.image[:n] == bytes([0xA5] * n)
    assert plc.image[n + 34 :] == bytes([0xA5] * (512 - n - 34))


@pytest.mark.parametrize(
    ("size", "n", "error"),
    [(47, 0, 0x8030), (0, 0, 0x8030), (48, 465, 0x8031), (48, -1, 0x8031), (256, 257, 0x8031)],
)
def test_an_illegal_area_is_refused_and_nothing_is_written(size: int, n: int, error: int) -> None:
    plc = PlcBench()
    plc["WriteArea.Size"], plc["WriteArea.n"] = size, n
    plc.program.write_bytes("Main.OutputArea", bytes([0xA5] * 512))
    plc.outputs(SO01=True)
    plc.scan(50)
    assert plc["WriteArea.Error"] is True
    assert plc["WriteArea.ErrorID"] == error
    assert plc.image == bytes([0xA5] * 512)


def test_words_go_out_with_the_lower_byte_first() -> None:
    """Source: guide chapter 1, 1.1, little endian."""
    plc = PlcBench()
    plc.power_up()
    plc["First.Code"] = 0x1234
    plc["First.Data[1]"] = 0x5678
    plc["First.Data[15]"] = 0x9ABC
    plc["First.Execute"] = True
    plc.scan(2)
    assert plc.image[0:4] == bytes([0x34, 0x12, 0x78, 0x56])
    assert plc.image[30:32] == bytes([0xBC, 0x9A])


@pytest.mark.parametrize(
    ("hold", "name"), [("HoldEmergency", "SI00"), ("HoldStop", "SI06")], ids=["SI00", "SI06"]
)
def test_an_input_that_a_block_holds_is_off_whatever_the_pin_says(hold: str, name: str) -> None:
    """Source: manual chapter 5, 2, SI(00) and SI(06): OFF stops."""
    plc = PlcBench()
    plc.power_up()
    plc[f"Robot.{hold}"] = True
    plc.scan()
    assert plc.inputs == [one for one in ("SI00", "SI06") if one != name]
    plc.scan(50)
    assert name not in plc.inputs
    plc[f"Robot.{hold}"] = False
    plc.scan()
    assert plc.inputs == ["SI00", "SI06"]
