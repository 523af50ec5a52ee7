"""FB_ProgramCall gives a job to a robot program, which the test plays bit by bit.

The bits are SI(20), SO(20) and SO(21), and the words are SIW(2) to SIW(7) and SOW(2) to SOW(7),
unless a test says otherwise. The protocol is defined in docs/how-to/robot-program.md; the places of
bits and words are in chapter 1, 4.1 of the manual.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, PlcBench

_PROGRAM = ROOT / "tests/data/library/ProgramCall.st"
_VALUE, _WORD1, _WORD2 = -2, 0x1234, 0xABCD
#: SOW(1) to SOW(7): ticket 5 was the last one, and its job was executed.
_TICKET = 5


class Bench(PlcBench):
    """The controller in its normal state, with a robot program that waits for a job.

    Args:
        engine: The engine that runs the program.
        words: Whether the process images consist of words instead of bytes.
        size: Size of the areas [byte].
    """

    def __init__(self, engine: str = "builtin", *, words: bool = False, size: int = 48) -> None:
        text = _PROGRAM.read_text(encoding="utf-8")
        if words:
            for block in ("FB_ReadArea;", "FB_WriteArea;"):
                text = text.replace(block, f"{block[:-1]}Words;")
            text = text.replace("RCX_IMAGE;", "RCX_IMAGE_WORDS;")
            text = text.replace("FB_ProgramCall;", "FB_ProgramCallInWords;")
        super().__init__(program=text, engine=engine, size=size)
        self["Call.Size"] = size
        self.outputs(SO02=True, SO13=True)
        self.power_up()
        self["Call.JobNumber"], self["Call.Value"] = 7, _VALUE
        self["Call.Word1"], self["Call.Word2"] = _WORD1, _WORD2
        self.first = 2
        self.show(ticket=_TICKET)
        self.scan()
        self._start = self.snapshot()

    def anew(self) -> Bench:
        """Reset the bench to its initial state."""
        self.restore(self._start)
        self.first = 2
        return self

    def show(self, **shown: int) -> None:
        """Set the outputs and words of the robot program.

        Args:
            shown: ticket, outcome, value, word1, word2; acknowledged, complete (SO(20), SO(21)).
        """
        at = 2 * self.first
        for name, place, size in (
            ("ticket", 0, 2),
            ("outcome", 2, 2),
            ("value", 4, 4),
            ("word1", 8, 2),
            ("word2", 10, 2),
        ):
            if name in shown:
                number = shown[name] & (1 << 8 * size) - 1
                self.so[at + place : at + place + size] = number.to_bytes(size, "little")
        for bit, name in enumerate(("acknowledged", "complete")):
            if name in shown:
                self.so[34] = self.so[34] & ~(1 << bit) | shown[name] << bit

    @property
    def strobe(self) -> bool:
        """Return the strobe, SI(20), from the area that the block has written."""
        return bool(self.image[34] & 1)

    @property
    def ticket(self) -> int:
        """Return the ticket from the area that the block has written."""
        return self.words[3]

    @property
    def error(self) -> int:
        """Return the ErrorID of the block if Error is TRUE, else 0."""
        return int(self["Call.ErrorID"]) if self["Call.Error"] else 0

    def execute(self, **pins: int | bool) -> None:
        """Set pins, and let Execute fall and rise again."""
        for pin, value in pins.items():
            self[f"Call.{pin}"] = value
        self["Call.Execute"] = False
        self.scan()
        self["Call.Execute"] = True
        self.scan()

    def hand_over(self) -> None:
        """Start the block, and scan until the strobe is ON."""
        self.execute()
        self.scan_until(lambda: self.strobe, most=5)

    def take(self) -> None:
        """Accept the job as the robot program: show its ticket, and acknowledge."""
        self.show(ticket=self.ticket, acknowledged=1, complete=0)
        self.scan()

    def finish(self, outcome: int = 1, value: int = 0) -> None:
        """Complete the job as the robot program, and scan until the block has read the result."""
        self.show(outcome=outcome, value=value, complete=1)
        self.scan()
        self.show(acknowledged=0)
        self.scan_until(lambda: not self["Call.Busy"], most=5)


@cache
def _built(engine: str, words: bool, size: int) -> Bench:
    return Bench(engine, words=words, size=size)


def _bench(engine: str = "builtin", *, words: bool = False, size: int = 48) -> Bench:
    return _built(engine, words, size).anew()


class Row(NamedTuple):
    """Data of the robot program before a scan, and the outputs of the block after it."""

    acknowledged: int
    complete: int
    shown: int
    state: str
    pins: str
    strobe: bool
    ticket: int


#: Execute rises in the first row and falls in the second row. The rows are derived by hand from the
#: protocol: the ticket follows the shown ticket; the data are written one scan before the strobe;
#: the strobe falls with the acknowledgement; the result is read one scan after the robot program
#: has shown that it is complete, and the acknowledgement may still be ON then.
_TABLE = (
    Row(0, 0, 5, "READY", "Busy", False, 0),
    Row(0, 0, 5, "DATA", "Busy", False, 6),
    Row(0, 0, 5, "STROBE", "Busy Active Open", True, 6),
    Row(0, 0, 5, "STROBE", "Busy Active Open", True, 6),
    Row(0, 0, 6, "STROBE", "Busy Active Open", True, 6),
    Row(1, 0, 6, "WORK", "Busy Active Open", False, 6),
    Row(1, 0, 6, "WORK", "Busy Active Open", False, 6),
    Row(1, 1, 6, "RESULT", "Busy Active Open", False, 6),
    Row(1, 1, 6, "IDLE", "Done", False, 6),
    Row(0, 1, 6, "IDLE", "", False, 6),
)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("words", [False, True], ids=["bytes", "words"])
def test_each_scan_of_a_job_is_as_derived_by_hand(engine: str, words: bool) -> None:
    """In each scan of a job, the outputs are those of the rows above.

    The rows were derived by hand from the protocol. Source: docs/how-to/robot-program.md.
    """
    plc = _bench(engine, words=words)
    for number, row in enumerate(_TABLE):
        plc["Call.Execute"] = number == 0
        plc.show(acknowledged=row.acknowledged, complete=row.complete, ticket=row.shown, outcome=1)
        plc.scan()
        state = str(plc["Call.State"]).removeprefix("CALL_")
        pins = " ".join(
            pin for pin in ("Busy", "Done", "Active", "Error", "Open") if plc[f"Call.{pin}"]
        )
        assert (state, pins, plc.strobe, plc.ticket) == row[3:], f"row {number}"


@pytest.mark.parametrize("words", [False, True], ids=["bytes", "words"])
def test_the_telegram_of_a_job(words: bool) -> None:
    """The telegram of job 7 has ticket 6, SID(4) = -2, SIW(6) = 16#1234 and SIW(7) = 16#ABCD.

    SI(20) is bit 0 of n + 34, and the lower byte comes first.

    Source: chapter 1, 4.1 and 4.2.
    """
    plc = _bench(words=words)
    plc.hand_over()
    area = plc.image[:48]
    assert area[:4] == bytes(4), "no code, and SIW(1) is 0"
    assert area[4:16].hex() == "07000600feffffff3412cdab"
    assert area[16:32] == bytes(16)
    assert area[34:].hex() == "01" + 13 * "00"


def test_the_result_is_that_of_the_robot_program() -> None:
    """The result is the values of the robot program in SOD(4), SOW(6) and SOW(7).

    Source: chapter 1, 4.1; chapter 3, 2.2.
    """
    plc = _bench()
    plc.hand_over()
    plc.take()
    plc.show(word1=0xFFFF, word2=3)
    plc.finish(value=-100_000)
    assert plc["Call.Done"]
    results = [plc[f"Call.Result{name}"] for name in ("Value", "Word1", "Word2")]
    assert results == [-100_000, 0xFFFF, 3]


@pytest.mark.parametrize("words", [False, True], ids=["bytes", "words"])
def test_in_the_extended_area_a_job_does_not_wait_for_commands(words: bool) -> None:
    """With words 24 to 29, a job runs during an endless command.

    It uses SI(157), SO(70) and SO(71).
    """
    plc = _bench(words=words, size=256)
    for pin, value in {
        "FirstWord": 24,
        "StrobeBit": 157,
        "AcknowledgeBit": 70,
        "CompleteBit": 71,
    }.items():
        plc[f"Call.{pin}"] = value
    plc.give("Other", 0x0501)
    plc.first = 24
    plc.show(ticket=9)
    plc.execute()
    plc.scan(2)
    assert plc.image[48:60].hex() == "07000a00feffffff3412cdab"
    assert plc.image[45] == 0x80, "SI(157)"
    plc.show(ticket=10, outcome=1, value=4)
    plc.so[39] = 0b11
    plc.scan(3)
    assert plc["Call.Done"]
    assert plc["Call.ResultValue"] == 4
    assert plc.words[0] == 0x0501


@pytest.mark.parametrize(
    ("pins", "error"),
    [
        ({"JobNumber": 0}, 0x8044),
        ({"JobNumber": -1}, 0x8044),
        ({"StrobeBit": 18}, 0x8033),
        ({"AcknowledgeBit": 160}, 0x8033),
        ({"CompleteBit": 28}, 0x8033),
        ({"CompleteBit": 20}, 0x8033),
        ({"FirstWord": 3}, 0x8035),
        ({"FirstWord": 0}, 0x8034),
        ({"FirstWord": 12}, 0x8034),
        ({"FirstWord": 24}, 0x8036),
        ({"Size": 47}, 0x8030),
        ({"Size": 47, "CompleteBit": 20}, 0x8030),
        ({"ImageSize": 47}, 0x8031),
        ({"m": 465}, 0x8031),
        ({"n": -1}, 0x8031),
    ],
)
def test_illegal_pins_are_refused_and_nothing_is_written(pins: dict[str, int], error: int) -> None:
    """Source: docs/reference/errors.md; chapter 1, 4.1 and 4.2; SI(18), SO(160) do not exist."""
    plc = _bench()
    plc.execute(**pins)
    plc.scan()
    assert plc.error == error
    assert plc.image[4:16] + plc.image[34:48] == bytes(26)
    assert not plc["Call.Open"]


def test_in_an_image_of_words_the_area_begins_at_an_even_byte() -> None:
    """Source: docs/reference/errors.md, 16#8032."""
    plc = _bench(words=True)
    plc.execute(n=1)
    plc.scan()
    assert plc.error == 0x8032


def test_a_job_that_is_not_acknowledged_ends_after_acknowledge_timeout() -> None:
    """If a job is not acknowledged, the block ends after AcknowledgeTimeout, here 300 ms.

    Source: errors.md, 16#8080.
    """
    plc = _bench()
    plc["Call.AcknowledgeTimeout"] = "T#300ms"
    plc.execute()
    assert plc.scan_until(lambda: not plc["Call.Busy"]) == 31
    assert plc.error == 0x8080
    assert plc["Call.Open"]
    assert not plc.strobe


@pytest.mark.parametrize("shown", ["ticket 0", "acknowledged"])
def test_no_job_is_sent_to_a_program_that_is_not_ready(shown: str) -> None:
    """No job is sent to a robot program that shows no ticket or still executes a job.

    Timeout limits the wait.

    Source: errors.md.
    """
    plc = _bench()
    plc["Call.AcknowledgeTimeout"], plc["Call.Timeout"] = "T#300ms", "T#500ms"
    plc.show(**({"ticket": 0} if shown == "ticket 0" else {"acknowledged": 1}))
    plc.execute()
    waits = plc.scan_until(lambda: not plc["Call.Busy"])
    assert (waits, plc.error) == ((31, 0x8080) if shown == "ticket 0" else (51, 0x8081))
    assert not plc["Call.Open"]


def test_a_job_that_is_not_completed_ends_after_timeout_and_can_be_requested_again() -> None:
    """A job that is not completed within Timeout can be requested again, with the same ticket.

    Source: errors.md, 16#8081.
    """
    plc = _bench()
    plc["Call.Timeout"] = "T#500ms"
    plc.hand_over()
    plc.take()
    plc.scan_until(lambda: not plc["Call.Busy"])
    assert (plc.error, plc["Call.Open"]) == (0x8081, True)
    plc.show(complete=1, acknowledged=0)
    plc.hand_over()
    assert plc.ticket == 6
    plc.take()
    plc.finish(value=11)
    assert plc["Call.Done"]
    assert not plc["Call.Open"]
    assert plc["Call.ResultValue"] == 11


@pytest.mark.exhaustive
def test_without_time_limits_the_block_waits_without_end() -> None:
    """If the limits are T#0s, the block waits without an end."""
    plc = _bench()
    plc["Call.AcknowledgeTimeout"] = plc["Call.Timeout"] = "T#0s"
    plc.hand_over()
    plc.scan(7000)
    assert plc["Call.Busy"]


def test_a_stopped_program_is_shown_and_ends_the_block_only_at_the_limit() -> None:
    """If the program is stopped, the block waits with Stopped TRUE until the time limit.

    The next start of the program continues with the job. Source: 16#8082.
    """
    plc = _bench()
    plc["Call.Timeout"] = "T#500ms"
    plc.hand_over()
    plc.take()
    assert not plc["Call.Stopped"]
    plc.outputs(SO13=False, scans=20)
    assert plc["Call.Busy"]
    assert plc["Call.Stopped"]
    plc.outputs(SO13=True, scans=1)
    assert not plc["Call.Stopped"]
    plc.outputs(SO13=False, scans=1)
    plc.scan_until(lambda: not plc["Call.Busy"])
    assert plc.error == 0x8082
    assert not plc["Call.Stopped"]


@pytest.mark.parametrize(("outcome", "error"), [(2, 0x8083), (3, 0x8084), (0, 0x8084)])
def test_what_was_not_executed_is_an_error_and_the_next_job_is_a_new_one(
    outcome: int, error: int
) -> None:
    """Source: docs/reference/errors.md."""
    plc = _bench()
    plc.hand_over()
    plc.take()
    plc.finish(outcome=outcome)
    assert (plc.error, plc["Call.Open"]) == (error, False)
    plc.hand_over()
    assert plc.ticket == 7


def test_a_program_reset_during_the_job_gets_it_again_with_the_same_ticket() -> None:
    """A program that was reset during the job gets the job again with the same ticket.

    The acknowledgement is OFF, and the job is not complete. Source: 16#8083.
    """
    plc = _bench()
    plc.hand_over()
    plc.take()
    plc.show(acknowledged=0)
    plc.scan_until(lambda: plc.strobe, most=4)
    assert plc.ticket == 6
    plc.take()
    plc.finish(outcome=2)
    assert plc.error == 0x8083


def test_a_program_reset_before_its_result_was_read_gets_the_job_again() -> None:
    """If the program is reset before its result was read, the job is requested again.

    A result is read only while the program shows the job as complete.
    """
    plc = _bench()
    plc.hand_over()
    plc.take()
    plc.show(complete=1, outcome=1, value=5)
    plc.scan()
    plc.show(complete=0, acknowledged=0)
    plc.scan()
    assert plc["Call.Busy"]
    plc.scan_until(lambda: plc.strobe, most=4)
    assert plc.ticket == 6
    plc.take()
    plc.finish(value=5)
    assert plc["Call.ResultValue"] == 5


@pytest.mark.parametrize("loss", ["Connected=0", "SO01=0"])
@pytest.mark.parametrize("before", ["READY", "DATA", "STROBE", "WORK", "RESULT"])
def test_a_loss_of_one_scan_ends_the_block_and_turns_the_strobe_off(loss: str, before: str) -> None:
    """Source: docs/reference/errors.md, 16#8001 and 16#8002."""
    plc = _bench()
    plc.execute()
    for step in ("READY", "DATA", "STROBE", "WORK", "RESULT"):
        if step == before:
            break
        if step == "STROBE":
            plc.take()
        elif step == "WORK":
            plc.show(complete=1)
            plc.scan()
        else:
            plc.scan()
    assert plc["Call.State"] == f"CALL_{before}"
    plc.let(loss)
    plc.scan()
    assert plc.error == (0x8001 if "Connected" in loss else 0x8002)
    assert not plc.strobe
    assert plc["Call.Open"] is (before not in ("READY", "DATA"))


def test_another_job_is_refused_while_one_is_open_until_anew_abandons_it() -> None:
    """While a job is open, another job is refused; Anew abandons the open job.

    The ticket of the abandoned job is not used again, because the robot program may still receive
    it.

    Source: 16#8085.
    """
    plc = _bench()
    plc.hand_over()
    plc.change("Connected", to=False)
    plc["Connected"] = True
    for pins in ({"JobNumber": 8}, {"JobNumber": 7, "Value": 1}, {"Value": _VALUE, "Word1": 0}):
        plc.execute(**pins)
        plc.scan()
        assert (plc.error, plc["Call.Open"], plc.strobe) == (0x8085, True, False)
    plc.execute(Word1=_WORD1, Word2=1)
    plc.scan()
    assert plc.error == 0x8085
    plc.execute(Anew=True)
    assert not plc["Call.Open"]
    plc.scan_until(lambda: plc.strobe, most=30)
    assert plc.ticket == 7
    assert plc.words[7] == 1


def test_the_block_waits_for_a_program_that_still_has_an_abandoned_job() -> None:
    """If the program still has an abandoned job, the block waits until the program is ready.

    The program acknowledges ticket 6, so the strobe is reset meanwhile.
    """
    plc = _bench()
    plc.hand_over()
    plc.change("Connected", to=False)
    plc["Connected"] = True
    plc.execute(Anew=True)
    plc.scan_until(lambda: plc.strobe, most=30)
    plc.show(ticket=6, acknowledged=1)
    plc.scan()
    assert (plc.strobe, plc["Call.State"]) == (False, "CALL_READY")
    plc.scan(10)
    assert not plc.strobe
    plc.show(acknowledged=0, complete=1)
    plc.scan_until(lambda: plc.strobe, most=4)
    assert plc.ticket == 7


@pytest.mark.parametrize(
    ("shown", "ticket"), [(1, 2), (29_999, 30_000), (30_000, 1), (0x7FFF, 2768), (0xFFFF, 2768)]
)
def test_the_next_ticket_follows_the_shown_ticket(shown: int, ticket: int) -> None:
    """The ticket of a job follows the ticket that the robot program shows.

    Tickets are 1 to 30000, never 0. 32767 counts as 2767, and the highest bit is ignored.
    """
    plc = _bench()
    plc.show(ticket=shown)
    plc.hand_over()
    assert plc.ticket == ticket


@pytest.mark.parametrize(("given", "ticket"), [(29_999, 1), (30_000, 2)])
def test_the_ticket_of_an_abandoned_job_is_skipped(given: int, ticket: int) -> None:
    """The ticket of an abandoned job is skipped: 30000 follows 29999, but the next ticket is 1."""
    plc = _bench()
    plc.show(ticket=given)
    plc.hand_over()
    plc.change("Connected", to=False)
    plc["Connected"] = True
    plc.execute(Anew=True)
    plc.scan_until(lambda: plc.strobe, most=30)
    assert plc.ticket == ticket


def test_while_the_strobe_is_on_no_command_uses_the_shared_words() -> None:
    """While the strobe is ON, no remote command uses the shared words.

    A job also waits for the end of a command that is on the wire.

    Source: chapter 1, 4.1: shared words.
    """
    plc = _bench()
    plc.give("Other", 0x0501)
    plc.execute()
    plc.scan(10)
    assert (plc["Call.State"], plc.strobe) == ("CALL_READY", False)
    plc.answer(0x0200, scans=1)
    plc.answer(0)
    plc.show(ticket=_TICKET)
    plc["Other.Execute"] = False
    plc.scan_until(lambda: plc.strobe, most=5)
    area = plc.image[:16]
    plc["Other.Execute"] = True
    for _ in range(20):
        plc.scan()
        assert plc.image[:16] == area
    plc.take()
    plc.scan_until(lambda: plc.words[0] == 0x0501, most=5)
    plc.show(complete=1, outcome=1)
    plc.scan(10)
    assert plc["Call.State"] == "CALL_RESULT"
    plc.answer(0x0200, scans=1)
    plc.answer(0)
    plc.show(ticket=6, outcome=1, value=3)
    plc.scan_until(lambda: bool(plc["Call.Done"]), most=5)
    assert plc["Call.ResultValue"] == 3


def test_a_command_without_end_blocks_a_job() -> None:
    """Source: docs/reference/errors.md, 16#8012."""
    plc = _bench()
    plc["Call.AcknowledgeTimeout"] = "T#200ms"
    plc.give("Other", 0x0501)
    plc.execute()
    plc.scan_until(lambda: not plc["Call.Busy"])
    assert (plc.error, plc["Call.Open"]) == (0x8012, False)
    plc.complete()
    plc.scan(2)
    serving, following = plc["Robot.Inner.Command.Serving"], plc["Robot.Inner.Command.NextTicket"]
    assert serving == following


def test_a_scan_without_a_call_ends_the_job() -> None:
    """A scan without a call ends the block, because it may have lost the channel.

    Source: docs/reference/errors.md, 16#8013.
    """
    plc = _bench()
    plc.hand_over()
    plc["Called"] = False
    plc.scan()
    plc["Called"] = True
    plc.scan()
    assert (plc.error, plc["Call.Open"], plc.strobe) == (0x8013, True, False)


def test_words_beside_a_status_are_not_read() -> None:
    """While a status is shown, the words of the robot program are not read.

    SOW(2) to SOW(7) then belong to a command. The controller shows a status that was not requested.

    Source: chapter 1, 4.1: shared words.
    """
    plc = _bench()
    plc.hand_over()
    plc.show(ticket=6, acknowledged=1)
    plc.so[1] = 0x01
    plc.scan(3)
    assert (plc["Call.State"], plc.strobe) == ("CALL_STROBE", True)
    plc.so[1] = 0
    plc.scan(2)
    assert plc["Call.State"] == "CALL_WORK"
    plc.show(complete=1, outcome=1, value=8)
    plc.so[1] = 0x01
    plc.scan(3)
    assert plc["Call.State"] == "CALL_RESULT"
    plc.so[1] = 0
    plc.scan(3)
    assert plc["Call.Done"]
    assert plc["Call.ResultValue"] == 8


def test_the_result_of_another_ticket_is_ignored() -> None:
    """The result of another ticket is ignored, and the job is requested again with ticket 6.

    The robot program was restarted with other data.
    """
    plc = _bench()
    plc.hand_over()
    plc.take()
    plc.show(ticket=99, complete=1, outcome=1, value=1, acknowledged=0)
    plc.scan_until(lambda: plc.strobe, most=5)
    assert plc.ticket == 6
    plc.take()
    plc.finish(value=2)
    assert plc["Call.ResultValue"] == 2


def test_a_new_edge_of_execute_while_busy_has_no_effect() -> None:
    """A new edge of Execute while the block is Busy has no effect.

    Source: docs/reference/blocks.md.
    """
    plc = _bench()
    plc.hand_over()
    area = plc.image[:48]
    plc.execute(JobNumber=9, Value=1, Word1=2, Word2=3, Anew=True)
    assert plc.image[:48] == area
    plc.take()
    plc.finish(value=4)
    assert plc["Call.Done"]
