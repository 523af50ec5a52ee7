"""Each of the 116 commands has an effect that a later command or the controller shows."""

from __future__ import annotations

import pytest

from rcx_harness.robot.commands import Call, Execution, Response
from rcx_harness.robot.commands import start as true_start
from rcx_harness.robot.commands.base import registered
from rcx_harness.robot.machine import Machine
from rcx_harness.spec import commands
from round_trip import Trip, run_trip
from round_trips_data import DATA_TRIPS
from round_trips_motion import MOTION_TRIPS

TRIPS = (*MOTION_TRIPS, *DATA_TRIPS)
CODES = [code for code in commands() if code]
#: Commands with one round trip, because their data never change or they have only one outcome.
ONE_OUTCOME = {0x041, 0x042, 0x043, 0x501, 0x502, 0x513, 0x604}

every_code = pytest.mark.parametrize("code", CODES, ids="0x{:03X}".format)


def _trips(code: int) -> list[Trip]:
    return [trip for trip in TRIPS if trip.code == code]


def test_each_of_the_116_codes_is_known_and_has_its_round_trips() -> None:
    """Each code has two round trips with different values, except codes with only one outcome.

    Source: remote command guide 4.2 to 4.9
    """
    assert len(CODES) == 116
    assert registered() == CODES
    assert {trip.code for trip in TRIPS} == set(CODES)
    outcomes = {code: {str(trip.expected) for trip in _trips(code)} for code in CODES}
    assert {code for code, found in outcomes.items() if len(found) == 1} == ONE_OUTCOME


@every_code
def test_the_effect_of_the_command_is_found_afterwards(code: int) -> None:
    """Source: remote command guide 4.2 to 4.9."""
    for trip in _trips(code):
        assert run_trip(trip) == trip.expected


class _Nothing(Execution):
    """A stand-in for a command: it ends normally at once and has no effect."""

    def step(self, machine: Machine) -> Response | None:
        return {}


@every_code
def test_a_round_trip_fails_without_its_command(code: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without its command, a round trip does not show the expected effect."""

    def start(machine: Machine, call: Call) -> Execution:
        return _Nothing() if call.code == code else true_start(machine, call)

    monkeypatch.setattr("rcx_harness.robot.handshake.start", start)
    found = [run_trip(trip) == trip.expected for trip in _trips(code)]
    assert not all(found)
