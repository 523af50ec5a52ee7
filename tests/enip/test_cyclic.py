"""Class 1 connections of a device send and accept packets at the right times.

The tests use literal packets and virtual time, without sockets. Times are in microseconds. The
connections and their packets are in `exchange_bench`.
"""

from __future__ import annotations

from dataclasses import replace

import pytest

from exchange_bench import DATA, IMAGE, INPUT_ONLY, MASTER, OTHER, OWNER, Device, packet
from rcx_harness.enip.cyclic.connections import ConnectionParameters, EndReason, OwnerState
from rcx_harness.enip.cyclic.journal import ConnectionEvent
from rcx_harness.enip.cyclic.shared import Drop, SharedImages

# Tests of the packets that the robot sends


def test_a_packet_is_sent_every_interval(owned: Device) -> None:
    owned.images.to_master.write(IMAGE)
    assert owned.poll(0) == 10_000
    assert owned.poll(10_000) == 20_000
    assert owned.poll(19_999) == 20_000
    assert owned.poll(20_400) == 30_000
    assert owned.sent == [
        (
            bytes.fromhex(f"0200 0280 0800 22222222 {number} B100 3200 0100 {DATA}"),
            (MASTER, 2222),
            0,
        )
        for number in ("01000000", "02000000")
    ]
    assert owned.images.status().sent == 2


@pytest.mark.parametrize(
    ("api_us", "first_us"), [(1_000, 1_000), (10_000, 10_000), (3_200_000, 10_000)]
)
def test_the_first_packet_is_sent_after_the_reply_has_arrived(
    device: Device, api_us: int, first_us: int
) -> None:
    device.exchange.add(replace(OWNER, t_to_o_api_us=api_us), 500)
    device.poll(500 + first_us - 1)
    assert device.sent == []
    assert device.poll(500 + first_us) == min(500 + first_us + api_us, 10_000_500)
    assert len(device.sent) == 1


def test_new_outputs_of_the_robot_raise_the_short_count(owned: Device) -> None:
    owned.poll(10_000)
    owned.images.to_master.write(IMAGE)
    owned.poll(20_000)
    owned.poll(30_000)
    counts = [one[0][18:20].hex() for one in owned.sent]
    assert counts == ["0100", "0200", "0200"]
    assert owned.sent[1][0][20:] == IMAGE


def test_after_a_stall_only_one_packet_is_sent(owned: Device) -> None:
    owned.poll(10_000)
    assert owned.poll(67_000) == 70_000
    assert len(owned.sent) == 2
    assert owned.images.status().skipped == 4


def test_packets_have_the_agreed_port_and_code_point(device: Device) -> None:
    device.exchange.add(replace(OWNER, destination_port=40_000, dscp=47), 0)
    device.poll(10_000)
    assert device.sent[0][1:] == ((MASTER, 40_000), 47)


# Tests of the packets that the master sends


def test_data_of_the_running_master_goes_into_assembly_150(owned: Device) -> None:
    assert owned.exchange.receive(packet(7, 1), MASTER, 5_000)
    assert owned.images.to_robot.read() == IMAGE
    status = owned.images.status()
    assert status.owner is OwnerState.RUN
    assert (status.peer, status.o_to_t_api_us, status.t_to_o_api_us) == (MASTER, 10_000, 10_000)
    assert status.received == 1


@pytest.mark.parametrize("before", [[], [0]])
def test_data_are_written_before_the_state_run(
    owned: Device, monkeypatch: pytest.MonkeyPatch, before: list[int]
) -> None:
    """A reader that sees RUN finds the data, both at the start and after idle."""
    seen: list[tuple[OwnerState, bytes]] = []
    set_owner = SharedImages.set_owner

    def watching(
        images: SharedImages, state: OwnerState, connection: ConnectionParameters | None
    ) -> None:
        set_owner(images, state, connection)
        seen.append((state, images.to_robot.read()))

    monkeypatch.setattr(SharedImages, "set_owner", watching)
    for number, run in enumerate((*before, 1), 1):
        owned.exchange.receive(packet(number, 1, run=run), MASTER, 1_000)
    assert seen[-1] == (OwnerState.RUN, IMAGE)


def test_an_arrival_is_published_after_its_data(
    owned: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[bytes] = []
    monkeypatch.setattr(
        SharedImages, "arrive", lambda images, *_: seen.append(images.to_robot.read())
    )
    owned.exchange.receive(packet(1, 1), MASTER, 1_000)
    assert seen == [IMAGE]


def test_data_of_an_idle_master_are_ignored(owned: Device) -> None:
    """Data of an idle master are ignored.

    `generation` counts the changes of the state, not the packets.
    """
    states = []
    for number, run in enumerate((0, 1, 0, 0, 1), 1):
        owned.exchange.receive(packet(number, number, run=run), MASTER, 0)
        states.append((owned.owner(), owned.images.to_robot.read()))
    run_, idle = OwnerState.RUN, OwnerState.IDLE
    assert [state for state, _ in states] == [idle, run_, idle, idle, run_]
    assert states[0][1] == bytes(48)
    assert owned.images.status().generation == 5


def test_without_run_idle_header_the_master_runs(device: Device) -> None:
    device.exchange.add(replace(OWNER, run_idle=False), 0)
    modeless = bytes.fromhex(f"0200 0280 0800 11111111 01000000 B100 3200 0100 {DATA}")
    assert device.exchange.receive(modeless, MASTER, 0)
    assert device.owner() is OwnerState.RUN
    assert device.images.to_robot.read() == IMAGE


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        (packet(8, 2)[:-1], Drop.LENGTH),  # the item is longer than the datagram
        (packet(8, 2) + b"\0", Drop.LENGTH),
        (bytes.fromhex(f"0200 0280 0800 11111111 08000000 B100 3200 0200 {DATA}"), Drop.LENGTH),
        (
            bytes.fromhex(f"0200 0280 0800 11111111 08000000 B100 3500 0200 01000000 {DATA[:-2]}"),
            Drop.LENGTH,
        ),
        (packet(7, 2), Drop.OLD),  # a repeated sequence number
        (packet(6, 2), Drop.OLD),
        (packet(0x80000007, 2), Drop.OLD),
        (packet(0x70000000, 2), Drop.JUMP),
    ],
)
def test_a_dropped_packet_is_counted_with_its_reason(
    owned: Device, wrong: bytes, reason: Drop
) -> None:
    owned.exchange.receive(packet(7, 1), MASTER, 0)
    owned.images.to_robot.write(bytes(48))
    assert owned.exchange.receive(wrong, MASTER, 1_000)
    assert owned.images.to_robot.read() == bytes(48)
    status = owned.images.status()
    assert (status.received, status.dropped) == (1, 1)
    assert status.drops[reason] == 1


def test_forged_packets_with_a_far_number_do_not_disturb_the_owner(owned: Device) -> None:
    """Forged packets with far sequence numbers are dropped, and the owner's connection continues.

    The forged packets have the owner's address and connection id.
    """
    owned.exchange.receive(packet(1, 1), MASTER, 0)
    for number in range(2, 50):
        forged = packet(0x70000000 + number, number)[:-48] + b"\xff" * 48
        assert owned.exchange.receive(forged, MASTER, 10_000 * number)
        owned.exchange.receive(packet(number, number), MASTER, 10_000 * number)
        assert owned.images.to_robot.read() == IMAGE
    status = owned.images.status()
    assert (status.received, status.drops[Drop.JUMP], status.missing) == (49, 48, 0)


def test_a_wrong_length_is_stored_beside_the_right_one(owned: Device) -> None:
    """The device stores the length of a dropped packet (50 bytes) and the agreed length (54 bytes).

    The dropped packet lacks the run/idle header of 4 bytes.
    """
    wrong = bytes.fromhex(f"0200 0280 0800 11111111 08000000 B100 3200 0200 {DATA}")
    owned.exchange.receive(wrong, MASTER, 0)
    status = owned.images.status()
    assert (status.wrong_length, status.right_length) == (50, 54)


def test_a_packet_from_another_host_is_dropped_and_counted(owned: Device) -> None:
    assert owned.exchange.receive(packet(1, 1), OTHER, 0)
    assert owned.images.to_robot.read() == bytes(48)
    assert owned.owner() is OwnerState.WAITING
    assert owned.images.status().drops == (0, 1, 0, 0, 0)


@pytest.mark.parametrize(
    "unknown", [packet(1, 1, "99999999"), packet(1, 1, "22222222"), b"", b"\0" * 72]
)
def test_a_packet_with_an_unknown_connection_id_is_not_received(
    owned: Device, unknown: bytes
) -> None:
    assert not owned.exchange.receive(unknown, MASTER, 0)
    assert owned.images.status().received == 0


def test_missing_packets_are_counted(owned: Device) -> None:
    for number in (0xFFFFFFFE, 1, 2):
        owned.exchange.receive(packet(number, number & 0xFFFF), MASTER, 0)
    status = owned.images.status()
    assert (status.received, status.missing, status.dropped) == (3, 2, 0)


def test_gaps_between_packets_are_stored(owned: Device) -> None:
    for number, now_us in enumerate((0, 10_100, 19_900), 1):
        owned.exchange.receive(packet(number, number), MASTER, now_us)
    assert owned.images.gaps_us() == [10_100, 9_800]


# Tests of time-outs and of closed connections


@pytest.mark.parametrize(
    "owner",
    [
        pytest.param(OWNER, id="whose time-out is 160 ms"),
        pytest.param(
            replace(OWNER, o_to_t_api_us=3_200_000, multiplier=7, first_packet_us=10_000_000),
            id="whose time-out is 512 intervals of 3.2 s",
        ),
    ],
)
def test_an_owner_that_never_sends_times_out_after_ten_seconds(
    device: Device, owner: ConnectionParameters
) -> None:
    device.exchange.add(owner, 0)
    device.poll(9_999_999)
    assert device.ended == []
    device.poll(10_000_000)
    assert device.ended == [(1, EndReason.TIMED_OUT)]


@pytest.mark.parametrize(("multiplier", "intervals"), [(0, 4), (2, 16), (5, 128), (7, 512)])
def test_silence_of_interval_times_multiplier_ends_the_connection(
    device: Device, multiplier: int, intervals: int
) -> None:
    device.exchange.add(replace(OWNER, multiplier=multiplier), 0)
    device.exchange.receive(packet(1, 1), MASTER, 3_000)
    device.poll(3_000 + intervals * 10_000 - 1)
    assert device.owner() is OwnerState.RUN
    device.poll(3_000 + intervals * 10_000)
    assert device.owner() is OwnerState.TIMED_OUT
    assert device.ended == [(1, EndReason.TIMED_OUT)]


def test_the_time_out_is_measured_in_the_masters_interval(device: Device) -> None:
    device.exchange.add(replace(OWNER, o_to_t_api_us=2_000, t_to_o_api_us=100_000), 0)
    device.exchange.receive(packet(1, 1), MASTER, 0)
    assert device.poll(31_999) == 32_000
    device.poll(32_000)
    assert device.owner() is OwnerState.TIMED_OUT


def test_the_first_packet_shortens_the_time_out(device: Device) -> None:
    """The first packet shortens the time-out from 10 s to 16 intervals of 2 ms.

    The device must check this time-out before its own next packet is due.
    """
    device.exchange.add(replace(OWNER, o_to_t_api_us=2_000, t_to_o_api_us=3_200_000), 0)
    assert device.poll(10_000) == 3_210_000
    device.exchange.receive(packet(1, 1), MASTER, 20_000)
    assert device.poll(20_000) == 52_000
    device.poll(52_000)
    assert device.ended == [(1, EndReason.TIMED_OUT)]


def test_a_second_connection_is_due_at_its_own_time(device: Device) -> None:
    """A second connection sends at its own times, even if the first one sends more slowly.

    This does not change when the first connection is closed.
    """
    device.exchange.add(replace(OWNER, t_to_o_api_us=3_200_000), 0)
    assert device.poll(10_000) == 3_210_000
    device.exchange.add(replace(INPUT_ONLY, t_to_o_api_us=5_000), 20_000)
    assert device.poll(20_000) == 25_000
    device.exchange.remove(1, 0)
    assert device.poll(24_000) == 25_000
    assert device.poll(25_000) == 30_000
    assert len(device.sent) == 2


def test_after_the_time_out_no_packets_are_sent_or_accepted(owned: Device) -> None:
    owned.exchange.receive(packet(1, 1), MASTER, 0)
    owned.poll(160_000)
    owned.destinations()
    assert not owned.exchange.receive(packet(2, 2), MASTER, 161_000)
    assert owned.owner() is OwnerState.TIMED_OUT
    assert owned.poll(170_000) is None
    assert owned.destinations() == []
    assert owned.images.status().connections == 0


def test_a_closed_connection_ends_without_report(owned: Device) -> None:
    """The end of a closed connection is not reported.

    Closing an unknown connection has no effect.
    """
    owned.exchange.receive(packet(1, 1), MASTER, 0)
    owned.exchange.remove(99, 0)
    assert owned.images.status().owners == 1
    owned.exchange.remove(1, 0)
    assert owned.owner() is OwnerState.CLOSED
    assert owned.ended == []
    assert owned.poll(20_000) is None
    assert owned.destinations() == []
    assert not owned.exchange.receive(packet(2, 2), MASTER, 0)


def test_an_owner_can_connect_again_after_a_time_out(owned: Device) -> None:
    owned.exchange.receive(packet(1, 1), MASTER, 0)
    owned.poll(160_000)
    owned.exchange.add(replace(OWNER, number=9, o_to_t_id=0x77777777), 200_000)
    assert owned.owner() is OwnerState.WAITING
    assert owned.exchange.receive(packet(1, 1, "77777777"), MASTER, 201_000)
    assert owned.owner() is OwnerState.RUN


def test_an_adapter_that_is_switched_off_loses_all_connections(owned: Device) -> None:
    owned.exchange.add(INPUT_ONLY, 0)
    owned.exchange.clear(0)
    assert owned.ended == [(1, EndReason.OFF), (2, EndReason.OFF)]
    assert owned.images.status().connections == 0
    assert owned.owner() is OwnerState.NONE
    assert owned.poll(0) is None


# Tests of the journal of connection events


def new_entries(device: Device) -> list[tuple[int, str, str, str, int]]:
    """Return the new entries of the journal as (time, kind, state, peer, number of readers)."""
    events = [ConnectionEvent.from_record(one) for one in device.images.events.read().records]
    return [(one.at_us, one.kind.value, one.state, one.peer, one.readers) for one in events]


def test_each_change_of_a_connection_is_one_entry_with_its_own_time(device: Device) -> None:
    device.exchange.add(OWNER, 1_000)
    device.exchange.receive(packet(1, 1), MASTER, 2_000)
    device.exchange.receive(packet(2, 2), MASTER, 12_000)
    device.exchange.add(INPUT_ONLY, 13_000)
    device.exchange.receive(packet(3, 3, run=0), MASTER, 22_000)
    device.exchange.remove(2, 23_000)
    owner, reader = ("exclusive owner", MASTER), ("input only", OTHER)
    assert new_entries(device) == [
        (1_000, owner[0], "waiting", MASTER, 0),
        (2_000, owner[0], "run", MASTER, 0),
        (13_000, reader[0], "waiting", OTHER, 1),
        (22_000, owner[0], "idle", MASTER, 1),
        (23_000, reader[0], "closed", OTHER, 0),
    ]
    device.poll(182_000)
    assert new_entries(device) == [(182_000, owner[0], "timed out", MASTER, 0)]
    device.exchange.add(OWNER, 200_000)
    device.exchange.clear(210_000)
    assert new_entries(device)[1:] == [(210_000, owner[0], "off", MASTER, 0)]


def test_five_openings_and_closings_at_short_intervals_are_ten_entries(device: Device) -> None:
    for at_us in range(0, 500, 100):
        device.exchange.add(OWNER, at_us)
        device.exchange.remove(1, at_us + 50)
    assert [(one[0], one[2]) for one in new_entries(device)] == [
        (at_us, "closed" if at_us % 100 else "waiting") for at_us in range(0, 500, 50)
    ]
