"""General-purpose bits and ports: SI(20) to SI(157), SO(20) to SO(157), counted in octal."""

from __future__ import annotations

from functools import cache

import pytest

from alone import Alone
from areas_bench import AreasBench

#: Port numbers that are illegal: dedicated, not octal, reserved, or outside the area.
NO_PORTS = [-1, 0, 1, 8, 9, 16, 17, 20, 27, 32767, -32768]

#: Bit numbers that are illegal: dedicated bits; digits 8 and 9; ports 8, 9, 16 and higher.
NO_BITS = [0, 1, 6, 10, 17, 18, 19, 28, 29, 80, 87, 90, 97, 98, 99, 108, 158, 159, 160, 167, 200]
NO_BITS += [-1, -20, -27, 32767, -32768]


def test_the_manuals_values_of_port_2() -> None:
    """Port 2 has the values of the manual: SI2() = 7Fh is 127, and SO2() = 127 is 7Fh on the wire.

    SO(20) = 1 is bit 0 of byte m + 34.

    Source: manual chapter 3, 2.1 and 2.2, examples of BIT information.
    """
    plc = AreasBench()
    plc.write("WritePort", Port=2, Value=0x7F)
    assert plc.image[34] == 127
    plc.so[34] = 127
    assert plc.read("ReadPort", Port=2)[0] == 0x7F
    assert plc.read("ReadBit", Port=20)[0] is True
    assert plc.read("ReadBit", Port=27)[0] is False
    plc.fill(0)
    plc.write("WriteBit", Port=20, Value=True)
    assert plc.image[34] == 0x01


@pytest.mark.parametrize("port", NO_PORTS)
def test_a_number_that_is_not_a_general_purpose_port_is_refused(port: int) -> None:
    """Source: manual chapter 1, 4.1, notes 2 and 3; chapter 3, 2.1 and 2.2, notes: up to 15."""
    plc = AreasBench(m=100, n=100)
    plc.so[:] = bytes([0xFF] * 48)
    plc.scan()
    plc.fill(0xA5)
    assert plc.read("ReadPort", Port=port) == (0, False, 0x8033)
    before = plc.image
    assert plc.write("WritePort", Port=port, Value=0x12) == 0x8033
    assert plc.image == before


@pytest.mark.parametrize("port", NO_BITS)
def test_a_number_that_is_not_a_general_purpose_bit_is_refused(port: int) -> None:
    """SI(18), SI(28), SI(80), SI(160) and the dedicated inputs cannot be written.

    Source: manual chapter 1, 4.1, notes 2 and 3; chapter 3, 2.1 and 2.2, notes: up to 157.
    """
    plc = AreasBench(m=100, n=100)
    plc.so[:] = bytes([0xFF] * 48)
    plc.scan()
    plc.fill(0xA5)
    assert plc.read("ReadBit", Port=port) == (False, False, 0x8033)
    before = plc.image
    for state in (True, False):
        assert plc.write("WriteBit", Port=port, Value=state) == 0x8033
    assert plc.image == before


@pytest.mark.parametrize("kind", ["Bit", "Port"])
def test_bits_at_an_odd_offset_are_refused_in_an_image_of_words_only(kind: str) -> None:
    plc = AreasBench(m=3, n=3, alike=False)
    plc.change("Writing", to=True)
    for name in (f"Read{kind}", f"Write{kind}"):
        assert plc[f"{name}W.ErrorID"] == 0x8032
        assert plc[f"{name}.ErrorID"] == 0
    plc.so[34] = 0x01
    assert plc.read("ReadBit", Port=20) == (True, True, 0)
    plc.write("WriteBit", Port=151, Value=True)
    assert plc.image[3 + 45] == 0x02


@pytest.mark.parametrize("kind", ["Bit", "Port"])
def test_without_connection_no_bit_is_valid(kind: str) -> None:
    """Source: manual chapter 1, 5.2: communication is disabled in the connection error state."""
    plc = AreasBench()
    plc.so[34] = 0xFF
    assert plc.read(f"Read{kind}")[1:] == (True, 0)
    plc["Connected"] = False
    assert plc.read(f"Read{kind}") == (0, False, 0x8001)
    plc["Connected"] = True
    assert plc.read(f"Read{kind}")[1:] == (True, 0)


@pytest.mark.parametrize("kind", ["Bit", "Port"])
def test_an_illegal_port_is_reported_before_a_missing_connection(kind: str) -> None:
    """Without a connection, an illegal port is still reported as 16#8033.

    The illegal port remains an error after the connection returns.
    """
    plc = AreasBench()
    plc["Connected"] = False
    assert plc.read(f"Read{kind}", Port=8) == (0, False, 0x8033)


# --- the blocks alone, on an image in which all words differ ---

#: Ports as the manual prints them, and the byte of the area for each port.
PRINTED = {
    **{port: 32 + port for port in range(2, 8)},
    **{port: 30 + port for port in range(10, 16)},
}
_IMAGE = bytes((0x5B * k + k // 256 + 0x2D) % 256 for k in range(512))
_AREAS = pytest.mark.parametrize(("size", "offset"), [(48, 0), (256, 100), (48, 464)])
_TWINS = pytest.mark.parametrize("twin", ["", "InWords"])


@cache
def _compiled(block: str) -> Alone:
    image = "RCX_IMAGE_WORDS" if block.endswith("InWords") else "RCX_IMAGE"
    robot = {"Robot": "RCX_REF"} if "Read" in block else {}
    return Alone(block, {**robot, "Image": image})


def _block(name: str, size: int, offset: int) -> Alone:
    alone = _compiled(name)
    alone.restart()
    words = [low | high << 8 for low, high in zip(_IMAGE[::2], _IMAGE[1::2], strict=True)]
    alone["Image"] = words if name.endswith("InWords") else list(_IMAGE)
    if "Read" in name:
        alone["Robot.Connected"] = True
    alone["Block.m" if "Read" in name else "Block.n"], alone["Block.Size"] = offset, size
    return alone


def _bytes(alone: Alone, name: str) -> bytes:
    image = alone["Image"]
    assert isinstance(image, list)
    if name.endswith("InWords"):
        return b"".join(word.to_bytes(2, "little") for word in image)
    return bytes(image)


@_AREAS
@_TWINS
def test_writing_a_bit_does_not_change_the_rest_of_the_area(
    twin: str, size: int, offset: int
) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.1: SI(20) to SI(157), counted in octal."""
    name = f"FB_WriteBit{twin}"
    alone = _block(name, size, offset)
    expected = bytearray(_IMAGE)
    for port, byte in PRINTED.items():
        for digit in range(8):
            for state in (not expected[offset + byte] >> digit & 1, port % 2 == 0):
                expected[offset + byte] &= ~(1 << digit)
                expected[offset + byte] |= state << digit
                alone["Block.Port"], alone["Block.Value"] = 10 * port + digit, state
                alone.scan(0)
                assert _bytes(alone, name) == bytes(expected), (port, digit, state)
                assert alone["Block.Error"] is False


@_AREAS
@_TWINS
def test_writing_a_port_does_not_change_the_rest_of_the_area(
    twin: str, size: int, offset: int
) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.1: SI2() to SI15(), counted in octal."""
    name = f"FB_WritePort{twin}"
    alone = _block(name, size, offset)
    expected = bytearray(_IMAGE)
    for port, byte in PRINTED.items():
        expected[offset + byte] ^= 0xC6
        alone["Block.Port"], alone["Block.Value"] = port, expected[offset + byte]
        alone.scan(0)
        assert _bytes(alone, name) == bytes(expected), port
        assert alone["Block.Error"] is False


@_AREAS
@_TWINS
def test_every_port_and_bit_is_read_from_its_address(twin: str, size: int, offset: int) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.2: SO(20) to SO(157), counted in octal."""
    port_block, bit_block = (
        _block(f"FB_Read{kind}{twin}", size, offset) for kind in ("Port", "Bit")
    )
    for port, byte in PRINTED.items():
        port_block["Block.Port"] = port
        port_block.scan(0)
        assert port_block["Block.Value"] == _IMAGE[offset + byte], port
        for digit in range(8):
            bit_block["Block.Port"] = 10 * port + digit
            bit_block.scan(0)
            assert bit_block["Block.Value"] is bool(_IMAGE[offset + byte] >> digit & 1)
            assert bit_block["Block.Valid"] is True


@_TWINS
@pytest.mark.parametrize("kind", ["Bit", "Port"])
@pytest.mark.parametrize("verb", ["Read", "Write"])
def test_an_illegal_area_is_reported_before_an_illegal_port(
    verb: str, kind: str, twin: str
) -> None:
    """If area and port are both illegal, the block reports the illegal area.

    This holds for images of bytes and of words.

    Source: docs/reference/errors.md, 16#8030 and 16#8033.
    """
    block = _block(f"FB_{verb}{kind}{twin}", 100, 0)
    block["Block.Port"] = 99
    block.scan(0)
    assert block["Block.ErrorID"] == 0x8030
