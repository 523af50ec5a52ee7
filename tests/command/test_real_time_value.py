"""FB_RealTimeValue: what the real time output shows in the extended words."""

from __future__ import annotations

import pytest

from areas_bench import AreasBench


def _up(size: int = 256, m: int = 0) -> AreasBench:
    plc = AreasBench(size=size, m=m)
    plc.power_up()
    plc["RealTimeValue.m"] = m
    plc["RealTimeValue.Size"] = size
    return plc


def _values(plc: AreasBench, word: int) -> tuple[object, object, object]:
    plc.change("RealTimeValue.OutputWord", to=word)
    assert plc["RealTimeValue.Valid"]
    return tuple(plc[f"RealTimeValue.{pin}"] for pin in ("Unsigned", "Signed", "Long"))


@pytest.mark.parametrize("m", [0, 100])
@pytest.mark.parametrize("word", [24, 25, 126])
def test_word_k_stands_at_m_plus_2k(m: int, word: int) -> None:
    """SOW(24) is at m+48, SOW(127) at m+254. Source: manual chapter 1, 4.2."""
    plc = _up(m=m)
    plc.so[2 * word : 2 * word + 4] = bytes([0x39, 0x30, 0x01, 0x00])
    assert _values(plc, word) == (0x3039, 0x3039, 0x00013039)


def test_the_highest_bit_is_a_sign_or_not_as_the_item_says() -> None:
    """Source: manual chapter 3, 2.1: words are unsigned, double words signed."""
    plc = _up()
    plc.so[48:52] = bytes([0x9C, 0xFF, 0xFF, 0xFF])
    assert _values(plc, 24) == (65436, -100, -100)


def test_the_last_word_has_no_upper_half() -> None:
    plc = _up()
    plc.so[254:256] = bytes([0x05, 0x00])
    assert _values(plc, 127) == (5, 5, 0)


@pytest.mark.parametrize(
    ("pins", "error"),
    [
        ({"OutputWord": 23}, 0x8034),
        ({"OutputWord": 2}, 0x8034),
        ({"OutputWord": 128}, 0x8034),
        ({"Size": 48}, 0x8036),
        ({"Size": 100}, 0x8030),
        ({"m": 300}, 0x8031),
    ],
)
def test_what_is_not_there_is_an_error_and_shows_zero(pins: dict[str, int], error: int) -> None:
    """Source: remote command guide 4.9.1: numbers 24 to 127 of the extended area."""
    plc = _up()
    plc.so[48:256] = bytes([0xFF] * 208)
    for name, value in pins.items():
        plc[f"RealTimeValue.{name}"] = value
    plc.scan()
    assert plc["RealTimeValue.ErrorID"] == error
    assert not plc["RealTimeValue.Valid"]
    shown = [plc[f"RealTimeValue.{pin}"] for pin in ("Unsigned", "Signed", "Long")]
    assert shown == [0, 0, 0]


def test_without_a_connection_there_is_no_value() -> None:
    plc = _up()
    plc.change("Connected", to=False)
    assert plc["RealTimeValue.ErrorID"] == 0x8001


def test_an_illegal_word_is_told_before_a_missing_connection() -> None:
    """It does not go away with the connection's return."""
    plc = _up()
    plc["Connected"] = False
    plc.change("RealTimeValue.OutputWord", to=128)
    assert plc["RealTimeValue.ErrorID"] == 0x8034
