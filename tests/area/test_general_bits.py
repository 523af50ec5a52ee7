"""General-purpose bits and ports: SI(20) to SI(157), SO(20) to SO(157), counted in octal."""

from __future__ import annotations

import pytest

from areas_bench import AreasBench

#: Ports as chapter 1, 4.1 prints them, and their bytes from m or n.
PRINTED = {2: 34, 3: 35, 4: 36, 5: 37, 6: 38, 7: 39, 10: 40, 11: 41, 12: 42, 13: 43, 14: 44, 15: 45}

#: Neither of these is a port: dedicated, not octal, reserved, or nowhere.
NO_PORTS = [-1, 0, 1, 8, 9, 16, 17, 20, 27, 32767, -32768]

#: Dedicated bits; digits 8 and 9; ports 8, 9, 16 and beyond.
NO_BITS = [0, 1, 6, 10, 17, 18, 19, 28, 29, 80, 87, 90, 97, 98, 99, 108, 158, 159, 160, 167, 200]
NO_BITS += [-1, -20, -27, 32767, -32768]


@pytest.mark.parametrize(("port", "byte"), PRINTED.items())
def test_each_bit_of_a_port_is_read_from_its_address_and_no_other(port: int, byte: int) -> None:
    """Source: manual chapter 1, 4.1, serial output."""
    plc = AreasBench(m=12)
    for bit in range(8):
        plc.so[32:48] = bytes(16)
        plc.so[byte] = 1 << bit
        assert plc.read("ReadBit", Port=10 * port + bit) == (True, True, 0)
        plc.so[32:48] = bytes([0xFF] * 16)
        plc.so[byte] = 0xFF & ~(1 << bit)
        assert plc.read("ReadBit", Port=10 * port + bit) == (False, True, 0)


@pytest.mark.parametrize(("port", "byte"), PRINTED.items())
def test_each_bit_of_a_port_is_written_to_its_address_and_no_other(port: int, byte: int) -> None:
    """Source: manual chapter 1, 4.1, serial input."""
    plc = AreasBench(n=100)
    for bit in range(8):
        for state, others in ((True, 0x00), (False, 0xFF)):
            plc.fill(others)
            assert plc.write("WriteBit", Port=10 * port + bit, Value=state) == 0
            expected = bytearray([others] * 512)
            expected[100 + byte] ^= 1 << bit
            expected[100:134] = plc.image[100:134]
            assert plc.image == bytes(expected)


@pytest.mark.parametrize("size", [48, 256])
@pytest.mark.parametrize(("port", "byte"), PRINTED.items())
def test_a_whole_port_is_one_byte_at_its_address(port: int, byte: int, size: int) -> None:
    """Source: manual chapter 1, 4.1 and 4.2, SO2() to SO15(), SI2() to SI15()."""
    plc = AreasBench(size=size, m=20, n=30)
    plc.so[byte] = 0x9C
    assert plc.read("ReadPort", Port=port) == (0x9C, True, 0)
    plc.fill(0xA5)
    assert plc.write("WritePort", Port=port, Value=0x63) == 0
    expected = bytearray([0xA5] * 512)
    expected[30 + byte] = 0x63
    expected[30:64] = plc.image[30:64]
    assert plc.image == bytes(expected)


def test_the_manuals_values_of_port_2() -> None:
    """SI2() = 7Fh is 127 for the program; SO2() = 127 shows 7Fh; SO(20) = 1 is (m + 34) 0.

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
def test_a_number_that_is_no_general_purpose_port_is_refused(port: int) -> None:
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
def test_a_number_that_is_no_general_purpose_bit_is_refused(port: int) -> None:
    """SI(18), SI(28), SI(80), SI(160) and the dedicated ones: none of these can be written.

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
@pytest.mark.parametrize(
    ("offset", "size", "error"), [(0, 47, 0x8030), (466, 48, 0x8031), (-2, 48, 0x8031)]
)
def test_bits_of_an_illegal_area_are_refused(kind: str, offset: int, size: int, error: int) -> None:
    plc = AreasBench()
    plc.fill(0xA5)
    plc[f"Read{kind}.m"], plc[f"Read{kind}.Size"] = offset, size
    plc[f"Write{kind}.n"], plc[f"Write{kind}.Size"] = offset, size
    plc.change("Writing", to=True)
    assert plc[f"Read{kind}.ErrorID"] == plc[f"Write{kind}.ErrorID"] == error
    assert plc[f"Read{kind}.Valid"] is False
    assert plc.image[47:] == bytes([0xA5] * 465)


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
def test_without_connection_no_bit_is_believed(kind: str) -> None:
    """Source: manual chapter 1, 5.2: communication is disabled in the connection error state."""
    plc = AreasBench()
    plc.so[34] = 0xFF
    assert plc.read(f"Read{kind}")[1:] == (True, 0)
    plc["Connected"] = False
    assert plc.read(f"Read{kind}") == (0, False, 0x8001)
    plc["Connected"] = True
    assert plc.read(f"Read{kind}")[1:] == (True, 0)


@pytest.mark.parametrize("kind", ["Bit", "Port"])
def test_an_illegal_port_is_told_before_a_missing_connection(kind: str) -> None:
    """It does not go away with the connection's return."""
    plc = AreasBench()
    plc["Connected"] = False
    assert plc.read(f"Read{kind}", Port=8) == (0, False, 0x8033)
