"""FB_ChannelStatus shows the block that holds a channel, for how long, and how many blocks wait."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES
from plc_bench import ROOT, PlcBench


class Channels:
    """A program with FB_ChannelStatus alone, called every 10 ms."""

    def __init__(self) -> None:
        self._alone = _alone()
        self._alone.restart()
        self._now_ms = 0

    def __setitem__(self, path: str, value: Any) -> None:
        self._alone[path] = value

    def __getitem__(self, path: str) -> Any:
        return self._alone[f"Block.{path}"]

    def scan(self, count: int = 1, *, after_ms: int = 10) -> None:
        """Run scans."""
        for _ in range(count):
            self._now_ms += after_ms
            self._alone["Robot.Inner.Elapsed"] = after_ms
            self._alone.scan(self._now_ms)

    def change(self, path: str, *, to: Any, scans: int = 1) -> None:
        """Write a value to a variable, then run `scans` scans."""
        self[path] = to
        self.scan(scans)


@cache
def _alone() -> Alone:
    return Alone("FB_ChannelStatus", {"Robot": "RCX_REF"})


_BOTH = pytest.mark.parametrize("channel", ["Command", "Sequence"])


@_BOTH
def test_a_free_channel_has_no_holder_and_nobody_waits(channel: str) -> None:
    block = Channels()
    block[f"Robot.Inner.{channel}.Serving"] = 7
    block.change(f"Robot.Inner.{channel}.NextTicket", to=7, scans=3)
    assert not any(block[channel].values())


@_BOTH
def test_a_turn_is_counted_from_the_scan_in_which_it_is_first_seen(channel: str) -> None:
    block = Channels()
    block.scan(5)
    block[f"Robot.Inner.{channel}.NextTicket"] = 1
    block[f"Robot.Inner.{channel}.Holder"] = 0x0012
    for held in (0, 10, 20):
        block.scan()
        turn = block[channel]
        assert (turn["Taken"], turn["Holder"], turn["Held"]) == (True, 0x0012, held)
    block[f"Robot.Inner.{channel}.Serving"] = 1
    block.change(f"Robot.Inner.{channel}.Holder", to=0)
    turn = block[channel]
    assert (turn["Taken"], turn["Holder"], turn["Held"]) == (False, 0, 0)
    assert (turn["Longest"], turn["LongestHolder"]) == (20, 0x0012)


@_BOTH
def test_a_turn_that_never_ends_stays_stuck(channel: str) -> None:
    """A turn that never ends is Stuck, and its time is limited to less than 2^31 - 1 ms.

    Some PLCs store TIME in a DINT, so a larger value would overflow.
    """
    block = Channels()
    block.change(f"Robot.Inner.{channel}.NextTicket", to=1, scans=2)
    block[f"Block.{channel}Channel.Turn.Held"] = 2_147_390_000
    block.scan(3, after_ms=65_000)
    assert block[channel]["Stuck"]
    assert block[channel]["Held"] == 2_147_390_000 + 65_000


@pytest.mark.parametrize(
    ("stored_ms", "shown_ms"), [(2_147_399_999, 2_147_400_009), (2_147_400_000, 2_147_400_000)]
)
@_BOTH
def test_the_time_of_a_turn_stops_at_its_limit(channel: str, stored_ms: int, shown_ms: int) -> None:
    """The shown time of a turn stops at its limit, even after a reset of the longest turn.

    Source: head of RCX_TURN, 24 days.
    """
    block = Channels()
    block[f"Robot.Inner.{channel}.NextTicket"] = 1
    block.change("Block.Reset", to=True, scans=2)
    block.change(f"Block.{channel}Channel.Turn.Held", to=stored_ms)
    assert (block[channel]["Held"], block[channel]["Longest"]) == (shown_ms, 0)


@_BOTH
def test_the_next_turn_begins_at_zero_also_without_a_pause(channel: str) -> None:
    block = Channels()
    block.change(f"Robot.Inner.{channel}.NextTicket", to=2, scans=4)
    assert block[channel]["Held"] == 30
    block.change(f"Robot.Inner.{channel}.Serving", to=1)
    assert block[channel]["Held"] == 0
    block.scan()
    assert block[channel]["Held"] == 10
    assert block[channel]["Longest"] == 30


def test_a_turn_that_comes_after_a_pause_begins_at_zero() -> None:
    """A turn after a pause begins at 0 ms, although the free channel has the same ticket number."""
    block = Channels()
    block.scan(10)
    block.change("Robot.Inner.Command.NextTicket", to=1)
    assert block["Command"]["Held"] == 0


@_BOTH
@pytest.mark.parametrize(
    ("serving", "following", "waiting"),
    [(0, 1, 0), (0, 4, 3), (65535, 0, 0), (65534, 2, 3), (5, 5, 0)],
)
def test_waiting_counts_the_tickets_after_the_holder(
    channel: str, serving: int, following: int, waiting: int
) -> None:
    """Waiting counts the tickets after the holder's ticket; 0 follows 65535.

    Source: RCX_CHANNEL.
    """
    block = Channels()
    block[f"Robot.Inner.{channel}.Serving"] = serving
    block.change(f"Robot.Inner.{channel}.NextTicket", to=following)
    assert block[channel]["Waiting"] == waiting
    other = "Sequence" if channel == "Command" else "Command"
    assert block[other]["Waiting"] == 0


@_BOTH
def test_if_all_blocks_end_in_one_scan_no_block_waits(channel: str) -> None:
    """If the link is lost and all blocks end in one scan, no block holds the channel or waits."""
    block = Channels()
    block.change(f"Robot.Inner.{channel}.NextTicket", to=3)
    assert block[channel]["Waiting"] == 2
    block.change(f"Robot.Inner.{channel}.Serving", to=3)
    assert (block[channel]["Taken"], block[channel]["Waiting"]) == (False, 0)


@_BOTH
def test_ticket_0_after_65535_is_a_new_turn(channel: str) -> None:
    """Ticket 0 after ticket 65535 begins a new turn with time 0. Source: RCX_CHANNEL."""
    block = Channels()
    block[f"Robot.Inner.{channel}.Serving"] = 65535
    block.change(f"Robot.Inner.{channel}.NextTicket", to=1, scans=3)
    assert block[channel]["Held"] == 20
    block.change(f"Robot.Inner.{channel}.Serving", to=0)
    assert block[channel]["Held"] == 0


@_BOTH
@pytest.mark.parametrize("limit", [1, 29, 30])
def test_a_turn_above_its_limit_is_stuck(channel: str, limit: int) -> None:
    block = Channels()
    block[f"Block.{channel}Limit"] = limit
    block.change(f"Robot.Inner.{channel}.NextTicket", to=1)
    block.scan(after_ms=limit)
    assert block[channel]["Held"] == limit
    assert not block[channel]["Stuck"]
    assert not block["Stuck"]
    block.scan()
    assert block[channel]["Stuck"]
    assert block["Stuck"]
    other = "Sequence" if channel == "Command" else "Command"
    assert not block[other]["Stuck"]
    block.change(f"Robot.Inner.{channel}.Serving", to=1)
    assert not block[channel]["Stuck"]
    assert not block["Stuck"]


@_BOTH
@pytest.mark.parametrize(("limit", "stuck"), [(None, True), (0, False)])
def test_the_default_limit_is_a_minute_and_zero_means_no_limit(
    channel: str, limit: int | None, stuck: bool
) -> None:
    block = Channels()
    if limit is not None:
        block[f"Block.{channel}Limit"] = limit
    block.change(f"Robot.Inner.{channel}.NextTicket", to=1)
    block.scan(2, after_ms=30_000)
    assert block[channel]["Held"] == 60_000
    assert not block["Stuck"]
    block.scan(after_ms=1)
    assert block["Stuck"] is stuck


@_BOTH
def test_the_longest_turn_is_kept_until_reset(channel: str) -> None:
    block = Channels()
    for serving, holder, scans in ((0, 0x0001, 3), (1, 0x0012, 6), (2, 0x0015, 6)):
        block[f"Robot.Inner.{channel}.Serving"] = serving
        block[f"Robot.Inner.{channel}.NextTicket"] = serving + 1
        block.change(f"Robot.Inner.{channel}.Holder", to=holder, scans=scans)
    assert (block[channel]["Longest"], block[channel]["LongestHolder"]) == (50, 0x0012)
    block.change("Block.Reset", to=True)
    assert (block[channel]["Longest"], block[channel]["LongestHolder"]) == (0, 0)
    block.change("Block.Reset", to=False)
    assert (block[channel]["Longest"], block[channel]["LongestHolder"]) == (70, 0x0015)


@pytest.mark.parametrize("engine", ENGINES)
def test_commands_take_turns_and_a_command_without_its_block_is_an_orphan(engine: str) -> None:
    """Commands run one after the other. If the program stops calling a busy block, Orphan is TRUE.

    Source: guide chapter 2: a command is held to its end.
    """
    plc = PlcBench(program=ROOT / "tests/data/library/Diagnosis.st", engine=engine, contract=False)
    plc.power_up()
    for name, code in (("Command", 0x1001), ("Second", 0x0505), ("Third", 0x0506)):
        plc[f"{name}.Code"] = code
        plc[f"{name}.Execute"] = True
    plc.scan(3)
    turn = plc["Channels.Command"]
    assert (turn["Taken"], turn["Holder"], turn["Waiting"]) == (True, 0x1001, 2)
    assert not turn["Orphan"]
    plc.answer(0x0100)
    plc.change("CallCommand", to=False, scans=2)
    assert plc["Channels.Command.Orphan"]
    assert plc["Channels.Command.Held"] == 40
    plc.answer(0x0200, scans=2)
    assert not plc["Channels.Command.Orphan"]
    assert plc["Channels.Command.Waiting"] == 1
    assert not plc["Channels.Sequence.Taken"]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_sequence_is_shown_and_logged_by_its_dedicated_input(
    engine: str,
) -> None:
    """During servo on, the status shows SI(01); the log has the steps SI(01), SO(02), SI(01).

    Source: manual chapter 5, 3.1.
    """
    plc = PlcBench(program=ROOT / "tests/data/library/Diagnosis.st", engine=engine)
    plc.power_up()
    plc.change("ServoOn.Execute", to=True, scans=14)
    turn = plc["Channels.Sequence"]
    assert (turn["Taken"], turn["Holder"], turn["Waiting"]) == (True, 0x0001, 0)
    plc.outputs(SO02=True, scans=16)
    rows = [(row["Kind"], row["Number"], row["Result"]) for row in plc["Recorder.Rows"]]
    assert rows[:3] == [("LOG_INPUT", 1, 0), ("LOG_OUTPUT", 2, 1), ("LOG_INPUT", 1, 1)]
    assert not plc["Channels.Sequence.Taken"]
    assert not plc["Channels.Command.Taken"]


@pytest.mark.parametrize("engine", ENGINES)
def test_a_command_that_ends_abnormally_is_logged_with_the_error_of_its_block(
    engine: str,
) -> None:
    """The log has the same alarm and error as the block. Source: guide chapters 1 and 2."""
    plc = PlcBench(program=ROOT / "tests/data/library/Diagnosis.st", engine=engine)
    plc.power_up()
    plc["Command.Code"] = 0x1001
    plc["Command.Data"] = [4, 0, 50, 19, *[0] * 11]
    plc.change("Command.Execute", to=True, scans=2)
    assert plc.words[0] == 0x1001
    assert (plc["Recorder.Code"], plc["Recorder.Running"]) == (0x1001, 0)
    plc.answer(0x0100, scans=5)
    assert plc["Recorder.Running"] == 50
    plc.answer(0x4000, [2, 334], scans=1)
    command, error = plc["Recorder.Rows"][1], plc["Recorder.Rows"][0]
    assert (command["Number"], command["Result"]) == (0x1001, 0x4000)
    assert (command["Group"], command["Category"], command["Duration"]) == (2, 334, 60)
    assert (error["Kind"], error["Result"]) == ("LOG_ERROR", 0x8020)
    assert plc["Recorder.Fault"] == command
    assert plc["Recorder.FaultData"][:4] == [4, 0, 50, 19]
