"""OSR and OSF: the output bit is set for one scan. Source: Rockwell 1756-RM003, OSR and OSF."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.projects.rockwell.ladder.call import Call, Entry

__all__ = ["ONE_SHOTS"]


def _osr(call: Call) -> None:
    storage, output = call.bit(0, written=True), call.bit(1, written=True)
    call.always(
        lambda power: [
            f"{output} := {_operand(power)} AND NOT {storage};",
            f"{storage} := {power};",
        ],
        named=True,
    )


def _osf(call: Call) -> None:
    storage, output = call.bit(0, written=True), call.bit(1, written=True)
    call.always(
        lambda power: [
            f"{output} := {storage} AND NOT {_operand(power)};",
            f"{storage} := {power};",
        ],
        named=True,
    )


def _operand(power: str) -> str:
    return f"({power})" if " " in power else power


def _osr_prescan(call: Call) -> Iterator[str]:
    yield f"{call.bit(0, written=True)} := TRUE;"
    yield f"{call.bit(1, written=True)} := FALSE;"


def _osf_prescan(call: Call) -> Iterator[str]:
    yield f"{call.bit(0, written=True)} := FALSE;"
    yield f"{call.bit(1, written=True)} := FALSE;"


_BITS = ("Storage Bit", "Output Bit")
ONE_SHOTS = (
    Entry("OSR", _BITS, _osr, "1756-RM003, OSR", 0, _osr_prescan),
    Entry("OSF", _BITS, _osf, "1756-RM003, OSF", 0, _osf_prescan),
)
