"""Blocks read words 2 to 15 from the data of FB_ReadArea, not from the newer image.

The last test concerns FB_RcxMakeHead: a hold that is released and requested in one scan stays.
"""

from __future__ import annotations

from functools import cache

import pytest

from alone import Alone


@cache
def _reader(block: str) -> Alone:
    image = "RCX_IMAGE_WORDS" if block.endswith("InWords") else "RCX_IMAGE"
    return Alone(block, {"Robot": "RCX_REF", "Image": image})


@pytest.mark.parametrize(
    ("block", "values"),
    [
        ("FB_ReadWord", (0x1234, 0x0201)),
        ("FB_ReadWordInWords", (0x1234, 0x0201)),
        ("FB_ReadDoubleWord", (0x5678_1234, 0x0403_0201)),
        ("FB_ReadDoubleWordInWords", (0x5678_1234, 0x0403_0201)),
    ],
)
@pytest.mark.parametrize("number", [2, 15, 24, 127])
def test_a_shared_word_is_the_one_that_was_read_with_the_status(
    block: str, values: tuple[int, int], number: int
) -> None:
    """Words 2 to 15 come from the data that were read with the status; other words from the image.

    The image may be newer than the status. Only the status shows the command of a word.

    Source: manual chapter 1, 4.1 and 4.2: words 2 to 15 are the responses of remote commands.
    """
    if "Double" in block:
        number -= number % 2
    alone = _reader(block)
    alone.restart()
    alone["Robot.Connected"], alone["Robot.Inner.Phase"] = True, "PHASE_READY"
    for k, word in enumerate((0x1234, 0x5678), start=number):
        if k <= 15:
            alone[f"Robot.Response[{k}]"] = word
    alone["Block.Size"], alone["Block.Number"] = 256, number
    if block.endswith("InWords"):
        alone["Image"] = [0] * number + [0x0201, 0x0403] + [0] * (254 - number)
    else:
        alone["Image"] = [0] * 2 * number + [1, 2, 3, 4] + [0] * (508 - 2 * number)
    alone.scan(0)
    assert alone["Block.Value"] == values[number > 15]
    assert alone["Block.Valid"] is True
    alone["Robot.Status"] = 0x0100
    alone.scan(10)
    assert alone["Block.Value"] == (values[1] if number > 15 else 0)
    assert alone["Block.Valid"] is (number > 15)


@pytest.mark.parametrize("twin", ["", "Words"])
@pytest.mark.parametrize(("interval", "margin", "spacing"), [(250, 30, 280), (100, 260, 360)])
def test_interval_and_margin_are_those_of_the_pins(
    twin: str, interval: int, margin: int, spacing: int
) -> None:
    """Interval and margin are those of the pins of FB_WriteArea.

    SI(00) turns ON interval plus margin after the start of the PLC, and SI(06) the same time after
    SI(00).

    Source: manual chapter 5, 3.1, caution.
    """
    area = Alone(
        f"FB_WriteArea{twin}", {"Robot": "RCX_REF", "Image": f"RCX_IMAGE{twin and '_WORDS'}"}
    )
    area["Robot.Connected"] = True
    area["Block.EmergencyStopOk"] = area["Block.StopOk"] = True
    area["Block.Interval"], area["Block.Margin"] = f"T#{interval}ms", f"T#{margin}ms"
    found = []
    for now in range(0, 1000, 10):
        area.scan(now)
        on = (area["Robot.SI.SI00_EmergencyStop"], area["Robot.SI.SI06_Stop"])
        found.append(on)
    assert [found.index((True, False)) * 10, found.index((True, True)) * 10] == [
        spacing,
        2 * spacing,
    ]


@pytest.mark.parametrize(("name", "bit"), [("Emergency", 0x0001), ("Stop", 0x0040)])
def test_a_hold_that_is_requested_and_released_in_one_scan_stays(name: str, bit: int) -> None:
    """Source: manual chapter 5, 2, SI(00) and SI(06): OFF stops."""
    head = Alone("FB_RcxMakeHead", {"Robot": "RCX_REF"})
    head["Robot.Connected"] = True
    head["Block.EmergencyStopOk"] = head["Block.StopOk"] = True
    for now in range(0, 1000, 20):
        head.scan(now)
    assert head["Robot.Inner.Applied"] == 0x0041
    head[f"Robot.Inner.Keep{name}"] = True
    for now in range(1000, 2000, 20):
        head.scan(now)
        assert head["Robot.Inner.Applied"] == 0x0041 & ~bit
        assert head[f"Robot.Inner.Hold{name}"] is True
        assert head[f"Robot.Inner.Keep{name}"] is False
    head[f"Robot.Inner.Hold{name}"] = False
    head.scan(2000)
    assert head["Robot.Inner.Applied"] == 0x0041
