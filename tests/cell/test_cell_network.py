from __future__ import annotations

from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink, PacketNetwork
from structured_text.bench.agenda import Agenda

OLD, LATE, NEW = (bytes([number]) * 48 for number in (1, 2, 3))


TIMING = Timing.make(rpi="10ms", jitter="50ms")


def network_with(agenda: Agenda, link: DirectLink) -> PacketNetwork:
    network = PacketNetwork(link, TIMING, agenda, matched=True, seed=0)
    network.set_adapter(True)
    return network


def deliver_all(agenda: Agenda) -> None:
    while agenda.snapshot()[0]:
        t_us, arrive = agenda.pop()
        arrive(t_us)


def test_packets_under_way_are_lost_when_the_cable_is_unplugged() -> None:
    agenda, link = Agenda(), DirectLink(48)
    network = network_with(agenda, link)
    network.produce_to_robot(0, lambda: OLD)
    network.set_cable(False)
    network.produce_to_robot(0, lambda: OLD)
    network.set_cable(True)
    deliver_all(agenda)
    assert link.robot_read() == bytes(48)
    assert not network.robot_connected(50_000)
    network.produce_to_robot(60_000, lambda: NEW)
    deliver_all(agenda)
    assert link.robot_read() == NEW
    assert network.robot_connected(110_000)


def test_each_direction_keeps_its_order() -> None:
    agenda, link = Agenda(), DirectLink(48)
    network = network_with(agenda, link)
    for number in range(20):
        link.robot_write(bytes([number]) * 48)
        network.produce_to_plc(number * 1_000)
    seen = []
    while agenda.snapshot()[0]:
        t_us, arrive = agenda.pop()
        arrive(t_us)
        seen.append(network.input[0])
    assert seen == list(range(20))


def test_the_plc_is_connected_as_long_as_packets_come() -> None:
    agenda, link = Agenda(), DirectLink(48)
    network = PacketNetwork(link, Timing.make(rpi="10ms"), agenda, matched=True, seed=0)
    network.set_adapter(True)
    assert not network.plc_connected(0)
    network.produce_to_plc(1_000)
    assert network.plc_connected(100_999)
    assert not network.plc_connected(101_000)


def test_the_plc_notices_even_a_short_restart_of_the_robot() -> None:
    """After a restart, the robot's adapter has no connection.

    The PLC opens a new one after its time-out.

    Source: manual chapter 1, 5.2: the connection must be restored from the normal state.
    """
    agenda, link = Agenda(), DirectLink(48)
    network = network_with(agenda, link)
    network.produce_to_robot(0, lambda: OLD)
    network.produce_to_plc(0)
    deliver_all(agenda)
    # the latest moment of the time-out, because packets are up to 50 ms late
    lost_us = TIMING.timeout_us + 50_000
    network.set_adapter(False)
    network.set_adapter(True)
    assert not network.robot_connected(60_000)
    assert network.plc_connected(60_000)
    network.produce_to_robot(60_000, lambda: NEW)
    deliver_all(agenda)
    assert link.robot_read() == OLD, "a packet arrived before the PLC noticed the restart"
    assert not network.plc_connected(lost_us)
    network.produce_to_robot(lost_us + 99_000, lambda: NEW)
    deliver_all(agenda)
    assert link.robot_read() == OLD, "opening a connection takes 100 ms"
    network.produce_to_robot(lost_us + 100_000, lambda: NEW)
    deliver_all(agenda)
    assert link.robot_read() == NEW


def test_a_packet_without_delay_arrives_at_once_but_after_older_packets() -> None:
    """Packets arrive in the order in which they were sent, even if an earlier packet is delayed.

    Source: Timing.jitter_us.
    """
    agenda, link = Agenda(), DirectLink(48)
    network = PacketNetwork(link, Timing.make(rpi="10ms"), agenda, matched=True, seed=0)
    network.set_adapter(True)
    network.produce_to_robot(10_000, lambda: OLD)
    assert link.robot_read() == OLD
    assert agenda.snapshot()[0] == ()
    late = network_with(agenda, link)
    late.produce_to_robot(20_000, lambda: LATE)
    network.restore(late.snapshot())  # the packet LATE is still on its way
    network.produce_to_robot(20_000, lambda: NEW)
    assert link.robot_read() == OLD
    seen = []
    while agenda.snapshot()[0]:
        t_us, arrive = agenda.pop()
        arrive(t_us)
        seen.append((t_us > 20_000, link.robot_read()))
    assert seen == [(True, LATE), (True, NEW)]
