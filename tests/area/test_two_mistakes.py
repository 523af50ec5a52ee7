"""Blocks of ports and bits where more than one input is illegal."""

from __future__ import annotations

import pytest

from alone import Alone


@pytest.mark.parametrize("twin", ["", "InWords"])
@pytest.mark.parametrize("kind", ["Bit", "Port"])
@pytest.mark.parametrize("verb", ["Read", "Write"])
def test_an_illegal_area_is_told_before_an_illegal_port(verb: str, kind: str, twin: str) -> None:
    """As the blocks of words do. Source: docs/reference/errors.md, 16#8030 and 16#8033."""
    robot = {"Robot": "RCX_REF"} if verb == "Read" else {}
    image = {"Image": f"RCX_IMAGE{'_WORDS' if twin else ''}"}
    block = Alone(f"FB_{verb}{kind}{twin}", {**robot, **image})
    block["Block.Size"], block["Block.Port"] = 100, 99
    block.scan(0)
    assert block["Block.ErrorID"] == 0x8030
