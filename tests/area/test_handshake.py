"""FB_RcxHandshake sends data, code, end, reset and ready in the order of the guide's chapter 2."""

from __future__ import annotations

from dataclasses import astuple, fields
from random import Random

import pytest

from alone import Alone
from head_rules import Channel, HandshakeRules
from plc_bench import PlcBench
from shown import differences

#: The example of the guide: PTP to point 19 at 50 % (n+2 = 0x0004, n+6 = 0x0032, n+8 = 0x0013).
MOVE = [0x0004, 0x0000, 0x0032, 0x0013, *[0] * 11]
IDLE = [0] * 16


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    plc["First.Code"], plc["First.Data"] = 0x0001, MOVE
    plc["Second.Code"] = 0x0501
    return plc


def test_the_six_steps_of_the_guide_in_their_order() -> None:
    """Source: guide chapter 2, steps 1 to 6."""
    plc = _plc()
    plc.change("First.Execute", to=True)
    assert plc.words == [0x0000, *MOVE], "1: command data, the code is not yet set"
    plc.scan()
    assert plc.words == [0x0001, *MOVE], "2: remote command"
    plc.answer(0x0100, scans=20)
    assert plc.words == [0x0001, *MOVE], "3: held during the run status"
    plc.answer(0x0200, [0, 0, 0, 0xE240, 0x0001], scans=1)
    assert plc["First.Done"], "4: the response is taken in the scan in which the end is seen"
    assert plc["First.Response"] == [0, 0, 0, 0xE240, 0x0001, *[0] * 10]
    assert plc.words == IDLE, "5: status reset command"
    plc.scan(20)
    assert plc["Robot.Inner.Phase"] == "PHASE_STATUS_RESET", "the status is still 0x0200"
    plc.answer(0x0000, scans=1)
    assert plc["Robot.Inner.Phase"] == "PHASE_READY", "6: ready"


def test_the_run_status_may_be_skipped() -> None:
    """Source: guide chapter 1, 1.2, code 0x0100."""
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    plc.answer(0x0200, scans=1)
    assert plc["First.Done"]


def test_the_next_command_goes_out_only_in_ready_status() -> None:
    """Source: guide chapter 1, 1.2, code 0x0000."""
    plc = _plc()
    plc.change("First.Execute", "Second.Execute", to=True, scans=2)
    plc.answer(0x0200, scans=10)
    assert plc["Second.Active"]
    assert plc.words == IDLE
    plc.answer(0x0000, scans=1)
    assert plc.words == IDLE, "data (all zero for 0x0501), code not yet"
    plc.scan()
    assert plc.words == [0x0501, *[0] * 15]


@pytest.mark.parametrize("change", ["Execute", "Code", "Data[4]", "Timeout"])
def test_code_and_data_are_held_unchanged_until_the_end(change: str) -> None:
    """Source: guide chapter 1, 1.1, note."""
    plc = _plc()
    plc.change("First.Execute", to=True, scans=3)
    plc[f"First.{change}"] = {
        "Execute": False,
        "Code": 0x0002,
        "Data[4]": 0x0063,
        "Timeout": "T#1ms",
    }[change]
    plc.answer(0x0100, scans=30)
    assert plc.words == [0x0001, *MOVE]
    assert plc["First.Busy"]


def test_a_command_whose_block_is_no_longer_called_is_held_to_its_end() -> None:
    plc = _plc()
    plc.change("First.Execute", to=True, scans=3)
    plc["CallFirst"] = False
    plc.change("Second.Execute", to=True, scans=100)
    assert plc.words == [0x0001, *MOVE]
    assert plc["Robot.Inner.Command.Orphan"]
    assert plc["Second.Busy"]
    assert not plc["Second.Active"]
    plc.answer(0x4000, [0x000C, 0x0258], scans=1)
    assert plc.words == IDLE
    plc.answer(0x0000, scans=3)
    assert plc.words == [0x0501, *[0] * 15]
    assert plc["Second.Active"]
    plc.change("CallFirst", to=True)
    assert plc["First.ErrorID"] == 0x8013
    assert plc["Second.Active"], "a late request changes nothing"


def test_data_of_a_block_that_is_no_longer_called_never_becomes_a_command() -> None:
    plc = _plc()
    plc.change("First.Execute", to=True)
    assert plc.words == [0x0000, *MOVE]
    plc.change("CallFirst", to=False)
    assert plc.words == IDLE
    plc.change("Second.Execute", to=True, scans=2)
    assert plc.words == [0x0501, *[0] * 15]


@pytest.mark.parametrize("loss", ["link", "SO01"])
def test_without_controller_the_code_is_withdrawn_and_nothing_restarts(loss: str) -> None:
    """Source: manual chapter 1, 5.2, communication is disabled; chapter 5, 2, SO(01)."""
    plc = _plc()
    plc.change("First.Execute", to=True, scans=3)
    if loss == "link":
        plc["Connected"] = False
    else:
        plc.outputs(SO01=False)
    plc.scan()
    assert plc.words == IDLE
    assert plc["First.ErrorID"] == {"link": 0x8001, "SO01": 0x8002}[loss]
    plc["Connected"] = True
    plc.outputs(SO01=True, scans=50)
    assert plc.words == IDLE
    plc.change("First.Execute", to=False)
    plc.change("First.Execute", to=True, scans=2)
    assert plc.words == [0x0001, *MOVE]


def test_after_a_recovery_the_code_stays_0_for_an_interval() -> None:
    """After a lost link, the code stays 0 for one interval (120 ms), so a packet carries this 0."""
    plc = _plc()
    plc.change("Connected", to=False)
    plc["Connected"] = True
    plc["First.Execute"] = True
    codes = []
    for _ in range(16):
        plc.scan()
        codes.append(plc.words[0])
    assert codes.index(0x0001) == 13


def test_a_status_that_falls_back_to_ready_without_an_end_is_an_error() -> None:
    """A status that returns to ready without an end status is an error.

    The controller may have restarted without a lost connection.
    """
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    plc.answer(0x0100, scans=2)
    plc.answer(0x0000, scans=1)
    assert plc["First.ErrorID"] == 0x8014
    assert plc.words == IDLE


def test_after_a_status_without_end_the_code_stays_0_for_an_interval() -> None:
    """After a status that returns to ready without an end, the code stays 0 for 120 ms."""
    plc = _plc()
    plc.change("First.Execute", to=True, scans=2)
    plc.answer(0x0100, scans=2)
    plc.answer(0x0000)
    plc["Second.Execute"] = True
    codes = []
    for _ in range(18):
        plc.scan()
        codes.append(plc.words[0])
    assert codes[0] == 0
    assert codes.index(0x0501) == 15, "12 scans from the second one on, then data, then code"


def test_a_status_without_a_command_is_reset_before_the_first_command() -> None:
    """A status without a command is reset before the first command.

    A PLC that restarts reads the end status of its last command.

    Source: guide chapter 1, 1.2, code 0x0000: the status must be ready.
    """
    plc = _plc()
    plc.answer(0x0200)
    plc.change("First.Execute", to=True, scans=30)
    assert plc.words == IDLE
    assert plc["First.Active"]
    plc.answer(0x0000, scans=2)
    assert plc.words == [0x0001, *MOVE]


def test_a_block_that_gives_up_with_its_data_out_hands_no_data_to_the_next_code() -> None:
    plc = _plc()
    plc["First.Timeout"] = "T#5ms"
    plc["Second.Data[1]"] = 0x0001
    plc.change("First.Execute", "Second.Execute", to=True)
    assert plc.words == [0x0000, *MOVE]
    plc.scan()
    assert plc["First.ErrorID"] == 0x8015
    assert plc.words == [0x0000, 0x0001, *[0] * 14], (
        "data of the second command, one scan before its code"
    )
    plc.scan()
    assert plc.words == [0x0501, 0x0001, *[0] * 14]


# --- the block alone, with random inputs ---


@pytest.fixture(scope="module")
def compiled() -> Alone:
    return Alone("FB_RcxHandshake", {"Robot": "RCX_REF"})


@pytest.fixture
def alone(compiled: Alone) -> Alone:
    compiled.restart()
    compiled["Block.Interval"] = "T#50ms"
    return compiled


_CODES = (0x0001, 0x0501, 0x0505, 0x0506, 0x3505, 0x2506, 0x0507, 0x1504)
_STATUSES = (0x0000, 0x0000, 0x0000, 0x0100, 0x0100, 0x0200, 0x4000, 0x0300, 0x8000)


@pytest.mark.parametrize(("serving", "lowest"), [(0, 1), (65535, 0)])
def test_a_continuous_output_is_ended_if_its_block_is_no_longer_called(
    alone: Alone, serving: int, lowest: int
) -> None:
    """If the block of a continuous output is no longer called, the status reset ends the output.

    The test includes the highest ticket number, after which the numbers restart.

    Source: guide 4.7.4.
    """
    alone["Robot.Connected"] = alone["Robot.SO.SO01_CpuOk"] = True
    alone["Robot.Inner.Code"], alone["Robot.Inner.Data[1]"] = 0x0505, 0x0001
    for now in (0, 50, 60):
        alone["Robot.Inner.Command"] = {"NextTicket": lowest, "Serving": serving, "Lowest": serving}
        alone["Robot.Inner.CodeRequest"] = alone["Block.SameData"] = True
        alone.scan(now)
    assert alone["Robot.Inner.Phase"] == "PHASE_COMMAND_RUN"
    alone["Robot.Status"] = 0x0100
    alone["Robot.Inner.Command.Lowest"] = lowest
    alone.scan(70)
    assert alone["Robot.Inner.Phase"] == "PHASE_STATUS_RESET"


@pytest.mark.parametrize("seed", range(6))
def test_every_step_of_the_handshake_follows_the_guide(alone: Alone, seed: int) -> None:
    """Source: guide chapters 1 and 2, and 4.7.4; design of the library, 2."""
    chance, rules = Random(seed), HandshakeRules()
    channel = Channel(next_ticket=65533, serving=65533)
    connected, cpu_ok, asked, hold, status = True, True, True, False, 0
    code, first = _CODES[0], 0
    for scan in range(1200):
        connected ^= chance.random() < (0.01 if connected else 0.2)
        cpu_ok ^= chance.random() < (0.01 if cpu_ok else 0.2)
        asked ^= chance.random() < (0.03 if asked else 0.3)
        hold ^= chance.random() < (0.2 if hold else 0.02)
        if chance.random() < 0.25:
            status = chance.choice(_STATUSES)
        if chance.random() < 0.1:
            code, first = chance.choice(_CODES), chance.choice((0x0000, 0x0001, 0x0002, 0x4001))
        if not channel.taken and chance.random() < 0.5:
            channel.next_ticket = (channel.next_ticket + chance.randint(1, 2)) % 65536
        ahead = (channel.next_ticket - channel.serving) % 65536
        seen = 0 if chance.random() < 0.9 else chance.randint(min(1, ahead), ahead)
        channel.lowest = (channel.serving + seen) % 65536
        channel.orphan = channel.orphan or chance.random() < 0.01
        channel.holder = code
        alone["Robot.Connected"], alone["Robot.SO.SO01_CpuOk"] = connected, cpu_ok
        alone["Robot.Inner.CodeRequest"], alone["Block.Hold"] = asked, hold
        alone["Robot.Status"], alone["Robot.Inner.Code"] = status, code
        alone["Robot.Inner.Data[1]"] = first
        same = chance.random() < 0.9
        alone["Block.SameData"] = same
        alone["Robot.Inner.Command"] = {
            "NextTicket": channel.next_ticket,
            "Serving": channel.serving,
            "Lowest": channel.lowest,
            "Orphan": channel.orphan,
            "Holder": channel.holder,
        }
        alone.scan(10 * scan)
        rules.scan(
            10 * scan,
            there=connected and cpu_ok,
            status=status,
            asked=asked,
            hold=hold,
            code=code,
            first=first,
            same=same,
            channel=channel,
            interval=50,
        )
        told = f"seed {seed}, scan {scan}, status 16#{status:04X}, code 16#{code:04X}"
        found = alone["Robot.Inner.Command"]
        assert isinstance(found, dict)
        names = [one.name for one in fields(Channel)]
        wrong = differences(
            ("Phase", "Running", "CodeRequest", *names),
            [alone[f"Robot.Inner.{name}"] for name in ("Phase", "Running", "CodeRequest")]
            + list(astuple(Channel.of(found))),
            [rules.phase, rules.running, False, *astuple(channel)],
        )
        assert not wrong, f"FB_RcxHandshake, {told}: {wrong}"
