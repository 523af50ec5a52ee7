"""The fault campaign of the library is run briefly, and detects seeded faults."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.link import PacketNetwork
from rcx_harness.cell.stimulus import Entry
from rcx_harness.trace import Record, Scan
from rcx_harness.verify.storm.shrink import shrink
from rcx_harness.verify.storm.storms import Failure, Storm
from rcx_tools.evidence.broken import broken_library
from rcx_tools.evidence.campaign.judge import Judge
from rcx_tools.evidence.campaign.requests import Request
from rcx_tools.evidence.campaign.run import compiled as compiled_campaign
from rcx_tools.evidence.campaign.run import run_storms
from rcx_tools.evidence.campaign.schedule import draw_run
from rcx_tools.evidence.campaign.seeded import SEEDED, find
from rcx_tools.evidence.campaign.station import Execution, Station

pytestmark = pytest.mark.exhaustive

SEEDS = range(3)
#: Broken blocks that a campaign detects at once. `make campaign` tries all of them.
QUICK = (
    "a command is sent again after its end",
    "Done without the end status",
    "an abnormal end is shown as Done",
    "the margin for the network is forgotten",
)
JOG = "a jog does not stop"
TELEGRAM = (0x0100, 0, 19, *[0] * 13)


@pytest.fixture(scope="module")
def compiled() -> Iterator[Compiled]:
    """Return the compiled program of the fault campaign."""
    found = compiled_campaign()
    yield found
    found.program.close()


@pytest.mark.exhaustive
@pytest.mark.parametrize("seed", SEEDS)
def test_after_each_series_of_faults_the_cell_works_again(compiled: Compiled, seed: int) -> None:
    """After each series of faults, the cell comes to rest and works again.

    No rule is broken, each command runs as its block says, and nothing starts by itself.
    """
    conditions, storms = draw_run(seed, 1)
    outcome = run_storms(compiled, conditions, storms, seed)
    assert outcome.storms == 1
    assert outcome.requests > 3
    assert outcome.executions > 3


@pytest.mark.exhaustive
def test_the_same_seed_is_the_same_run(compiled: Compiled) -> None:
    runs: list[list[Record]] = [[], []]
    for records in runs:
        conditions, storms = draw_run(5, 1)
        run_storms(compiled, conditions, storms, 5, listener=records.append)
    assert runs[0] == runs[1]


@pytest.mark.exhaustive(but=["Done without the end status"])
@pytest.mark.parametrize("name", QUICK)
def test_a_broken_block_is_found(name: str) -> None:
    seeded = next(one for one in SEEDED if one.name == name)
    found = find(seeded, "builtin", storms=1, most=4)
    assert found is not None
    assert found.failure.kind in seeded.kinds


def test_packets_are_lost_late_and_doubled(compiled: Compiled) -> None:
    conditions, _ = draw_run(0, 0)
    station = Station(compiled, conditions, 0)
    station.run("1s")
    for what in ("lost", "late", "doubled"):
        station.inject(f"packets_{what}", share=0.5)
    station.run("2s")
    network = station.network_of(1)
    assert isinstance(network, PacketNetwork)
    assert min(network.disturbed.values()) > 10, network.disturbed
    station.close()


def test_a_plc_that_lost_its_power_starts_anew(compiled: Compiled) -> None:
    conditions, _ = draw_run(0, 0)
    station = Station(compiled, conditions, 0)
    station.run("1s")
    scans = station.scans
    station["Main.GeneralWord"] = 77
    station.inject("plc_power_off")
    station.run("400ms")
    assert not station.plc.runs
    assert station.scans == scans
    station.inject("plc_power_on")
    station.run("400ms")
    assert station["Main.GeneralWord"] == 0
    assert station.scans > scans
    assert not station.violations
    station.close()


# --- the checks ------------------------------------------------------------------------------


def _judged(compiled: Compiled, request: Request | None, executions: list[Execution]) -> list[str]:
    found: list[str] = []
    judge = Judge(compiled.fresh(), lambda kind, text: found.append(kind))
    if request is not None:
        judge.requests.append(request)
    judge.settle(executions)
    return found


def _request(error_id: int, end_us: int | None = 200) -> Request:
    return Request("WritePoint", TELEGRAM, 100, False, end_us, error_id, {})


def _execution(t_us: int = 150, status: int = 0x0200) -> Execution:
    return Execution(t_us, TELEGRAM, (status, *[0] * 15))


def test_done_needs_exactly_one_execution(compiled: Compiled) -> None:
    assert _judged(compiled, _request(0), [_execution()]) == []
    assert _judged(compiled, _request(0), []) == ["not executed"]
    twice = [_execution(140), _execution(150)]
    assert _judged(compiled, _request(0), twice) == ["executed twice"]
    assert _judged(compiled, _request(0), [_execution(status=0x4000)]) == ["wrong end"]
    assert _judged(compiled, _request(0), [_execution(250)]) == ["not executed", "executed twice"]


def test_another_telegram_does_not_count(compiled: Compiled) -> None:
    other = Execution(150, (0x0100, 0, 20, *[0] * 13), (0x0200, *[0] * 15))
    found = _judged(compiled, _request(0), [other])
    assert found == ["not executed", "executed unasked"]


@pytest.mark.parametrize("error_id", [0x8001, 0x8002, 0x8011, 0x8013, 0x8014])
def test_an_unknown_outcome_allows_one_execution_or_none(compiled: Compiled, error_id: int) -> None:
    """Source: docs/reference/errors.md, causes and remedies."""
    assert _judged(compiled, _request(error_id), []) == []
    assert _judged(compiled, _request(error_id), [_execution(250)]) == []
    twice = [_execution(140), _execution(250)]
    assert _judged(compiled, _request(error_id), twice) == ["executed unasked"]


@pytest.mark.parametrize("error_id", [0x8012, 0x8015, 0x8044])
def test_a_command_that_was_not_sent_is_not_executed(compiled: Compiled, error_id: int) -> None:
    assert _judged(compiled, _request(error_id), []) == []
    assert _judged(compiled, _request(error_id), [_execution()]) == ["executed unasked"]


def test_an_execution_that_nobody_asked_for_is_found(compiled: Compiled) -> None:
    assert _judged(compiled, None, [_execution()]) == ["executed unasked"]


def test_a_telegram_that_no_block_asked_for_is_found(compiled: Compiled) -> None:
    found: list[str] = []
    judge = Judge(compiled.fresh(), lambda kind, text: found.append(kind))
    judge.take(Scan(0, 0, bytes(48), b"\x00\x01" + bytes(46)))
    judge.take(Scan(0, 1, bytes(48), bytes(33) + b"\x04" + bytes(14)))
    assert found == ["starts by itself"] * 2


# --- a failing run ----------------------------------------------------------------------------


@pytest.mark.exhaustive
def test_a_failing_run_is_shortened() -> None:
    """A failing run is shortened: only the actions that the failure needs remain."""
    seeded = next(one for one in SEEDED if one.name == JOG)
    with broken_library(seeded.file, seeded.old, seeded.new) as lib:
        compiled = compiled_campaign("builtin", lib)
        conditions, _ = draw_run(0, 0)
        enable = {"Main.Jog.Enable": True}
        noise = [Entry(k * 100_000, values={"Main.GeneralWord": k}) for k in range(12)]
        jog = [Entry(300_000, values=enable), Entry(900_000, values={"Main.Jog.Enable": False})]
        acts = sorted([*noise, *jog], key=lambda act: act.t_us)
        storms = [Storm(acts, 1_500_000)]
        with pytest.raises(Failure) as raised:
            run_storms(compiled, conditions, storms, 0)
        short, failure = shrink(
            lambda some: run_storms(compiled, conditions, some, 0), storms, raised.value
        )
        assert failure.kind == "jog goes on"
        assert [[act.values for act in storm.acts] for storm in short] == [[enable]], (
            "the end of a storm also ends the jog"
        )
