"""FB_Operator shows messages in words that an operator knows.

The test plays the robot.
"""

from __future__ import annotations

import re

import pytest

from alone import Alone
from operator_bench import OperatorBench
from plc_bench import ROOT
from structured_text.output.toml_files import load_toml

_ROWS = load_toml(ROOT / "spec/errors.toml")["error"]
_LANGUAGES = {"LANGUAGE_ENGLISH": "", "LANGUAGE_JAPANESE": "_ja"}
#: ErrorIDs that a panel shows often: of FB_RcxPanelReasons and of the keys.
_FREQUENT_ERRORS = {
    0x8001,
    0x8002,
    0x8003,
    0x8004,
    0x8005,
    0x8006,
    0x8007,
    0x800C,
    0x8010,
    0x8020,
    0x807B,
}


def _lines(block: Alone, key: str) -> str:
    lines = [str(block[f"Block.Text.{key}{number}"]) for number in (1, 2)]
    joined = "".join(lines).encode("latin-1").decode("utf-8")
    return joined.replace(" ", "")


@pytest.mark.parametrize("language", _LANGUAGES)
def test_each_message_has_its_text_for_operators(language: str) -> None:
    """Each ErrorID of a panel has its message. A short message leaves no old text behind.

    Source: spec/errors.toml.
    """
    block = Alone("FB_RcxPanelMessage", {})
    block["Block.Language"] = language
    for row in (*_ROWS, *reversed(_ROWS)):
        block["Block.Hint"] = row["id"]
        block.scan(0)
        for key in ("cause", "remedy"):
            ours = row.get(
                f"panel_{key}{_LANGUAGES[language]}", row[f"{key}{_LANGUAGES[language]}"]
            )
            assert _lines(block, key.capitalize()) == ours.replace(" ", ""), hex(row["id"])


def test_texts_for_operators_name_no_block_pin_or_bit() -> None:
    """Source: an operator has keys, lamps, the cell and the programming box."""
    rows = [row for row in _ROWS if "panel_remedy" in row]
    assert {row["id"] for row in rows} == _FREQUENT_ERRORS
    for row in rows:
        for key in ("panel_cause", "panel_remedy", "panel_cause_ja", "panel_remedy_ja"):
            found = re.findall(r"FB_\w+|S[IO]\(\d+\)|[A-Z][a-z]+[A-Z]\w*|TRUE|FALSE", row[key])
            assert not found, (row[key], found)


def test_after_a_stop_of_the_panel_the_message_names_the_key_that_releases_it() -> None:
    """Source: RCX_PANEL.Following."""
    plc = OperatorBench()
    plc.press("Stop", then=30)
    assert (plc.message, plc["Panel.Following"]) == (0x8007, "PANEL_NEXT_RESET")
    assert "press Reset" in f"{plc['Panel.Message.Remedy1']} {plc['Panel.Message.Remedy2']}"


@pytest.mark.parametrize("automatic", [False, True])
def test_an_incomplete_origin_is_reported_and_start_is_not_suggested(
    automatic: bool,
) -> None:
    """If the return-to-origin is incomplete, the message says so, and Start stays possible.

    The program itself may return the robot to its origin.

    Source: manual chapter 5, 2, SO(11).
    """
    plc = OperatorBench(Automatic=automatic)
    plc.outputs(SO11=False, scans=2)
    assert (plc.message, plc["Panel.Lamp.Fault"]) == (0x807B, False)
    assert plc["Panel.Following"] == "PANEL_NEXT_NONE"
    assert plc.can("Start" if automatic else "JogPlus") == [True]
    plc.outputs(SO13=True, scans=2)
    assert plc.message == 0, "a program runs"
    plc.outputs(SO13=False, SO11=True, scans=2)
    assert plc.message == 0
    plc.outputs(SO02=False, SO11=False, scans=2)
    assert (plc.message, plc["Panel.Following"]) == (0x800C, "PANEL_NEXT_SERVO_ON")


def test_without_the_origin_no_hint_hides_that_a_key_is_at_work() -> None:
    """Source: RCX_PANEL.Message."""
    plc = OperatorBench()
    plc.outputs(SO11=False)
    plc.hold = 0x0028
    plc.press("Teach", then=3)
    assert (plc.message, plc["Operator.Busy"]) == (0, True)
