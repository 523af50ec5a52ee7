"""A damaged or forged trace gives one message with the line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main
from rcx_harness.trace import read_trace, records
from rcx_harness.trace.view.page import View
from structured_text.errors import InputError
from structured_text.language.displayed import check_watched, count, parts
from structured_text.language.types import ArrayType, ElementaryType, StructType
from structured_text.output.limits import MOST_TRACE_US

_HEAD: dict[str, Any] = {"format": "rcx-trace/1", "scan_us": 10_000, "cycle_us": 5_000, "size": 48}
_AREA = "00" * 48


def _trace(folder: Path, *lines: str, **head: Any) -> Path:
    file = folder / "t.jsonl"
    file.write_text("\n".join([json.dumps({**_HEAD, **head}), *lines, ""]), encoding="utf-8")
    return file


def _scan(t_us: str, more: str = "", scan: int = 1) -> str:
    return f'{{"t_us":{t_us},"scan":{scan},"so":"{_AREA}","si":"{_AREA}"{more}}}'


@pytest.mark.parametrize(
    "line",
    [
        _scan("Infinity"),
        _scan("NaN"),
        _scan("1e999"),
        _scan("-1"),
        _scan('"1"'),
        _scan("1.5"),
        _scan("true"),
        _scan("9" * 5_000),
        _scan(f"{1 << 60}"),
        _scan("1", ',"controller":Infinity'),
        _scan("1", ',"controller":0'),
        _scan("1", ',"vars":[1]'),
        _scan("1", ',"vars":' + "[" * 5_000 + "]" * 5_000),
        "[" * 100_000,
        '{"t_us":1,"scan":-Infinity}',
    ],
)
@pytest.mark.parametrize("command", ["judge", "view", "compare", "why"])
def test_a_record_without_a_time_is_refused_with_its_line(
    command: str, line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/reference/trace.md: t_us is microseconds from the start."""
    file = _trace(tmp_path, _scan("0"), line)
    more = ["-o", str(tmp_path / "page.html")] if command == "view" else []
    assert main([command, str(file), *more]) == 2
    error = capsys.readouterr().err
    assert "t.jsonl:3: not a " in error
    assert len(error) < 300


def test_a_line_without_an_end_is_read_up_to_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Source: docs/reference/limits.md, files."""
    monkeypatch.setattr(records, "MOST_LINE_BYTES", 1_000)
    file = _trace(tmp_path, _scan("0"), _scan("1", ',"more":"' + "x" * 2_000 + '"'))
    header, found = read_trace(file)
    assert header["size"] == 48
    with pytest.raises(InputError, match=r"t\.jsonl:3: a line of more than 0 MB; a trace has a"):
        list(found)


def test_a_clock_that_jumps_by_years_is_reported(tmp_path: Path) -> None:
    """Source: docs/reference/limits.md, files."""
    file = _trace(
        tmp_path,
        _scan("5"),
        _scan(f"{MOST_TRACE_US + 5}", scan=2),
        _scan(f"{MOST_TRACE_US + 6}", scan=3),
    )
    _, found = read_trace(file)
    assert next(found).t_us == 5
    assert next(found).t_us == MOST_TRACE_US + 5
    with pytest.raises(InputError, match=r"t\.jsonl:4: a time of more than 366 days"):
        next(found)


def test_array_types_in_a_header_are_counted_before_they_are_expanded(tmp_path: Path) -> None:
    """Nested arrays in a header are counted before they are expanded.

    Forty levels of arrays of two elements would be 2^40 lanes.

    Source: docs/reference/limits.md, variables that are watched.
    """
    nested: Any = "INT"
    for _ in range(40):
        nested = {"array": [[0, 1]], "of": nested}
    header, _ = read_trace(_trace(tmp_path, _scan("0"), watch={"Main.A": nested}))
    with pytest.raises(InputError, match="1,099,511,627,776 variables are watched"):
        View(header)


def test_the_values_of_a_variable_are_counted_as_they_are_created() -> None:
    """The values of a variable are counted while they are created.

    A long array counts as one value.

    Source: docs/reference/trace.md.
    """
    number = ElementaryType("INT")
    row = ArrayType("", ((0, 3), (1, 2)), number)
    whole = StructType("S", (("a", row), ("b", ArrayType("", ((0, 99),), row)), ("c", number)))
    assert count(whole) == len(list(parts("Main.S", whole))) == 8 + 1 + 1
    check_watched({"Main.S": whole})


@pytest.mark.parametrize(
    "watch",
    [
        {"Main.A": {"array": [[3, 1]], "of": "INT"}},
        {"Main.A": {"array": [["x", 1]], "of": "INT"}},
        {"Main.A": {"array": [[0, 1e999]], "of": "INT"}},
        {"Main.A": {"enum": "E", "members": {"ONE": 1e999}}},
        {"Main.A": [["INT"]]},
        {"Main.A": None},
    ],
)
def test_a_header_that_describes_no_type_is_refused(
    watch: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/reference/trace.md, the header."""
    file = _trace(tmp_path, _scan("0", ',"vars":{"Main.A":[]}'), watch=watch)
    assert main(["view", str(file), "-o", str(tmp_path / "page.html")]) == 2
    assert capsys.readouterr().err.startswith("rcx: ")


def test_a_header_as_deep_as_python_can_read_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Source: docs/reference/limits.md."""
    deep = '{"array":[[0,0]],"of":' * 300 + '"INT"' + "}" * 300
    file = tmp_path / "t.jsonl"
    head = json.dumps(_HEAD)[:-1] + f',"watch":{{"Main.A":{deep}}}}}'
    file.write_text(f"{head}\n{_scan('0')}\n", encoding="utf-8")
    assert main(["view", str(file), "-o", str(tmp_path / "page.html")]) == 2
    assert capsys.readouterr().err.startswith("rcx: ")
