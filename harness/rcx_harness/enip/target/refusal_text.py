"""A text about a refused connection: the requester, the reason, and the setting to change.

The engineering tool of a PLC often shows only the code of a refusal. The controller has both the
request and its own properties, so its text can name the remedy.
"""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.enip.codec.cip import ExtendedStatus, Refusal, Status, extended_text, status_text
from rcx_harness.enip.codec.forward_open import ForwardOpen, decode_connection_path
from rcx_harness.enip.cyclic.connections import RUN_IDLE_SIZE, SEQUENCE_SIZE, ConnectionKind
from rcx_harness.enip.options import CONFIGURATIONS, KINDS, RPI_MAX_US, Identity
from rcx_harness.enip.target.admission import EXPLICIT_CLASS
from rcx_harness.spec.wire import AREA_SIZES, TO_MASTER, TO_ROBOT
from structured_text.output.units import format_us

__all__ = ["Facts", "refusal_text"]

_POINTS = {kind: point for point, kind in KINDS.items()}
_READING = ", ".join(f"{point} {kind.value}" for point, kind in KINDS.items() if point != TO_ROBOT)
_NAMES = {
    ConnectionKind.EXCLUSIVE_OWNER: "an exclusive owner connection",
    ConnectionKind.INPUT_ONLY: "an input only connection",
    ConnectionKind.LISTEN_ONLY: "a listen only connection",
}
_HEADER = "the 32-bit run/idle header"
_TRIES = 8  # largest number of connection points in the text


@dataclass(frozen=True)
class Facts:
    """The properties of the controller that the text compares with a request.

    Attributes:
        identity: Compared with electronic keys.
        owner: IPv4 address of the exclusive owner; empty without one.
        cyclic: Whether there is cyclic I/O.
    """

    size: int
    identity: Identity
    rpi_min_us: int
    owner: str
    cyclic: bool


def refusal_text(peer: str, request: ForwardOpen | None, refusal: Refusal, facts: Facts) -> str:
    """Return one sentence: the requester, the request, the code, its meaning, and a remedy.

    `request` is None if it could not be read; `facts` are the properties of the controller.
    """
    if refusal.status != Status.CONNECTION_FAILURE or not refusal.extended:
        code, meaning = f"0x{refusal.status:02X}", status_text(refusal.status)
    else:
        code, meaning = f"0x{refusal.extended[0]:04X}", extended_text(refusal.extended[0])
    asked = "a connection" if request is None else _asked(request)
    remedy = "" if request is None else _remedy(request, refusal, facts)
    text = f"{peer} asked for {asked}: refused with {code}, {meaning}"
    return f"{text}; {remedy}" if remedy else text


def _asked(request: ForwardOpen) -> str:
    if request.transport_class == EXPLICIT_CLASS:
        return "a connection for explicit messages (class 3)"
    numbers = _numbers(request)
    kind = KINDS.get(numbers[-2]) if len(numbers) > 1 else None
    what = "a connection" if kind is None else _NAMES[kind]
    sizes = f"{request.o_to_t.size} bytes to the controller, {request.t_to_o.size} from it"
    every = format_us(request.o_to_t_rpi)
    if request.t_to_o_rpi != request.o_to_t_rpi:
        every += f" and {format_us(request.t_to_o_rpi)}"
    return f"{what} ({sizes}, every {every})"


def _numbers(request: ForwardOpen) -> tuple[int, ...]:
    try:
        return decode_connection_path(request.path).numbers
    except Refusal:
        return ()


def _remedy(request: ForwardOpen, refusal: Refusal, facts: Facts) -> str:
    if refusal.status != Status.CONNECTION_FAILURE or not refusal.extended:
        return ""
    code = refusal.extended[0]
    if code == ExtendedStatus.O_TO_T_SIZE and request.transport_class != EXPLICIT_CLASS:
        return _to_controller(request, facts)
    if code == ExtendedStatus.T_TO_O_SIZE and request.transport_class != EXPLICIT_CLASS:
        return _from_controller(request, facts)
    if code == ExtendedStatus.OWNERSHIP_CONFLICT:
        return (
            f"{facts.owner} is its master: disconnect it or wait for its time-out, "
            f"or only read, by connection point {_POINTS[ConnectionKind.INPUT_ONLY]} (input only)"
        )
    if code in (ExtendedStatus.RPI_NOT_SUPPORTED, ExtendedStatus.RPI_NOT_ACCEPTABLE):
        return _interval(request, refusal, facts.rpi_min_us)
    if code in _KEYS:
        own = facts.identity
        return (
            "switch off the check of the electronic key in the PLC, or use its identity: "
            f"vendor {own.vendor}, device type {own.device_type}, product code "
            f"{own.product_code} (--product-code), revision {own.major_revision}."
            f"{own.minor_revision} (--revision)"
        )
    if code == ExtendedStatus.CONFIGURATION_PATH:
        allowed = ", ".join(map(str, CONFIGURATIONS))
        return f"set its configuration instance to none or one of {allowed}, with size 0"
    if code in (ExtendedStatus.CONSUMING_PATH, ExtendedStatus.PRODUCING_PATH, *_PATHS):
        named = ", ".join(map(str, _numbers(request)[:_TRIES])) or "no assembly"
        return (
            f"it named {named}; the output is assembly {TO_ROBOT} (only to read: {_READING}"
            f"), the input assembly {TO_MASTER}"
        )
    if code == ExtendedStatus.OUT_OF_CONNECTIONS and not facts.cyclic:
        return "this adapter has no cyclic I/O"
    return _OTHERS.get(code, "")


_KEYS = (
    ExtendedStatus.KEY_VENDOR_OR_PRODUCT,
    ExtendedStatus.KEY_DEVICE_TYPE,
    ExtendedStatus.KEY_REVISION,
)
_PATHS = (ExtendedStatus.INCONSISTENT_PATHS, ExtendedStatus.SEGMENT_IN_PATH)
_CLASS_1 = "set transport class 1, cyclic, at the client's side"
_OTHERS: dict[int, str] = {
    ExtendedStatus.DUPLICATE_FORWARD_OPEN: "close it first, or wait for its time-out",
    ExtendedStatus.CONFIGURATION_SIZE: "set the size of the configuration to 0",
    ExtendedStatus.ONLY_LISTENERS: "connect a master or an input only connection first",
    ExtendedStatus.TRANSPORT_CLASS: _CLASS_1,
    ExtendedStatus.PRODUCTION_TRIGGER: _CLASS_1,
    ExtendedStatus.DIRECTION: _CLASS_1,
    ExtendedStatus.O_TO_T_TYPE: "set point to point for the output",
    ExtendedStatus.T_TO_O_TYPE: "set point to point or multicast for the input",
    ExtendedStatus.REDUNDANT_OWNER: "set an exclusive owner that is not redundant",
    ExtendedStatus.TIMEOUT_MULTIPLIER: "set 4 to 512 intervals",
    ExtendedStatus.INHIBIT_TIME_ABOVE_RPI: "set a shorter production inhibit time",
    ExtendedStatus.OUT_OF_CONNECTIONS: "close connections that are not needed",
}


def _to_controller(request: ForwardOpen, facts: Facts) -> str:
    size, asked = facts.size, request.o_to_t.size
    numbers = _numbers(request)
    if len(numbers) > 1 and numbers[-2] != TO_ROBOT:
        return "a connection that only reads sends no data: set size 0 for its output"
    right = SEQUENCE_SIZE + RUN_IDLE_SIZE + size
    if asked == SEQUENCE_SIZE + size:
        return f"the output needs {_HEADER} before its {size} bytes: choose it in the PLC"
    return f"this controller has {size} bytes, {right} with {_HEADER} and the count: " + _set_size(
        asked - SEQUENCE_SIZE, size, "with that header"
    )


def _from_controller(request: ForwardOpen, facts: Facts) -> str:
    size, asked = facts.size, request.t_to_o.size
    if asked == SEQUENCE_SIZE + RUN_IDLE_SIZE + size:
        return f"the input has no header before its {size} bytes: choose pure data in the PLC"
    return f"this controller has {size} bytes, {SEQUENCE_SIZE + size} with the count: " + _set_size(
        asked - SEQUENCE_SIZE, size, "without a header"
    )


def _set_size(asked: int, size: int, header: str) -> str:
    """Return the setting to change in the PLC; name --size if the other size was requested."""
    text = f"set {size} bytes {header} in the PLC"
    for other in AREA_SIZES:
        if other != size and asked in (other, other + RUN_IDLE_SIZE):
            return f"{text}, or start the controller with --size {other}"
    return text


def _interval(request: ForwardOpen, refusal: Refusal, least: int) -> str:
    asked = (request.o_to_t_rpi, request.t_to_o_rpi)
    if request.transport_class == EXPLICIT_CLASS:
        return "set at least 1 ms"
    if all(least <= one <= RPI_MAX_US for one in asked) and len(refusal.extended) >= 6:
        shared = refusal.extended[4] | refusal.extended[5] << 16
        return f"its multicast input is sent every {format_us(shared)}: set that, or point to point"
    text = f"set {format_us(least)} to {format_us(RPI_MAX_US)} in the PLC"
    return (
        f"{text}, or start the controller with a smaller --rpi-min" if min(asked) < least else text
    )
