"""A cell runs its single and repeated events in the order of their times."""

from __future__ import annotations

from rcx_harness.cell.clock import Kind
from structured_text.bench.agenda import Action, Agenda

#: A list of events: the time [us] and the name of each.
Seen = list[tuple[int, str]]


def noted(seen: Seen, name: str) -> Action:
    """Return an action that records its time and its name in `seen`."""
    return lambda now_us: seen.append((now_us, name))


def take(agenda: Agenda, count: int) -> None:
    """Run the next `count` events of the agenda."""
    for _ in range(count):
        now_us, action = agenda.pop()
        action(now_us)


def test_repeated_and_single_events_keep_their_order() -> None:
    """Events with the same time run in the order of Kind: first stimulus, then cycle, then scan.

    Source: rcx_harness.cell.clock, first paragraph.
    """
    agenda, seen = Agenda(), Seen()
    agenda.repeat(0, Kind.SCAN, 10, noted(seen, "scan"))
    agenda.repeat(5, Kind.CYCLE, 5, noted(seen, "cycle"))
    agenda.add(10, Kind.STIMULUS, noted(seen, "once"))
    take(agenda, 6)
    assert seen == [
        (0, "scan"), (5, "cycle"), (10, "once"), (10, "cycle"), (10, "scan"), (15, "cycle")
    ]  # fmt: skip


def test_at_equal_times_one_kind_of_event_follows_the_other() -> None:
    """At equal times all cycles are executed before all packets.

    Among cycles, and among packets, those of the first controller come first.

    Source: rcx_harness.cell.clock, first paragraph.
    """
    agenda, seen = Agenda(), Seen()
    for number in (2, 1):
        agenda.add(10, Kind.DELIVER, noted(seen, f"old packet {number}"), number)
        agenda.add(10, Kind.DELIVER, noted(seen, f"new packet {number}"), number)
        agenda.repeat(10, Kind.CYCLE, 5, noted(seen, f"cycle {number}"), number)
    agenda.repeat(10, Kind.SCAN, 10, noted(seen, "scan"))
    take(agenda, 8)
    cycles = ["cycle 1", "cycle 2"]
    packets = ["old packet 1", "new packet 1", "old packet 2", "new packet 2"]
    assert [name for _, name in seen] == [*cycles, *packets, "scan", "cycle 1"]
    assert seen[-1][0] == 15


def test_a_new_period_applies_after_the_next_event() -> None:
    """A new period applies after the next event, because that event is already scheduled.

    Source: Agenda.periods.
    """
    agenda, seen = Agenda(), Seen()
    agenda.repeat(0, Kind.CYCLE, 5, noted(seen, "cycle"))
    take(agenda, 1)
    agenda.periods[Kind.CYCLE] = 7
    take(agenda, 3)
    assert [now_us for now_us, _ in seen] == [0, 5, 12, 19]


def test_repeated_events_continue_after_a_restore() -> None:
    """After its snapshot is restored, an agenda runs the same events again.

    Source: Agenda.snapshot.
    """
    agenda, seen = Agenda(), Seen()
    agenda.repeat(0, Kind.CYCLE, 5, noted(seen, "cycle"))
    agenda.add(7, Kind.DELIVER, noted(seen, "packet"))
    agenda.pop()
    before = agenda.snapshot()
    take(agenda, 4)
    first = seen.copy()
    agenda.restore(before)
    take(agenda, 4)
    assert seen == first * 2
    assert (7, "packet") in first
