"""All engines give the same trace: in each scan, every variable has the same value."""

from __future__ import annotations

import pytest
from probes import Probe, differences, language_probes, recorded_trace, trace

from both_engines import needs
from structured_text.engines.load import build
from structured_text.engines.matiec.faults import places
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.source import in_dialect

PROBES = [pytest.param(probe, id=probe.name) for probe in language_probes()]


@pytest.mark.parametrize("probe", PROBES)
def test_the_built_in_engine_gives_the_trace_recorded_from_matiec(probe: Probe) -> None:
    """The built-in engine uses the dialect of tools that compile with matiec."""
    files = [in_dialect(file, "openplc") for file in probe.files]
    program = build(files, "builtin").program
    assert differences(recorded_trace(probe), trace(program, probe)) == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("probe", PROBES)
def test_plain_structured_text_differs_from_matiec_only_in_counters_that_are_reported(
    probe: Probe,
) -> None:
    """Standard ST differs from matiec's trace only in counters, which `places` reports as faults.

    Source: engines/matiec/faults.toml, counters.
    """
    program = build(probe.files, "builtin").program
    found = differences(recorded_trace(probe), trace(program, probe))
    reported = {place.fault.name for place in places(load(list(probe.files)))}
    assert bool(found) is ("counters" in reported), found
    assert bool(found) is probe.name.startswith("counter")


@needs("matiec")
@pytest.mark.parametrize("probe", PROBES)
def test_the_recorded_trace_is_what_matiec_gives_today(probe: Probe) -> None:
    program = build(probe.files, "matiec").program
    assert differences(recorded_trace(probe), trace(program, probe)) == []


#: Programs that STruC++ 0.6.1 refuses or runs differently (docs/reference/engines.md), with the
#: reason.
STRUCPP = {"array_dimensions": "no index of three dimensions",
           "arrays": "no initial value of an ARRAY", "blocks": "VAR_TEMP keeps its value",
           "comparisons": "no STRING beside a literal with < and >",
           "counter_types": "CTD and CTUD count down on the falling edge",
           "counters": "CTD and CTUD count down on the falling edge",
           "dates": "no initial value of a DATE", "division": "MOD 0 is a fault",
           "enumerations": "no initial value of an enumeration's type",
           "initial_values": "no initial value of a type",
           "literals": "literals with underscores and signs",
           "precedence": "no comparison of a comparison",
           "selection": "no MUX of literals and variables", "strings": "no CONCAT of three",
           "structures": "no initial value of a structure",
           "time_arithmetic": "no negative literal of TIME"}  # fmt: skip


@needs("strucpp")
@pytest.mark.parametrize("probe", PROBES)
def test_strucpp_gives_the_trace_recorded_from_matiec(probe: Probe) -> None:
    try:
        program = build(probe.files, "strucpp").program
        found = differences(recorded_trace(probe), trace(program, probe))
    except InputError as error:
        found = [str(error)]
    if found and probe.name in STRUCPP:
        pytest.xfail(STRUCPP[probe.name])
    assert found == []


def test_a_difference_is_reported_with_scan_variable_and_both_values() -> None:
    expected = ['{"head": 1}', '{"Main.A": 0, "Main.B": 0}', '{"Main.A": 1}', '{"Main.A": 2}']
    got = ['{"head": 1}', '{"Main.A": 0, "Main.B": 0}', '{"Main.A": 1}', '{"Main.B": true}']
    assert differences(expected, got) == [
        'scan 1: Main.A expected 2, got "as before"',
        'scan 1: Main.B expected "as before", got true',
    ]


def test_every_probe_has_a_trace_in_which_something_happens() -> None:
    probes = language_probes()
    assert len(probes) >= 25
    for probe in probes:
        lines = recorded_trace(probe)
        assert len(lines) == probe.scans + 2, probe.name
        assert sum(line != "{}" for line in lines[2:]) >= 3, probe.name
