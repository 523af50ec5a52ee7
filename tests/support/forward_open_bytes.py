"""Forward Open and Forward Close byte by byte, for tests that change one field at a time."""

from __future__ import annotations

TRIAD = "0100 4D00 EFBEADDE"
"""The bytes of connection serial number 1, vendor 77 and originator serial number 0xDEADBEEF."""


def forward_open(
    *,
    service: str = "54",
    ids: str = "00000000 78563412",
    triad: str = TRIAD,
    multiplier: str = "02",
    o_to_t_rpi: str = "10270000",
    o_to_t: str = "3648",
    t_to_o_rpi: str = "10270000",
    t_to_o: str = "3248",
    transport: str = "01",
    path: str = "2004 2405 2C96 2C64",
    words: str = "",
) -> str:
    """Return a Forward Open request in hexadecimal digits.

    The defaults are: Exclusive Owner, 10 ms in both directions, 48 bytes, fixed size, scheduled
    priority, point to point. 0x4836 is 2 + 4 + 48 bytes, 0x4832 is 2 + 48 bytes. The T->O
    connection id is 0x12345678.
    """
    words = words or f"{len(bytes.fromhex(path)) // 2:02X}"
    return (
        f"{service} 02 2006 2401 0A0E {ids} {triad} {multiplier} 000000"
        f"{o_to_t_rpi} {o_to_t} {t_to_o_rpi} {t_to_o} {transport} {words} {path}"
    )


def forward_close(triad: str = TRIAD, path: str = "2004 2405 2C96 2C64") -> str:
    """Return a Forward Close request in hexadecimal digits."""
    return f"4E 02 2006 2401 0A0E {triad} {len(bytes.fromhex(path)) // 2:02X} 00 {path}"


def opened(
    o_to_t_id: str = "01000100",
    t_to_o_id: str = "78563412",
    triad: str = TRIAD,
    intervals: str = "10270000 10270000",
    service: str = "D4",
) -> bytes:
    """Return the success reply to a Forward Open, with the actual packet intervals."""
    return bytes.fromhex(f"{service} 00 00 00 {o_to_t_id} {t_to_o_id} {triad} {intervals} 00 00")


def refused(words: str, service: str = "D4", triad: str = TRIAD, remaining: str = "00") -> bytes:
    """Return the reply that refuses a Forward Open with this extended status."""
    count = f"{len(bytes.fromhex(words)) // 2:02X}"
    return bytes.fromhex(f"{service} 00 01 {count} {words} {triad} {remaining} 00")
