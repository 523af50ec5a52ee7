"""The blocks of ports and bits alone, on an image in which no two words are alike."""

from __future__ import annotations

from functools import cache

import pytest

from alone import Alone

#: Ports as the manual prints them, and the byte of the area that each of them is.
_PORTS = {
    **{port: 32 + port for port in range(2, 8)},
    **{port: 30 + port for port in range(10, 16)},
}
_IMAGE = bytes((0x5B * k + k // 256 + 0x2D) % 256 for k in range(512))
_TWINS = ("", "InWords")


@cache
def _compiled(block: str) -> Alone:
    image = "RCX_IMAGE_WORDS" if block.endswith("InWords") else "RCX_IMAGE"
    robot = {"Robot": "RCX_REF"} if "Read" in block else {}
    return Alone(block, {**robot, "Image": image})


def _block(name: str, offset: int) -> Alone:
    alone = _compiled(name)
    alone.restart()
    words = [low | high << 8 for low, high in zip(_IMAGE[::2], _IMAGE[1::2], strict=True)]
    alone["Image"] = words if name.endswith("InWords") else list(_IMAGE)
    if "Read" in name:
        alone["Robot.Connected"] = True
    alone["Block.m" if "Read" in name else "Block.n"] = offset
    return alone


def _bytes(alone: Alone, name: str) -> bytes:
    image = alone["Image"]
    assert isinstance(image, list)
    if name.endswith("InWords"):
        return b"".join(word.to_bytes(2, "little") for word in image)
    return bytes(image)


@pytest.mark.parametrize("offset", [0, 100, 464])
@pytest.mark.parametrize("twin", _TWINS)
def test_a_bit_is_written_and_everything_beside_it_stays(twin: str, offset: int) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.1: SI(20) to SI(157), counted in octal."""
    name = f"FB_WriteBit{twin}"
    alone = _block(name, offset)
    expected = bytearray(_IMAGE)
    for port, byte in _PORTS.items():
        for digit in range(8):
            for state in (not expected[offset + byte] >> digit & 1, port % 2 == 0):
                expected[offset + byte] &= ~(1 << digit)
                expected[offset + byte] |= state << digit
                alone["Block.Port"], alone["Block.Value"] = 10 * port + digit, state
                alone.scan(0)
                assert _bytes(alone, name) == bytes(expected), (port, digit, state)
                assert alone["Block.Error"] is False


@pytest.mark.parametrize("offset", [0, 100, 464])
@pytest.mark.parametrize("twin", _TWINS)
def test_a_port_is_written_and_everything_beside_it_stays(twin: str, offset: int) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.1: SI2() to SI15(), counted in octal."""
    name = f"FB_WritePort{twin}"
    alone = _block(name, offset)
    expected = bytearray(_IMAGE)
    for port, byte in _PORTS.items():
        expected[offset + byte] ^= 0xC6
        alone["Block.Port"], alone["Block.Value"] = port, expected[offset + byte]
        alone.scan(0)
        assert _bytes(alone, name) == bytes(expected), port
        assert alone["Block.Error"] is False


@pytest.mark.parametrize("offset", [0, 100, 464])
@pytest.mark.parametrize("twin", _TWINS)
def test_every_port_and_every_bit_is_read_from_its_place(twin: str, offset: int) -> None:
    """Source: manual chapter 1, 4.1; chapter 3, 2.2: SO(20) to SO(157), counted in octal."""
    port_block, bit_block = (_block(f"FB_Read{kind}{twin}", offset) for kind in ("Port", "Bit"))
    for port, byte in _PORTS.items():
        port_block["Block.Port"] = port
        port_block.scan(0)
        assert port_block["Block.Value"] == _IMAGE[offset + byte], port
        for digit in range(8):
            bit_block["Block.Port"] = 10 * port + digit
            bit_block.scan(0)
            assert bit_block["Block.Value"] is bool(_IMAGE[offset + byte] >> digit & 1)
            assert bit_block["Block.Valid"] is True
