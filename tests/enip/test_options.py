from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.enip.options import AdapterOptions
from structured_text.errors import InputError


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rpi_min_us": 999}, "packet intervals of 0.999 ms"),
        ({"rpi_min_us": 3_200_001}, "packet intervals"),
        ({"first_packet_us": 9_999_999}, "cannot be .*; use 10s to 610h"),
    ],
)
def test_invalid_options_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        AdapterOptions(**wrong)


def test_the_limits_are_accepted() -> None:
    AdapterOptions(1_000, 10_000_000)
    AdapterOptions(3_200_000, 0xFFFFFFFF * 512)
