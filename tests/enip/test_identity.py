from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.enip.options import Identity
from structured_text.errors import InputError


def test_the_device_type_is_the_manuals() -> None:
    """The device type in the manual is 43, generic device.

    Source: manual chapter 5, 4
    """
    assert Identity().device_type == 43


@pytest.mark.parametrize(
    "wrong",
    [
        *({"vendor": 0x10000}, {"device_type": -1}, {"product_code": 0x10000}),
        *({"major_revision": 128}, {"minor_revision": 256}, {"serial_number": 0x1_0000_0000}),
        *({"product_name": "x" * 33}, {"product_name": "naïve"}),
    ],
)
def test_a_value_beyond_its_attribute_is_refused_by_name(wrong: dict[str, Any]) -> None:
    (name,) = wrong
    with pytest.raises(InputError, match=name):
        Identity(**wrong)


def test_the_greatest_values_are_accepted() -> None:
    Identity(0xFFFF, 0xFFFF, 0xFFFF, 127, 255, 0xFFFFFFFF, "x" * 32)
