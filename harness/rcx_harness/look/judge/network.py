"""The class 1 connections in a capture, from the Forward Open to their end."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

from rcx_harness.enip.codec.cip import (
    ClassId,
    ConnectionService,
    Refusal,
    Reply,
    Request,
    decode_reply,
    decode_request,
    extended_text,
    status_text,
)
from rcx_harness.enip.codec.encapsulation import Command, unconnected_items
from rcx_harness.enip.codec.forward_open import (
    ConnectionType,
    ForwardOpen,
    decode_connection_path,
    decode_forward_open,
    decode_open_reply,
)
from rcx_harness.enip.cyclic.connections import RUN_IDLE_SIZE, SEQUENCE_SIZE, ConnectionKind
from rcx_harness.enip.cyclic.exchange import decode_packet
from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.judge.capture import Packet, host_text
from rcx_harness.look.judge.streams import Streams
from rcx_harness.look.judge.ways import Arrival, Way
from rcx_harness.spec.wire import AREA_SIZES, TO_MASTER, TO_ROBOT
from structured_text.output.units import format_us

__all__ = ["Connection", "Network", "Note", "Robot", "Sample", "Stranger"]

_CYCLIC = b"\x02\x00\x02\x80\x08\x00"  # item headers at the beginning of each class 1 packet
_MULTICAST = range(224, 240)
_MOST_PENDING, _MOST_STRANGERS, _MOST_CONNECTIONS, _MOST_LINES = 256, 256, 1_000, 4_000
_OPEN = (ConnectionService.FORWARD_OPEN, ConnectionService.LARGE_FORWARD_OPEN)
#: Maps a size on the wire to the number of data bytes, and to whether there is a run/idle header.
_TO_ROBOT = {
    size + SEQUENCE_SIZE + header: (size, header > 0)
    for size in AREA_SIZES
    for header in (0, RUN_IDLE_SIZE)
}


class Sample(NamedTuple):
    """The areas of a controller and its PLC from one point in time on.

    Attributes:
        t_us: Time of the capture.
        number: Number of the packet in the file, or of the scan or cycle in a trace.
        controller: Number of the controller, from 1.
        so: The area to the PLC; empty before the first packet.
        si: The area to the controller; empty if nothing is sent to it.
        connected: Whether the PLC is connected and its program runs.
        whole: True if no packet is missing directly before this packet.
        at_once: Whether both areas belong to the same cycle of the controller. The sender of `si`
            had then not read `so`.
    """

    t_us: int
    number: int
    controller: int
    so: bytes
    si: bytes
    connected: bool
    whole: bool = True
    at_once: bool = False


class Note(NamedTuple):
    """An event of the connection of a controller."""

    t_us: int
    controller: int
    text: str


@dataclass
class Connection:
    """One class 1 connection to a controller.

    Intervals are the agreed intervals [us]; 0 if the capture has no Forward Open. `end` says how
    the connection ended. It is empty while the connection is open.
    """

    peer: bytes
    kind: ConnectionKind
    begin_us: int
    to_robot: Way
    to_master: Way
    to_robot_us: int = 0
    to_master_us: int = 0
    opened: bool = True
    end: str = ""
    end_us: int = 0


@dataclass
class Robot:
    """A controller in the capture: its areas, and its connections."""

    number: int
    host: bytes
    size: int
    connections: list[Connection] = field(default_factory=list)
    so: bytes = b""
    si: bytes = b""
    owner: Connection | None = None
    source: Way | None = None
    run: bool = False


@dataclass
class Stranger:
    """Packets of a connection that is not judged: another device, or no Forward Open."""

    source: bytes
    destination: bytes
    length: int
    text: str
    packets: int = 0


@dataclass
class _Line:
    """One direction of a connection, found by its connection identifier."""

    robot: Robot
    way: Way
    connection: Connection
    to_robot: bool


_Key = tuple[bytes, bytes, int]


class Network:
    """The connections of all controllers of a capture.

    Args:
        hosts: Addresses of the controllers. If given, the Forward Opens do not select them, and all
            other controllers are ignored.
        sizes: Allowed sizes of their areas.
        port: TCP port of explicit messages.

    Attributes:
        strangers: Counters of packets that are not judged, for a limited number of connections.
        cyclic: Number of class 1 packets.
        unreadable: Number of Forward Opens that could not be decoded.
    """

    def __init__(
        self, hosts: Collection[bytes] = (), sizes: Collection[int] = AREA_SIZES, port: int = PORT
    ) -> None:
        self.robots: dict[bytes, Robot] = {}
        self.strangers: dict[_Key, Stranger] = {}
        self.cyclic = self.unreadable = 0
        self.streams = Streams()
        self._hosts, self._sizes, self._port = frozenset(hosts), tuple(sizes), port
        self._lines: dict[_Key, _Line] = {}
        self._pending: dict[tuple[bytes, bytes, bytes], ForwardOpen] = {}
        self._open: dict[tuple[bytes, bytes, bytes], tuple[Robot, Connection]] = {}

    def take(self, packet: Packet) -> Iterator[Sample | Note]:
        """Yield the new samples and notes from a packet."""
        if packet.tcp:
            if self._port in (packet.source_port, packet.destination_port):
                yield from self._explicit(packet)
        elif packet.payload.startswith(_CYCLIC):
            yield from self._implicit(packet)

    def _implicit(self, packet: Packet) -> Iterator[Sample | Note]:
        cyclic = decode_packet(packet.payload)
        if cyclic is None:
            return
        self.cyclic += 1
        multicast = packet.destination[0] in _MULTICAST
        to = b"" if multicast else packet.destination
        key = (packet.source, to, cyclic.connection_id)
        line = self._lines.get(key)
        if line is None:
            length = len(packet.payload) - 18
            line = self._guessed(key, packet, length)
            if line is None:
                self._strange(key, packet, length, "no Forward Open of it in the capture")
                return
        way, robot = line.way, line.robot
        arrival = way.take(packet.t_us, cyclic, packet.cut)
        if way.silent_us and robot.owner and way in (robot.owner.to_robot, robot.owner.to_master):
            limit = format_us(way.timeout_us)
            where = "to" if line.to_robot else "from"
            text = f"no packets {where} the controller for {format_us(way.silent_us)}; time-out"
            yield Note(packet.t_us, robot.number, f"{text} {limit}")
        if arrival is not None:
            yield from self._update(packet, line, arrival)

    def _update(self, packet: Packet, line: _Line, arrival: Arrival) -> Iterator[Sample | Note]:
        robot = line.robot
        run = robot.run
        if line.to_robot:
            if line.connection is not robot.owner:
                return
            if arrival.run != robot.run or not robot.si:
                text = "runs" if arrival.run else "is stopped (idle header)"
                yield Note(packet.t_us, robot.number, f"the program of the PLC {text}")
            robot.run = arrival.run
            changed = robot.si != arrival.data
            robot.si = arrival.data
        else:
            if line.way is not robot.source:
                return
            changed = robot.so != arrival.data
            robot.so = arrival.data
        if changed or run != robot.run or line.way.silent_us:
            # If the area is unchanged after a gap, no visible change happened during the gap.
            yield self._sample(packet, robot, not arrival.gap)

    def _sample(self, packet: Packet, robot: Robot, whole: bool = True) -> Sample:
        driven = robot.owner is not None and robot.run
        at = (packet.t_us, packet.number, robot.number)
        return Sample(*at, robot.so, robot.si, driven, whole)

    def _explicit(self, packet: Packet) -> Iterator[Sample | Note]:
        for frame in self.streams.take(packet):
            if frame.command != Command.SEND_RR_DATA:
                continue
            found = unconnected_items(frame.data)
            if found is None or len(found[0]) < 2:
                continue
            message = found[0]
            if not message[0] & 0x80:
                self._asked(packet, message)
            elif (reply := decode_reply(message)) is not None:
                yield from self._answered(packet, reply)

    def _asked(self, packet: Packet, message: bytes) -> None:
        ends = (packet.source, packet.destination)
        try:
            request = decode_request(message)
            if request.path.class_id != ClassId.CONNECTION_MANAGER:
                return
            if request.service == ConnectionService.UNCONNECTED_SEND:
                request = _wrapped(request.data)
            if request.service in _OPEN:
                asked = decode_forward_open(request)
                key = (*ends, asked.triad.encode())
                self._pending[key] = asked
                if len(self._pending) > _MOST_PENDING:
                    del self._pending[next(iter(self._pending))]
        except (Refusal, IndexError):
            self.unreadable += 1

    def _answered(self, packet: Packet, reply: Reply) -> Iterator[Sample | Note]:
        ends = (packet.destination, packet.source)
        if reply.service in _OPEN:
            failed = reply.status != 0
            asked = self._pending.pop((*ends, reply.data[:8] if failed else reply.data[8:16]), None)
            if asked is None:
                return
            if failed:
                yield from self._refused(packet, asked, reply)
            else:
                yield from self._opened(packet, asked, reply)
        elif reply.service == ConnectionService.FORWARD_CLOSE and not reply.status:
            found = self._open.pop((*ends, reply.data[:8]), None)
            if found is not None:
                yield from self._end(packet, *found, "closed by a Forward Close")

    def _refused(self, packet: Packet, asked: ForwardOpen, reply: Reply) -> Iterator[Note]:
        robot = self._robot_of(packet.source, asked)
        if robot is not None:
            extended = reply.extended[0] if reply.extended else None
            why = status_text(reply.status) if extended is None else extended_text(extended)
            code = f"16#{reply.status:02X}{f', 16#{extended:04X}' if extended is not None else ''}"
            text = f"refuses a connection of {host_text(packet.destination)}: {why} ({code})"
            yield Note(packet.t_us, robot.number, text)

    def _opened(self, packet: Packet, asked: ForwardOpen, reply: Reply) -> Iterator[Sample | Note]:
        agreed = decode_open_reply(reply.data)
        if agreed is None or asked.transport_class != 1:
            return
        host, peer = packet.source, packet.destination
        multicast = asked.t_to_o.kind is ConnectionType.MULTICAST
        to_robot = (peer, host, agreed.o_to_t_id)
        to_master = (host, b"" if multicast else peer, agreed.t_to_o_id)
        robot = self._robot_of(host, asked)
        if robot is None:
            text = f"of {host_text(host)}, {asked.t_to_o.size} and {asked.o_to_t.size} bytes"
            for key, wire in ((to_robot, asked.o_to_t.size), (to_master, asked.t_to_o.size)):
                self._lines.pop(key, None)
                if len(self.strangers) < _MOST_STRANGERS:
                    self.strangers[key] = Stranger(key[0], key[1], wire, text)
            return
        size, header = _TO_ROBOT.get(asked.o_to_t.size, (None, False))
        patience = 4 << asked.multiplier
        connection = Connection(
            peer=peer,
            kind=ConnectionKind.INPUT_ONLY if size is None else ConnectionKind.EXCLUSIVE_OWNER,
            begin_us=packet.t_us,
            to_robot=Way(size, header, agreed.o_to_t_api_us * patience),
            to_master=Way(
                robot.size, _TO_ROBOT[asked.t_to_o.size][1], agreed.t_to_o_api_us * patience
            ),
            to_robot_us=agreed.o_to_t_api_us,
            to_master_us=agreed.t_to_o_api_us,
        )
        shared = self._lines.get(to_master) if multicast else None
        if shared is not None and any(
            one.to_master is shared.way and not one.end for one in robot.connections
        ):
            connection.to_master = shared.way  # multicast: the packets of one producer
        yield from self._begin(packet, robot, connection)
        for old in [key for key, (one, _) in self._open.items() if one is robot]:
            if self._open[old][1].end:
                del self._open[old]
        self._open[peer, host, asked.triad.encode()] = robot, connection
        if len(self._lines) > _MOST_LINES:
            ended = [key for key, line in self._lines.items() if line.connection.end]
            for key in ended:
                del self._lines[key]
        self._lines[to_robot] = _Line(robot, connection.to_robot, connection, True)
        self._lines[to_master] = _Line(robot, connection.to_master, connection, False)

    def _begin(self, packet: Packet, robot: Robot, new: Connection) -> Iterator[Sample | Note]:
        owner = new.kind is ConnectionKind.EXCLUSIVE_OWNER
        if owner and robot.owner is not None:
            yield from self._end(packet, robot, robot.owner, "replaced by a new one")
        if len(robot.connections) < _MOST_CONNECTIONS:
            robot.connections.append(new)
        if owner:
            robot.owner, robot.source, robot.run = new, new.to_master, False
            robot.so = robot.si = b""
        elif robot.owner is None:
            robot.source, robot.so = new.to_master, b""
        every = ""
        if new.opened:
            every = f", every {format_us(new.to_robot_us)} to the controller, "
            every += f"every {format_us(new.to_master_us)} from it"
        what = f"{new.kind.value} connection of {host_text(new.peer)}, {robot.size} bytes{every}"
        yield Note(packet.t_us, robot.number, what)

    def _end(
        self, packet: Packet, robot: Robot, connection: Connection, how: str
    ) -> Iterator[Sample | Note]:
        if connection.end:
            return
        connection.end, connection.end_us = how, packet.t_us
        text = f"the {connection.kind.value} connection of {host_text(connection.peer)} is {how}"
        yield Note(packet.t_us, robot.number, text)
        if connection is robot.owner:
            robot.owner, robot.run, robot.si = None, False, b""
            yield self._sample(packet, robot)
        others = [one for one in robot.connections if not one.end and one is not robot.owner]
        if robot.owner is None and others:
            robot.source = others[-1].to_master

    def _robot_of(self, host: bytes, asked: ForwardOpen) -> Robot | None:
        """Return the controller that a Forward Open addresses; None for another device."""
        size = _TO_ROBOT.get(asked.t_to_o.size, (0, False))[0]
        if size not in self._sizes or (self._hosts and host not in self._hosts):
            return None
        if not self._hosts:
            points = _points(asked.path)
            size_to, _ = _TO_ROBOT.get(asked.o_to_t.size, (0, False))
            if points[1:] != (TO_MASTER,) or (size_to and points[0] != TO_ROBOT):
                return None
        return self._robot(host, size)

    def _robot(self, host: bytes, size: int) -> Robot:
        robot = self.robots.get(host)
        if robot is None:
            robot = self.robots[host] = Robot(len(self.robots) + 1, host, size)
        robot.size = size
        return robot

    def _guessed(self, key: _Key, packet: Packet, length: int) -> _Line | None:
        """Return a direction of a connection without a Forward Open in the capture.

        The addresses and sizes of its packets decide the direction.
        """
        if key in self.strangers:
            return None
        size, header = _TO_ROBOT.get(length, (0, False))
        if size not in self._sizes:
            return None
        to_robot = packet.destination in self._hosts
        if not to_robot and (packet.source not in self._hosts or header):
            return None
        host, peer = packet.destination if to_robot else packet.source, packet.source
        robot = self._robot(host, size)
        connection = robot.connections[-1] if robot.connections else None
        if connection is None or connection.opened or connection.end:
            kind = ConnectionKind.INPUT_ONLY
            ways = Way(None, False), Way(size, False)
            connection = Connection(peer, kind, packet.t_us, *ways, opened=False)
            robot.connections.append(connection)
            if robot.owner is None:
                robot.source = connection.to_master
        if to_robot:
            connection.peer, connection.kind = peer, ConnectionKind.EXCLUSIVE_OWNER
            connection.to_robot = Way(size, header)
            if robot.owner is None:
                robot.owner = connection
        way = connection.to_robot if to_robot else connection.to_master
        line = self._lines[key] = _Line(robot, way, connection, to_robot)
        return line

    def _strange(self, key: _Key, packet: Packet, length: int, text: str) -> None:
        found = self.strangers.get(key)
        if found is None:
            if len(self.strangers) >= _MOST_STRANGERS:
                return
            found = Stranger(packet.source, packet.destination, length, text)
            self.strangers[key] = found
        found.packets += 1
        found.destination = packet.destination


def _wrapped(data: bytes) -> Request:
    """Return the request inside an Unconnected Send.

    An Unconnected Send consists of ticks, length, request and route.
    """
    length = int.from_bytes(data[2:4], "little")
    return decode_request(data[4 : 4 + length])


def _points(path: bytes) -> tuple[int, ...]:
    """Return the consuming and the producing connection point of a path.

    Other paths have no connection points.
    """
    while path and not path[0] & 0xE0:  # skip port segments, which contain the route to the adapter
        length = 2 if not path[0] & 0x10 else 2 + path[1] + path[1] % 2
        path = path[length:]
    try:
        found = decode_connection_path(path)
    except (Refusal, IndexError):
        return ()
    return found.numbers[-2:] if found.class_id == ClassId.ASSEMBLY else ()
