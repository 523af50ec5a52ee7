"""spec/wire agrees with the manual: every number on the wire was taken from it by hand."""

from __future__ import annotations

import pytest

from rcx_harness.spec import signals, wire
from structured_text.errors import InputError


def test_an_area_has_48_bytes_and_256_with_the_word_extension() -> None:
    """Input and output have 48 bytes each, or 256 bytes with "SIOW extension" valid.

    Source: manual chapter 1, 4.1 and 4.2; chapter 5, 4
    """
    assert (wire.SIZE, wire.EXTENDED_SIZE) == (48, 256)
    assert wire.AREA_SIZES == (48, 256)


def test_the_assemblies_are_100_to_the_master_and_150_to_the_robot() -> None:
    """The master's device list shows IN_100[0] to [127] and OUT_150[0] to [127].

    Source: manual chapter 1, 4.3
    """
    assert wire.TO_MASTER == 100
    assert wire.TO_ROBOT == 150


def test_the_controller_reads_its_inputs_every_5_ms() -> None:
    """I/O update intervals are at least 5 ms, and the ON/OFF information is read every 5 ms.

    Source: manual chapter 1, 2; chapter 5, 4
    """
    assert wire.CYCLE_US == 5_000


def test_the_remote_status_has_four_words() -> None:
    """0x0000 is command ready, 0x0100 command run, 0x0200 normal end, 0x4000 abnormal end.

    Source: remote command guide chapter 1, 1.2
    """
    assert (wire.READY, wire.RUN) == (0x0000, 0x0100)
    assert (wire.NORMAL_END, wire.ABNORMAL_END) == (0x0200, 0x4000)
    assert set(wire.ENDS) == {0x0200, 0x4000}
    assert wire.STATUS_NAMES == {
        0x0000: "command ready",
        0x0100: "command run",
        0x0200: "normal end",
        0x4000: "abnormal end",
    }


def test_dedicated_bits_are_bytes_32_and_33_and_46_and_47_are_reserved() -> None:
    """Bytes 32 and 33 have dedicated bits, 34 to 45 general-purpose bits, 46 and 47 are reserved.

    Source: manual chapter 5, 4
    """
    assert (wire.DEDICATED_AT, wire.RESERVED_AT) == (32, 46)
    assert {one.byte for one in (*signals().input, *signals().output)} == {32, 33}


@pytest.mark.parametrize("size", [48, 256])
def test_both_sizes_are_taken(size: int) -> None:
    wire.check_size(size)


@pytest.mark.parametrize("size", [-48, 0, 47, 49, 64, 128, 255, 257, 512])
def test_another_size_is_refused_in_one_line_with_what_to_do(size: int) -> None:
    with pytest.raises(InputError) as refused:
        wire.check_size(size)
    text = "bytes does not exist; use 48, or 256 with SIOW extension valid"
    assert str(refused.value) == f"an area of {size} {text}"
