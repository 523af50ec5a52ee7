from __future__ import annotations

from rcx_harness.enip.codec import cip
from rcx_harness.enip.codec.cip import ExtendedStatus


def test_every_extended_status_has_a_text() -> None:
    texts = [cip.extended_text(code) for code in ExtendedStatus]
    assert len(set(texts)) == len(ExtendedStatus)
    assert cip.extended_text(0x106) == "another master owns the outputs"


def test_an_unknown_extended_status_has_a_text() -> None:
    assert "does not know" in cip.extended_text(0xFFFF)


def test_a_reply_is_decoded_with_its_extended_status() -> None:
    """The extended status 0x127 is decoded together with the size that the device accepts."""
    reply = cip.decode_reply(bytes.fromhex("D400 0102 2701 3600 0100 4D00 EFBEADDE 00 00"))
    assert reply == cip.Reply(0x54, 0x01, bytes.fromhex("0100 4D00 EFBEADDE 00 00"), (0x127, 0x36))
    assert cip.decode_reply(bytes.fromhex("D400 0102 2701")) is None
