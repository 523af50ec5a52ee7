"""FB_RcxJob handles Execute, and the order in which blocks use a channel.

The tests use the block alone, and as a part of other blocks.
"""

from __future__ import annotations

import pytest

from alone import Alone
from plc_bench import PlcBench


def _pins(plc: PlcBench, block: str) -> str:
    """Return the names of the outputs that are TRUE, as in `Busy Active`."""
    names = ("Done", "Busy", "Active", "Error")
    return " ".join(name for name in names if plc[f"{block}.{name}"])


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    for block, code in (("First", 0x0501), ("Second", 0x0502), ("Third", 0x0503)):
        plc[f"{block}.Code"] = code
    return plc


def _finish(plc: PlcBench) -> None:
    """Let the running command end normally and the status be reset."""
    plc.scan_until(lambda: plc.words[0] != 0)
    plc.complete()


def test_busy_appears_in_the_call_of_the_edge_and_done_stays_until_execute_falls() -> None:
    """Source: PLCopen, edge-triggered function blocks."""
    plc = _plc()
    assert _pins(plc, "First") == ""
    plc.change("First.Execute", to=True)
    assert _pins(plc, "First") == "Busy Active"
    _finish(plc)
    assert _pins(plc, "First") == "Done"
    plc.scan(10)
    assert _pins(plc, "First") == "Done"
    plc.change("First.Execute", to=False)
    assert _pins(plc, "First") == ""


def test_turns_go_first_come_first_served_across_blocks() -> None:
    plc = _plc()
    for block in ("Second", "Third", "First"):
        plc.change(f"{block}.Execute", to=True)
    order = []
    for _ in range(3):
        plc.scan()
        assert [_pins(plc, b) for b in ("First", "Second", "Third")].count("Busy Active") == 1
        plc.scan_until(lambda: plc.words[0] != 0)
        order.append(plc.words[0])
        assert plc["Robot.Inner.Command.Holder"] == plc.words[0]
        _finish(plc)
    assert order == [0x0502, 0x0503, 0x0501]
    plc.scan()
    assert plc["Robot.Inner.Command.Holder"] == 0


def test_a_waiting_block_that_is_no_longer_called_is_passed_over() -> None:
    plc = _plc()
    plc.change("First.Execute", to=True)
    plc.change("Second.Execute", to=True)
    plc.change("Third.Execute", to=True)
    plc["CallSecond"] = False
    _finish(plc)
    plc.scan_until(lambda: plc.words[0] != 0, most=6)
    assert plc.words[0] == 0x0503
    plc.change("CallSecond", to=True)
    assert plc["Second.ErrorID"] == 0x8013


def test_tickets_wrap_around() -> None:
    plc = _plc()
    plc["Robot.Inner.Command.NextTicket"] = plc["Robot.Inner.Command.Serving"] = 65535
    plc.change("First.Execute", "Second.Execute", to=True)
    assert plc["Robot.Inner.Command.NextTicket"] == 1
    assert (_pins(plc, "First"), _pins(plc, "Second")) == ("Busy Active", "Busy")
    _finish(plc)
    assert (_pins(plc, "First"), _pins(plc, "Second")) == ("Done", "Busy Active")


@pytest.mark.parametrize("seen", [True, False])
def test_after_the_timeout_the_command_is_held_and_the_next_one_is_told(seen: bool) -> None:
    plc = _plc()
    plc["First.Timeout"] = plc["Second.Timeout"] = "T#100ms"
    plc.change("First.Execute", to=True, scans=2)
    if seen:
        plc.answer(0x0100)
    plc.scan(10)
    assert plc["First.ErrorID"] == 0x8011
    assert plc.words[0] == 0x0501
    plc.change("Second.Execute", to=True, scans=11)
    assert plc["Second.ErrorID"] == 0x8012
    assert plc.words[0] == 0x0501
    plc["Second.Execute"] = False
    plc.complete()
    plc.change("Second.Execute", to=True, scans=4)
    assert plc.words[0] == 0x0502


def test_a_block_that_missed_65536_turns_does_not_use_the_turn_of_another() -> None:
    """A block that was not called for 65536 turns does not use the turn of another block.

    The number of the current turn is then equal to the number of its own turn.
    """
    plc = _plc()
    plc.change("First.Execute", to=True)
    assert _pins(plc, "First") == "Busy Active"
    plc.change("First.Execute", "CallFirst", to=False)
    for name in ("Serving", "NextTicket", "Lowest"):
        plc[f"Robot.Inner.Command.{name}"] = 0
    plc.change("Second.Execute", to=True)
    plc.change("CallFirst", to=True)
    assert plc["First.ErrorID"] == 0x8013
    assert _pins(plc, "Second") == "Busy Active"
    assert plc["Robot.Inner.Command.Serving"] == 0


def test_the_time_limit_counts_from_the_turn_not_from_the_queue() -> None:
    plc = _plc()
    plc["Second.Timeout"] = "T#100ms"
    plc.change("First.Execute", "Second.Execute", to=True, scans=100)
    assert _pins(plc, "Second") == "Busy"
    _finish(plc)
    plc.scan(9)
    assert _pins(plc, "Second") == "Busy Active"
    plc.scan(2)
    assert plc["Second.ErrorID"] == 0x8011


def test_timeout_zero_is_no_limit() -> None:
    plc = _plc()
    plc["First.Timeout"] = "T#0s"
    plc.change("First.Execute", to=True, scans=2000)
    assert _pins(plc, "First") == "Busy Active"


def test_link_loss_ends_the_waiting_blocks_too() -> None:
    plc = _plc()
    for block in ("First", "Second", "ServoOn"):
        plc[f"{block}.Execute"] = True
    plc.scan(2)
    plc.change("Connected", to=False)
    assert [plc[f"{b}.ErrorID"] for b in ("First", "Second", "ServoOn")] == [0x8001] * 3
    plc.change("Connected", to=True, scans=60)
    assert plc.words[0] == 0
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Third.Execute", to=True, scans=4)
    assert plc.words[0] == 0x0503, "abandoned tickets do not stop the channel"


def _job(**inputs: object) -> Alone:
    """Return an FB_RcxJob after its first call with Execute TRUE."""
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    for name, value in {**inputs, "Execute": True}.items():
        job[f"Block.{name}"] = value
    job.scan(0)
    assert job["Block.Busy"] is True
    return job


@pytest.mark.parametrize(("ahead", "taken"), [(0, 1), (32_766, 1), (32_767, 0)])
def test_a_job_takes_no_ticket_more_than_32767_ahead(ahead: int, taken: int) -> None:
    """Source: head of FC_RcxTickets: tickets in use are never more than 32767 apart."""
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    job["Channel.NextTicket"] = job["Channel.Lowest"] = ahead
    job["Block.Execute"] = True
    job.scan(0)
    job.scan(10)
    assert job["Block.Busy"] is True
    assert job["Channel.NextTicket"] == ahead + taken
    job["Channel.Serving"] = ahead
    job.scan(20)
    job.scan(30)
    assert job["Block.Active"] is True
    assert job["Channel.NextTicket"] == ahead + 1


def test_a_ticket_is_shown_for_a_scan_before_it_is_passed_on() -> None:
    """A job shows its ticket for one scan before it passes it on, even if it ends at once.

    FB_WriteArea would release a ticket that it has never seen. An example is a block that waits for
    other blocks before it can take its ticket.
    """
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    job["Channel.NextTicket"] = job["Channel.Lowest"] = 32_767
    job["Block.Execute"] = True
    job.scan(0)
    assert job["Channel.NextTicket"] == 32_767
    job["Block.Trouble"], job["Block.Settled"] = 0x8003, True
    job["Channel.Serving"] = 32_767
    job["Channel.Lowest"] = 32_800  # another value of the last FB_WriteArea
    job.scan(10)
    assert job["Block.Busy"] is job["Block.Active"] is True
    assert job["Block.Request"] is False
    assert job["Channel.Lowest"] == job["Channel.Serving"] == 32_767
    job.scan(20)
    assert job["Block.ErrorID"] == 0x8003
    assert job["Channel.Serving"] == 32_768


@pytest.mark.parametrize("answer", [0x8001, 0x8002])
def test_a_loss_of_one_scan_ends_a_job_that_could_take_its_ticket_in_that_scan(answer: int) -> None:
    """If the link is lost for one scan, a job that could take its ticket in that scan ends.

    Example: an emergency stop refuses a jog. When the link is lost, this reason disappears.
    """
    job = _job(Remote=True, Trouble=0x8003)
    assert job["Channel.NextTicket"] == 0, "a command that is refused takes no ticket"
    job["Block.Trouble"], job["Block.Answer"] = 0, answer
    job.scan(10)
    assert (job["Block.ErrorID"], job["Channel.NextTicket"]) == (answer, 0)
    job["Block.Answer"] = 0
    job.scan(20)
    job.scan(30)
    assert job["Block.Busy"] is job["Block.Request"] is False, "Execute is still TRUE: no new edge"
    begun = _job(Answer=answer)
    assert begun["Channel.NextTicket"] == 1, "a job that starts in such a scan is in the queue"


@pytest.mark.parametrize(("ahead", "live"), [(10, True), (32_767, True), (32_768, False)])
def test_a_ticket_is_valid_up_to_32767_ahead_and_passed_beyond(ahead: int, live: bool) -> None:
    """Source: head of FC_RcxTickets: from 32768 on Last is the earlier ticket."""
    job = _waiting()
    serving = 40_000 - ahead
    channel = {"Serving": serving, "NextTicket": serving + 10, "Lowest": 40_005}
    job["Channel"] = channel
    job.scan(10)
    assert job["Channel.NextTicket"] == serving + (10 if live else 11)
    full = _waiting()
    full["Channel"] = channel | {"NextTicket": (serving + 32_767) % 65_536}
    full.scan(10)
    assert full["Channel.NextTicket"] == (serving + 32_767) % 65_536
    assert full["Channel.Lowest"] == (40_000 if live else 40_005)


@pytest.mark.parametrize(("later", "shown"), [(1, True), (32_767, True), (32_768, False)])
def test_lowest_shows_a_ticket_that_is_earlier_by_up_to_32767(later: int, shown: bool) -> None:
    """A waiting job writes its ticket to Lowest if it is earlier, by up to 32767.

    Source: head of FC_RcxTickets.
    """
    job = _waiting()
    job["Channel.Lowest"] = lowest = (40_000 + later) % 65_536
    job.scan(10)
    assert job["Channel.Lowest"] == (40_000 if shown else lowest)


def _waiting() -> Alone:
    """Return a job with ticket 40000 that waits behind the holder of the channel."""
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    job["Channel"] = {"Serving": 39_999, "NextTicket": 40_000, "Lowest": 39_999}
    job["Block.Execute"] = True
    job.scan(0)
    assert (job["Block.Busy"], job["Block.Active"]) == (True, False)
    assert job["Channel.NextTicket"] == 40_001
    return job


def test_two_calls_in_a_scan_end_a_job_that_waits_or_works_but_not_an_idle_job() -> None:
    """If an idle job is called twice in a scan, it may start; a waiting or running job ends.

    The channel is not passed on, because the command may be on the wire.

    Source: errors.md, 16#8016.
    """
    idle = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    _twice(idle)
    assert (idle["Block.ErrorID"], idle["Block.Error"]) == (0, False)
    idle["Block.Execute"] = True
    idle["Block.Scan"] = 0
    idle.scan(20)
    assert idle["Block.Active"] is True
    for job, serving in ((_waiting(), 39_999), (_job(), 0)):
        job["Block.Scan"] = 0
        job.scan(10)
        assert (job["Block.ErrorID"], job["Block.Error"]) == (0x8016, True)
        assert job["Block.Busy"] is job["Block.Active"] is job["Block.Request"] is False
        assert job["Channel.Serving"] == serving


def _twice(job: Alone) -> None:
    """Call the job twice with the same scan number."""
    for now in (0, 10):
        job["Block.Scan"] = 0
        job.scan(now)


@pytest.mark.parametrize("scan", [0, 2, 3, 65_535])
def test_a_job_that_was_not_called_in_the_last_scan_has_lost_its_turn(scan: int) -> None:
    """If a job was not called in the last scan, it has lost the channel.

    Scan numbers increase by 1. If the reference is another robot, its number may be lower.
    """
    job = _job()
    assert job["Block.Scan"] == 1
    job["Block.Scan"] = (scan - 1) % 65_536
    job.scan(10)
    assert job["Block.ErrorID"] == (0 if scan == 2 else 0x8013)


@pytest.mark.parametrize("ticket", [0, 65_535])
def test_a_turn_that_has_gone_to_the_next_ticket_is_lost(ticket: int) -> None:
    """If the channel has passed to the next ticket, the job ends with 16#8013.

    Ticket numbers restart at 0 after 65535.
    """
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    job["Channel"] = {"Serving": ticket, "NextTicket": ticket, "Lowest": ticket}
    job["Block.Execute"] = True
    job.scan(0)
    assert job["Block.Active"] is True
    job["Channel.Serving"] = (ticket + 1) % 65_536
    job["Channel.NextTicket"] = (ticket + 2) % 65_536
    job.scan(10)
    assert job["Block.ErrorID"] == 0x8013


@pytest.mark.parametrize(("field", "value"), [("Serving", 1), ("Orphan", True)])
def test_a_turn_that_was_taken_away_is_lost(field: str, value: int) -> None:
    """If FB_WriteArea has released the ticket of a job, the job ends with 16#8013.

    FB_WriteArea releases it if the block is not called before FB_WriteArea.
    """
    job = _job()
    assert job["Block.Active"] is True
    job["Channel.NextTicket"] = 2
    job[f"Channel.{field}"] = value
    job.scan(10)
    assert job["Block.ErrorID"] == 0x8013
    assert job["Block.Active"] is job["Block.Request"] is False
    assert job["Channel.Serving"] == (1 if field == "Serving" else 0)


def test_a_limit_of_one_millisecond_is_a_limit() -> None:
    """Source: head of FB_RcxJob: only ticket 0 means that there is no ticket."""
    job = _job(Longest=1, Elapsed=1)
    assert job["Block.Request"] is True
    job.scan(1)
    assert job["Block.ErrorID"] == 0x8010
    assert job["Block.Request"] is False


@pytest.mark.parametrize(("answer", "asked"), [(0, True), (0x8001, False), (0x8002, False)])
def test_nothing_is_requested_without_a_controller(answer: int, asked: bool) -> None:
    """Source: manual chapter 1, 5.2, and chapter 5, 2, SO(01)."""
    job = _job(Answer=answer)
    assert job["Block.Request"] is asked
    job.scan(10)
    assert job["Block.ErrorID"] == answer


@pytest.mark.parametrize("remote", [False, True])
def test_a_remote_command_is_requested_until_it_is_on_the_wire(remote: bool) -> None:
    """A remote command is requested until it is on the wire, a dedicated input until its answer.

    Source: manual chapter 4, 2.1, and chapter 5, 3.
    """
    job = _job(Remote=remote)
    assert job["Block.Request"] is True
    job["Block.Applied"] = True
    job.scan(10)
    assert job["Block.Busy"] is True
    assert job["Block.Request"] is not remote


def test_an_earlier_request_on_the_wire_is_ignored() -> None:
    """A job ignores an earlier request that is still on the wire.

    An alarm or fault ends the job only if its own request is on the wire.

    Source: manual chapter 5, 3: each process begins with an edge of its input.
    """
    job = _job(Applied=True, Trouble=0x8004)
    for now, applied in ((10, True), (20, False)):
        job["Block.Applied"] = applied
        job.scan(now)
        assert job["Block.Busy"] is True
    job["Block.Applied"] = True
    job.scan(30)
    assert job["Block.ErrorID"] == 0x8004


def test_while_an_earlier_command_is_on_the_wire_the_next_one_does_not_begin() -> None:
    """While an earlier code is on the wire, the next command does not begin.

    The job ends while this code, to which the status belongs, is still sent.

    Source: manual chapter 4, 2.1; head of FB_RcxJob.
    """
    job = _job(Remote=True, Applied=True, Answer=0x0200)
    job.scan(10)
    assert job["Block.Busy"] is True
    job["Block.Trouble"] = 0x8004
    job.scan(20)
    assert job["Block.ErrorID"] == 0x8004
    assert job["Channel.Orphan"] is True
    assert job["Channel.Serving"] == 0


_CHANNEL = ("NextTicket", "Serving", "Lowest", "Orphan", "Holder")


def _out_of_place(job: Alone) -> list[object]:
    """Call the job outside of the area blocks, and check that it has not changed the channel."""
    before = [job[f"Channel.{name}"] for name in _CHANNEL]
    job["Placed"] = False
    job.scan(100)
    shown = [job[f"Block.{pin}"] for pin in ("Busy", "Active", "Done", "Request", "Error")]
    assert shown == [False, False, False, False, True]
    assert job["Block.ErrorID"] == 0x8017
    assert [job[f"Channel.{name}"] for name in _CHANNEL] == before
    return before


@pytest.mark.parametrize("remote", [False, True])
def test_a_job_that_begins_out_of_place_ends_in_that_call_without_a_ticket(remote: bool) -> None:
    """Source: docs/reference/errors.md, 16#8017."""
    job = Alone("FB_RcxJob", {"Channel": "RCX_CHANNEL"})
    job["Block.Remote"], job["Block.Execute"] = remote, True
    assert _out_of_place(job)[0] == 0
    job["Placed"] = True
    job.scan(110)
    assert job["Block.ErrorID"] == 0x8017, "there was no new edge"
    job["Block.Execute"] = False
    job.scan(120)
    job["Block.Execute"] = True
    job.scan(130)
    assert job["Block.Busy"] is job["Block.Request"] is True


@pytest.mark.parametrize("remote", [False, True])
@pytest.mark.parametrize("serving", [0, 65_535], ids=["its turn", "it waits"])
@pytest.mark.parametrize(("applied", "answer"), [(False, 0), (True, 0), (True, 0x0200)])
def test_a_job_called_out_of_place_does_not_pass_the_channel_on(
    remote: bool, serving: int, applied: bool, answer: int
) -> None:
    """A job called outside of the area blocks does not pass the channel on.

    Only FB_WriteArea does this, because it writes the telegram.

    Source: errors.md, 16#8017.
    """
    job = _job(Remote=remote)
    job["Channel.Serving"] = serving
    job["Block.Active"] = serving == 0
    job["Block.Applied"], job["Block.Answer"] = applied, answer
    _out_of_place(job)


@pytest.mark.parametrize("error", [0x8001, 0x8003])
def test_out_of_place_comes_before_every_other_error(error: int) -> None:
    """Source: docs/reference/errors.md, 16#8017: the call has to be moved first."""
    job = _job(Remote=True)
    job["Block.Answer"] = job["Block.Trouble"] = error
    _out_of_place(job)
