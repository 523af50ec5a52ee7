from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.enip import AdapterOptions
from structured_text.errors import InputError


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"rpi_min_us": 999}, "packet intervals of 0.999 ms"),
        ({"rpi_min_us": 5_000, "rpi_max_us": 4_000}, "packet intervals of 5 ms to 4 ms"),
        ({"rpi_max_us": 1 << 32}, "packet intervals"),
        ({"input_only": 4}, "must be others"),
        ({"input_only": 150}, "must be others"),
        ({"listen_only": 100}, "must be others"),
        ({"listen_only": 0}, "1 to 65535"),
        ({"configurations": (1, 65536)}, "1 to 65535"),
        ({"inactivity_s": -1}, "0 to 3600"),
        ({"inactivity_s": 3601}, "0 to 3600"),
        ({"first_packet_us": 9_999_999}, "cannot be waited for .*; it can be 10s to 610h"),
    ],
)
def test_invalid_options_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        AdapterOptions(**wrong)


def test_the_limits_are_accepted() -> None:
    AdapterOptions(1_000, 0xFFFFFFFF, 1, 65535, (1, 65535), True, 3600)
    AdapterOptions(5_000, 5_000, configurations=(), inactivity_s=0)
