"""Bit instructions. Source: Rockwell 1756-RM003, bit instructions."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.power import FALSE, TRUE

__all__ = ["BITS"]


def _xic(call: Call) -> None:
    call.condition(call.bit(0))


def _xio(call: Call) -> None:
    call.condition_not(call.bit(0))


def _ote(call: Call) -> None:
    assigned = call.set_bit(0)
    call.always(lambda power: [assigned(power)])


def _otl(call: Call) -> None:
    call.when(call.set_bit(0)(TRUE))


def _otu(call: Call) -> None:
    call.when(call.set_bit(0)(FALSE))


def _ons(call: Call) -> None:
    """Pass power in the scan in which it comes; the storage bit has the power of the last scan."""
    bit, before = call.bit(0, written=True), call.power
    call.condition_not(bit)
    behind, call.power = call.power, before
    call.always(lambda power: [f"{bit} := {power};"])
    call.power = behind


def _cleared(call: Call) -> Iterator[str]:
    yield call.set_bit(0)(FALSE)


def _set(call: Call) -> Iterator[str]:
    yield f"{call.bit(0, written=True)} := TRUE;"


BITS = (
    Entry("XIC", ("Data Bit",), _xic, "1756-RM003, XIC"),
    Entry("XIO", ("Data Bit",), _xio, "1756-RM003, XIO"),
    Entry("OTE", ("Data Bit",), _ote, "1756-RM003, OTE", 0, _cleared),
    Entry("OTL", ("Data Bit",), _otl, "1756-RM003, OTL"),
    Entry("OTU", ("Data Bit",), _otu, "1756-RM003, OTU"),
    Entry("ONS", ("Storage Bit",), _ons, "1756-RM003N, page 103", 0, _set),
)
