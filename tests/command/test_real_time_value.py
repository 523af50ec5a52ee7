"""FB_RealTimeValue and FB_RealTimeValueInWords show any word of the area, or an error."""

from __future__ import annotations

from functools import cache
from itertools import product

import pytest

from alone import Alone

_BLOCKS = ("FB_RealTimeValue", "FB_RealTimeValueInWords")
_SHOWN = ("Unsigned", "Signed", "Long")


@cache
def _compiled(block: str) -> Alone:
    image = "RCX_IMAGE_WORDS" if block.endswith("InWords") else "RCX_IMAGE"
    return Alone(block, {"Robot": "RCX_REF", "Image": image})


def _value(address: int) -> int:
    """Return a different value for each even address.

    As INT, some of the values are negative.
    """
    return (address * 0x4D1 + 0x3A7) % 65536


@pytest.fixture(params=_BLOCKS)
def block(request: pytest.FixtureRequest) -> Alone:
    """Return a block with a connection and an image in which all words differ."""
    alone = _compiled(request.param)
    alone.restart()
    alone["Robot.Connected"] = True
    words = [_value(2 * k) for k in range(256)]
    in_words = request.param.endswith("InWords")
    split = [byte for word in words for byte in (word & 0xFF, word >> 8)]
    alone["Image"] = words if in_words else split
    return alone


def _shown(block: Alone) -> tuple[object, ...]:
    flags = (block["Block.Valid"], block["Block.Error"], block["Block.ErrorID"])
    return (*flags, *(block[f"Block.{pin}"] for pin in _SHOWN))


def _signed(value: int, bits: int) -> int:
    return value - (1 << bits) if value >> (bits - 1) else value


def test_without_a_connection_there_is_no_value(block: Alone) -> None:
    """Without a connection, the block shows 16#8001 and zeros. Source: manual chapter 1, 5.2."""
    block["Robot.Connected"] = False
    block.scan(0)
    assert _shown(block) == (False, True, 0x8001, 0, 0, 0)


@pytest.mark.parametrize(("name", "error"), [("FB_RealTimeValue", 0), (_BLOCKS[1], 0x8032)])
def test_an_odd_offset_is_for_images_of_bytes_only(name: str, error: int) -> None:
    """An odd offset m is an error only for images of words. Source: manual chapter 1, 4.1."""
    alone = _compiled(name)
    alone.restart()
    alone["Robot.Connected"], alone["Block.m"] = True, 1
    alone.scan(0)
    assert alone["Block.ErrorID"] == error


def test_every_extended_word_is_shown_in_three_ways(block: Alone) -> None:
    """Each word from SOW(24), at m + 48, to SOW(127), at m + 254, is shown as WORD, INT and DINT.

    Source: manual chapter 1, 4.2, and chapter 3, 2.1: words are unsigned, double words signed;
    remote command guide 4.9.1.
    """
    for m, number in product((0, 2, 100, 256), range(24, 128)):
        block["Block.m"], block["Block.OutputWord"] = m, number
        block.scan(0)
        word, upper = _value(m + 2 * number), _value(m + 2 * number + 2)
        long = _signed(upper << 16 | word, 32) if number < 127 else 0
        assert _shown(block) == (True, False, 0, word, _signed(word, 16), long), (m, number)


@pytest.mark.parametrize("connected", [True, False])
@pytest.mark.parametrize(
    ("pins", "error"),
    [
        ({"Size": 100, "OutputWord": 2}, 0x8030),
        ({"OutputWord": 23}, 0x8034),
        ({"OutputWord": 15}, 0x8034),
        ({"OutputWord": 2}, 0x8034),
        ({"OutputWord": 1}, 0x8034),
        ({"OutputWord": 128}, 0x8034),
        ({"Size": 48}, 0x8036),
        ({"Size": 100}, 0x8030),
        ({"m": 258}, 0x8031),
        ({"m": -2}, 0x8031),
        ({"m": 4, "ImageSize": 258}, 0x8031),
    ],
)
def test_an_illegal_input_is_an_error_and_shows_zero(
    block: Alone, pins: dict[str, int], error: int, connected: bool
) -> None:
    """An illegal input gives an error and zeros, and has priority over a missing connection.

    Source: remote command guide 4.9.1; manual chapter 1, 4.2.
    """
    block.scan(0)
    assert block["Block.Valid"] is True
    block["Robot.Connected"] = connected
    for name, value in pins.items():
        block[f"Block.{name}"] = value
    block.scan(0)
    assert _shown(block) == (False, True, error, 0, 0, 0)


@pytest.mark.parametrize("name", _BLOCKS)
def test_default_inputs_select_the_first_extended_word(name: str) -> None:
    """Without arguments, the block shows SOW(24) of 256 bytes. Source: manual chapter 1, 4.2."""
    alone = _compiled(name)
    alone.restart()
    assert [alone[f"Block.{pin}"] for pin in ("m", "Size", "ImageSize", "OutputWord")] == [
        0,
        256,
        512,
        24,
    ]
