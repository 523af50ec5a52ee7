"""Checks of options that several commands have; each names the option as it was typed."""

from __future__ import annotations

import ipaddress

from rcx_harness.errors import InputError
from rcx_harness.units import parse_us

__all__ = ["check_ipv4", "check_port", "duration_us", "interval_us"]

#: Packet intervals in microseconds: the range of the vendor's earlier adapter.
_SHORTEST_US, _LONGEST_US = 1_000, 3_200_000


def check_port(option: str, number: int) -> None:
    """Refuse what is no TCP or UDP port (InputError)."""
    if not 1 <= number <= 0xFFFF:
        raise InputError(f"{option} {number} is no port", hint="ports are 1 to 65535")


def check_ipv4(option: str, text: str) -> None:
    """Refuse what is no IPv4 address (InputError)."""
    try:
        ipaddress.IPv4Address(text)
    except ValueError:
        hint = "write it as 192.168.0.10"
        raise InputError(f"{option} {text!r} is no IPv4 address", hint=hint) from None


def duration_us(option: str, text: str) -> int:
    """A duration in microseconds; what is none is refused (InputError)."""
    try:
        return parse_us(text)
    except InputError as error:
        raise InputError(f"{option}: {error.message}", hint=error.hint) from None


def interval_us(option: str, text: str) -> int:
    """A packet interval in microseconds.

    Raises:
        InputError: not a duration, or none that a controller can have.
    """
    given_us = duration_us(option, text)
    if not _SHORTEST_US <= given_us <= _LONGEST_US:
        raise InputError(f"{option} {text} is no packet interval", hint="it can be 1ms to 3200ms")
    return given_us
