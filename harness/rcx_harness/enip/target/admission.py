"""Checks of requests to open a connection: electronic keys, number of connections, parameters.

The order of the checks is our choice. Each refusal carries general status 0x01 and an extended
status from CIP volume 1, chapter 3, 5.6.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable

from rcx_harness.enip.codec.cip import ClassId, ElectronicKey, ExtendedStatus, Refusal, Status
from rcx_harness.enip.codec.forward_open import ConnectionPath, ConnectionType, ForwardOpen
from rcx_harness.enip.cyclic.connections import RUN_IDLE_SIZE, SEQUENCE_SIZE, ConnectionKind
from rcx_harness.enip.options import CONFIGURATIONS, KINDS, RPI_MAX_US, Identity
from rcx_harness.spec.wire import TO_MASTER

__all__ = [
    "EXPLICIT_CLASS",
    "MAX_EXPLICIT_SIZE",
    "check_cyclic",
    "check_explicit",
    "check_transport",
    "has_room",
    "key_mismatch",
    "refused",
]


def key_mismatch(key: ElectronicKey | None, identity: Identity) -> ExtendedStatus | None:
    """Return the extended status for a key that does not match; None if it matches.

    A value of 0 matches every device. A compatible device may have a newer minor revision.
    """
    if key is None:
        return None
    if _differs(key.vendor, identity.vendor) or _differs(key.product_code, identity.product_code):
        return ExtendedStatus.KEY_VENDOR_OR_PRODUCT
    if _differs(key.device_type, identity.device_type):
        return ExtendedStatus.KEY_DEVICE_TYPE
    newer = key.compatible and identity.minor_revision > key.minor
    if _differs(key.major, identity.major_revision) or (
        _differs(key.minor, identity.minor_revision) and not newer
    ):
        return ExtendedStatus.KEY_REVISION
    return None


def _differs(wanted: int, have: int) -> bool:
    return wanted not in (0, have)


_KEPT_PART = 8


def has_room(taken: Iterable[str], peer: str, places: int, of_peer: int) -> bool:
    """Return whether the address `peer` may open one more connection.

    `taken` has the address of each open connection. At most `places` connections can be open, and
    at most `of_peer` from one address. The last eighth of the `places` is reserved for addresses
    that have no connection yet.
    """
    count = Counter(taken)
    own = count[peer]
    kept = places // _KEPT_PART if own else 0
    return own < of_peer and count.total() < places - kept


CYCLIC_CLASS, EXPLICIT_CLASS = 1, 3
MAX_EXPLICIT_SIZE = 4002
"""Longest message of a class 3 connection, with its sequence count."""

_CYCLIC, _LAST_TRIGGER = 0, 2
_MAX_MULTIPLIER = 7
_HEARTBEATS = (0, SEQUENCE_SIZE, SEQUENCE_SIZE + RUN_IDLE_SIZE)
# Codes for the meaning of an interval in a refusal with 0x112.
_ACCEPTABLE, _MINIMUM, _MAXIMUM, _REQUIRED = 0, 2, 3, 4


def refused(code: ExtendedStatus, *words: int) -> Refusal:
    """Return the error for a refused connection: extended status and further status words."""
    return Refusal(Status.CONNECTION_FAILURE, (code, *words))


def check_transport(request: ForwardOpen) -> None:
    """Check connection types, multiplier, transport class, direction and trigger.

    Raises:
        Refusal: with extended status 0x123, 0x124, 0x132, 0x133, 0x11C, 0x11D, 0x11E or 0x125.
    """
    kinds = request.o_to_t.kind, request.t_to_o.kind
    if kinds == (ConnectionType.NULL, ConnectionType.NULL):
        raise refused(ExtendedStatus.NULL_FORWARD_OPEN)
    if request.o_to_t.kind is not ConnectionType.POINT_TO_POINT:
        raise refused(ExtendedStatus.O_TO_T_TYPE)
    explicit = request.transport_class == EXPLICIT_CLASS
    multicast = request.t_to_o.kind is ConnectionType.MULTICAST and not explicit
    if request.t_to_o.kind is not ConnectionType.POINT_TO_POINT and not multicast:
        raise refused(ExtendedStatus.T_TO_O_TYPE)
    if request.multiplier > _MAX_MULTIPLIER:
        raise refused(ExtendedStatus.TIMEOUT_MULTIPLIER)
    if request.transport_class not in (CYCLIC_CLASS, EXPLICIT_CLASS):
        raise refused(ExtendedStatus.TRANSPORT_CLASS)
    if request.server != explicit:
        raise refused(ExtendedStatus.DIRECTION)
    if request.trigger > (_LAST_TRIGGER if explicit else _CYCLIC):
        raise refused(ExtendedStatus.PRODUCTION_TRIGGER)
    if request.o_to_t.redundant:
        raise refused(ExtendedStatus.REDUNDANT_OWNER)


def check_explicit(request: ForwardOpen, path: ConnectionPath) -> None:
    """Check an explicit connection: its path to the Message Router and its size.

    Raises:
        Refusal: with extended status 0x12F, 0x127, 0x128 or 0x112.
    """
    if path.application() != (ClassId.MESSAGE_ROUTER, (1,)):
        raise refused(ExtendedStatus.INCONSISTENT_PATHS)
    if not 0 < request.o_to_t.size <= MAX_EXPLICIT_SIZE:
        raise refused(ExtendedStatus.O_TO_T_SIZE, MAX_EXPLICIT_SIZE)
    if not 0 < request.t_to_o.size <= MAX_EXPLICIT_SIZE:
        raise refused(ExtendedStatus.T_TO_O_SIZE, MAX_EXPLICIT_SIZE)
    _check_intervals(request, 1_000, 0xFFFFFFFF)


def check_cyclic(
    request: ForwardOpen,
    path: ConnectionPath,
    size: int,
    rpi_min_us: int,
    produced_us: Collection[int] = (),
) -> ConnectionKind:
    """Check a class 1 connection: its application paths, sizes and intervals.

    `produced_us` is the packet interval of the multicast production that the connection would
    share; None without such a production.

    Returns:
        The application type (ConnectionKind) that the connection's paths select.

    Raises:
        Refusal: with extended status 0x12F, 0x129, 0x12A, 0x12B, 0x126, 0x127, 0x128, 0x112 or
            0x11B.
    """
    kind = _check_paths(path)
    expected = SEQUENCE_SIZE + RUN_IDLE_SIZE + size
    fitting = (expected,) if kind is ConnectionKind.EXCLUSIVE_OWNER else _HEARTBEATS
    if request.o_to_t.size not in fitting:
        best = expected if kind is ConnectionKind.EXCLUSIVE_OWNER else SEQUENCE_SIZE
        raise refused(ExtendedStatus.O_TO_T_SIZE, best)
    if request.t_to_o.size != SEQUENCE_SIZE + size:
        raise refused(ExtendedStatus.T_TO_O_SIZE, SEQUENCE_SIZE + size)
    _check_intervals(request, rpi_min_us, RPI_MAX_US)
    if path.inhibit_us > request.t_to_o_rpi:
        raise refused(ExtendedStatus.INHIBIT_TIME_ABOVE_RPI)
    for required in produced_us:
        if request.t_to_o_rpi != required:
            raise _interval(_ACCEPTABLE, request.o_to_t_rpi, _REQUIRED, required)
    return kind


def _check_paths(path: ConnectionPath) -> ConnectionKind:
    if path.class_id != ClassId.ASSEMBLY or not 2 <= len(path.numbers) <= 3:
        raise refused(ExtendedStatus.INCONSISTENT_PATHS)
    *configuration, consuming, producing = path.numbers
    if configuration and configuration[0] not in CONFIGURATIONS:
        raise refused(ExtendedStatus.CONFIGURATION_PATH)
    if consuming not in KINDS:
        raise refused(ExtendedStatus.CONSUMING_PATH)
    if producing != TO_MASTER:
        raise refused(ExtendedStatus.PRODUCING_PATH)
    if path.configuration:
        raise refused(ExtendedStatus.CONFIGURATION_SIZE, 0)
    return KINDS[consuming]


def _check_intervals(request: ForwardOpen, least: int, greatest: int) -> None:
    meanings = []
    for rpi in (request.o_to_t_rpi, request.t_to_o_rpi):
        meaning = _MINIMUM if rpi < least else _MAXIMUM if rpi > greatest else _ACCEPTABLE
        meanings += [meaning, {_MINIMUM: least, _MAXIMUM: greatest}.get(meaning, rpi)]
    if meanings[0] or meanings[2]:
        raise _interval(*meanings)


def _interval(o_to_t: int, o_to_t_us: int, t_to_o: int, t_to_o_us: int) -> Refusal:
    """Return refusal 0x112: two codes for the meanings of the intervals, then both intervals."""
    words = (number & 0xFFFF for us in (o_to_t_us, t_to_o_us) for number in (us, us >> 16))
    return refused(ExtendedStatus.RPI_NOT_ACCEPTABLE, o_to_t | t_to_o << 8, *words)
