"""Changes are packed as bytes. The expected bytes follow the head of pack.py."""

from __future__ import annotations

import struct

import pytest

from rcx_harness.trace.view.pack import Bits, Numbers, Packed, Reals, Texts, put_whole


@pytest.mark.parametrize(
    ("number", "data"),
    [
        (0, b"\x00"),
        (127, b"\x7f"),
        (128, b"\x80\x01"),
        (10_000, b"\x90\x4e"),
        (2**53, b"\x80\x80\x80\x80\x80\x80\x80\x10"),
    ],
)
def test_a_whole_number_has_seven_bits_in_a_byte(number: int, data: bytes) -> None:
    found = bytearray()
    put_whole(found, number)
    assert bytes(found) == data


@pytest.mark.parametrize(
    ("packed", "values", "data"),
    [
        (Bits(), (1, 0, 1), b"\x05\x05"),
        (Texts(), (3, 0, 200), b"\x05\x00\x05\xc8\x01"),
        (Numbers(), (10, 9, 11), b"\x05\x01\x05\x04"),
        (Reals(), (0.5, -1.0), b"\x05" + struct.pack("<d", -1.0)),
    ],
)
def test_a_change_is_the_time_since_the_one_before_and_its_value(
    packed: Packed, values: tuple[float, ...], data: bytes
) -> None:
    noted = [packed.note(100 + 5 * k - 100, value) for k, value in enumerate(values)]
    assert (packed.first, noted) == (values[0], [False, *[True] * (len(values) - 1)])
    assert (bytes(packed.data), packed.count) == (data, len(values) - 1)


def test_the_same_value_again_is_no_change_but_one_that_is_added() -> None:
    packed = Reals()
    nan = float("nan")
    assert [packed.note(t_us, nan) for t_us in (0, 5)] == [False, False]
    texts = Texts()
    texts.add(7, 1)
    texts.add(7, 1)
    assert bytes(texts.data) == b"\x07\x01\x00\x01"


def test_time_never_goes_back() -> None:
    packed = Bits()
    for t_us, value in ((0, 0), (10, 1), (4, 0), (12, 1)):
        packed.note(t_us, value)
    assert bytes(packed.data) == b"\x0a\x00\x02"
