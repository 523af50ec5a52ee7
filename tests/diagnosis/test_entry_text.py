"""FB_EntryText gives the texts that describe an entry of FB_CommandRecorder."""

from __future__ import annotations

from functools import cache

import pytest

from alone import Alone


@cache
def _block() -> Alone:
    return Alone("FB_EntryText", {})


def _texts_of(kind: str, number: int, result: int, alarm: tuple[int, int] = (0, 0)) -> Alone:
    block = _block()
    block.restart()
    entry = {"Kind": kind, "Number": number, "Result": result}
    for name, value in {**entry, "Group": alarm[0], "Category": alarm[1]}.items():
        block[f"Block.Entry.{name}"] = value
    block.scan(0)
    return block


@pytest.mark.parametrize(
    ("entry", "subject", "name"),
    [
        (("LOG_NOTHING", 0, 0), "", ""),
        (("LOG_LINK", 0, 1), "Connection", ""),
        (("LOG_LINK", 0, 0), "Connection", "Not connected"),
        (("LOG_OUTPUT", 0x00, 1), "SO(00) Emergency stop status output", "Emergency stop"),
        (("LOG_OUTPUT", 0x00, 0), "SO(00) Emergency stop status output", ""),
        (("LOG_OUTPUT", 0x03, 1), "SO(03) Alarm status output", "Alarm"),
        (("LOG_OUTPUT", 0x03, 0), "SO(03) Alarm status output", ""),
        (("LOG_OUTPUT", 0x12, 1), "SO(12) Sequence program execution status output", ""),
        (("LOG_INPUT", 0x00, 1), "SI(00) Emergency stop input", ""),
        (("LOG_INPUT", 0x12, 1), "SI(12) Auto operation start", ""),
        (("LOG_COMMAND", 0x2001, 0x0200), "MovePtp", ""),
        (("LOG_COMMAND", 0x0505, 0x0100), "ReadPositionPulses", ""),
        (("LOG_COMMAND", 0x1001, 0x8014), "MovePtp", "Command lost"),
        (("LOG_ERROR", 0, 0x8042), "Block", "Illegal speed"),
    ],
)
def test_an_entry_has_a_subject_and_a_fault_has_a_text(
    entry: tuple[str, int, int], subject: str, name: str
) -> None:
    """Each entry has a text for its subject, and only a fault has a text for its error.

    Source: docs/how-to/diagnosis.md, docs/reference/errors.md; manual chapter 5, 2.
    """
    block = _texts_of(*entry)
    assert block["Block.Subject"] == subject
    assert block["Block.Text.Name"] == name
    assert block["Block.Known"] is bool(name)


def test_an_abnormal_end_has_the_text_of_its_alarm() -> None:
    """The entry of a command that ended with alarm 2.334 has the text of this alarm.

    Source: guide 1.1: 0x0002 and 0x014E are "soft limit over".
    """
    block = _texts_of("LOG_COMMAND", 0x1001, 0x4000, (2, 334))
    assert block["Block.Subject"] == "MovePtp"
    assert block["Block.Text.Name"] == "Over soft limit"
    assert block["Block.Text.Remedy1"] == "Correct the target or the soft limits."
    assert block["Block.Known"]


def test_an_alarm_that_is_not_known_has_no_text() -> None:
    block = _texts_of("LOG_COMMAND", 0x1001, 0x4000, (17, 1))
    assert block["Block.Text.Name"] == ""
    assert not block["Block.Known"]


@pytest.mark.parametrize(
    ("entry", "alarm", "name"),
    [
        (("LOG_COMMAND", 0x1001, 0x4000), (12, 600), "非常停止中"),
        (("LOG_LINK", 0, 0), (0, 0), "未接続"),
    ],
)
def test_texts_are_in_the_language_that_is_asked_for(
    entry: tuple[str, int, int], alarm: tuple[int, int], name: str
) -> None:
    block = _texts_of(*entry, alarm)
    block["Block.Language"] = "LANGUAGE_JAPANESE"
    block.scan(10)
    assert str(block["Block.Text.Name"]).encode("latin-1").decode("utf-8") == name


def test_nothing_is_left_of_the_entry_before() -> None:
    block = _texts_of("LOG_LINK", 0, 0)
    block["Block.Entry.Kind"] = "LOG_NOTHING"
    block.scan(10)
    assert (block["Block.Subject"], block["Block.Text.Name"]) == ("", "")
