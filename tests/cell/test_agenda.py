"""What happens next: the order of a cell's events, and those that come again and again."""

from __future__ import annotations

from rcx_harness.cell.clock import Agenda, Kind


def taken(agenda: Agenda, count: int) -> list[tuple[int, Kind]]:
    return [agenda.pop()[:2] for _ in range(count)]  # type: ignore[misc]


def test_what_repeats_comes_by_itself_between_what_comes_once() -> None:
    """At equal times the order is that of Kind.

    Source: rcx_harness.cell.clock, first paragraph.
    """
    agenda = Agenda()
    agenda.repeat(0, Kind.SCAN, 10)
    agenda.repeat(5, Kind.CYCLE, 5)
    agenda.add(10, Kind.STIMULUS, "once")
    assert taken(agenda, 3) == [(0, Kind.SCAN), (5, Kind.CYCLE), (10, Kind.STIMULUS)]
    assert taken(agenda, 3) == [(10, Kind.CYCLE), (10, Kind.SCAN), (15, Kind.CYCLE)]


def test_another_period_counts_from_the_next_event_on() -> None:
    """What is already due keeps its time.

    Source: Agenda.periods.
    """
    agenda = Agenda()
    agenda.repeat(0, Kind.CYCLE, 5)
    assert taken(agenda, 1) == [(0, Kind.CYCLE)]
    agenda.periods[Kind.CYCLE] = 7
    assert taken(agenda, 3) == [(5, Kind.CYCLE), (12, Kind.CYCLE), (19, Kind.CYCLE)]


def test_what_repeats_goes_on_after_a_restore() -> None:
    """An agenda that is set back gives the same events again.

    Source: Agenda.snapshot.
    """
    agenda = Agenda()
    agenda.repeat(0, Kind.CYCLE, 5)
    agenda.add(7, Kind.DELIVER, "packet")
    agenda.pop()
    before = agenda.snapshot()
    first = [agenda.pop() for _ in range(4)]
    agenda.restore(before)
    assert [agenda.pop() for _ in range(4)] == first
    assert (7, Kind.DELIVER, "packet") in first
