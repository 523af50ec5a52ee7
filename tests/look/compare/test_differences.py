"""The comparison of a recorded and a virtual controller reports the differences that matter."""

from __future__ import annotations

import pytest

from rcx_harness.look.compare.channels import Channel, Difference, Timeline, channels, differences

CHANNEL = Channel("SO02", 32, 33, 2)


def _found(
    recorded: list[tuple[int, int]], virtual: list[tuple[int, int]], tolerance: int = 0
) -> list[tuple[int, int]]:
    found = differences(CHANNEL, Timeline(recorded), Timeline(virtual), (0, 100), tolerance)
    return [(one.begin_us, one.end_us) for one in found]


@pytest.mark.parametrize(
    ("recorded", "virtual", "tolerance", "found"),
    [
        ([(0, 0), (10, 1)], [(0, 0), (10, 1)], 0, []),
        ([(0, 0), (10, 1)], [(0, 0), (15, 1)], 0, [(10, 15)]),
        ([(0, 0), (10, 1)], [(0, 0), (15, 1)], 5, []),
        ([(0, 0), (10, 1)], [(0, 0), (16, 1)], 5, [(10, 11)]),
        ([(0, 0), (20, 1)], [(0, 0), (10, 1)], 5, [(10, 15)]),
        ([(0, 0)], [(0, 0), (10, 1)], 5, [(10, 100)]),
        ([(0, 0), (10, 1), (20, 0)], [(0, 0)], 0, [(10, 20)]),
    ],
)
def test_a_value_is_a_difference_where_the_other_side_does_not_have_it_within_the_tolerance(
    recorded: list[tuple[int, int]],
    virtual: list[tuple[int, int]],
    tolerance: int,
    found: list[tuple[int, int]],
) -> None:
    assert [one[0] for one in _found(recorded, virtual, tolerance)] == [one[0] for one in found]
    if not tolerance:
        assert _found(recorded, virtual) == found


def test_a_short_value_of_the_virtual_controller_is_not_a_difference() -> None:
    """A short value that only the virtual controller had is not a difference.

    Perhaps no packet of the recorded controller contained the value.

    A short value of the recorded controller counts, because a packet contained it.
    """
    assert _found([(0, 0)], [(0, 0), (50, 1), (54, 0)], 5) == []
    assert _found([(0, 0), (50, 1), (54, 0)], [(0, 0)], 5) == [(50, 54)]


def test_each_part_of_an_area_is_a_channel_of_its_own() -> None:
    names = [one.name for one in channels(48)]
    assert names[:3] == ["status", "response", "SO00"]
    assert names[-2:] == ["SO13()", "reserved"]
    assert [one.name for one in channels(256)][-1] == "SOW(127)"
    covered = {at for one in channels(256) for at in range(one.first, one.end)}
    assert covered == set(range(256))
    area = bytearray(48)
    area[0:2], area[32] = b"\x00\x02", 4
    values = {one.name: one.of(bytes(area)) for one in channels(48)}
    assert {name for name, value in values.items() if value} == {"status", "SO02"}
    assert values["status"] == 0x0200


def test_a_difference_has_both_values() -> None:
    found = differences(CHANNEL, Timeline([(0, 1)]), Timeline([(0, 0)]), (0, 9), 0)
    assert list(found) == [Difference("SO02", 0, 9, 1, 0)]
