"""`make contract` reports the numbers of checked calls, and its failures."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.evidence import contract

_REPORT = """<testsuites><testsuite>
  <testcase classname="tests.contract.test_every_block" name="test_the_contract_holds[FB_A]">
    <properties><property name="instances" value="7000"/><property name="scans" value="90000"/>
    </properties></testcase>
  <testcase classname="tests.contract.test_every_block" name="test_the_contract_holds[FB_B]">
    <properties><property name="instances" value="2000"/><property name="scans" value="10000"/>
    </properties>{bad}</testcase>
  <testcase classname="tests.contract.test_broken_blocks"
    name="test_a_broken_block_is_found[no end]"/>
  <testcase classname="tests.faults.test_edge_blocks"
    name="test_a_block_ends_withdraws_its_requests_and_works_again[FB_A-none]">
    <properties><property name="instances" value="{faults}"/></properties></testcase>
  <testcase classname="tests.faults.test_fault_runner"
    name="test_a_fault_in_the_library_is_found[one]">{unfound}</testcase>
</testsuite></testsuites>"""


def _report(tmp_path: Path, *, bad: str = "", unfound: str = "", faults: int = 1500) -> Path:
    file = tmp_path / "contract.xml"
    text = _REPORT.format(bad=bad, unfound=unfound, faults=faults)
    file.write_text(text, encoding="utf-8")
    return file


def test_cases_scans_and_blocks_are_counted(tmp_path: Path) -> None:
    assert contract.figures(_report(tmp_path)) == {
        "instances": 10_500,
        "instances_on_the_bench": 9000,
        "instances_on_the_virtual_controller": 1500,
        "blocks": 2,
        "scans_on_the_bench": 100_000,
        "broken_blocks": 2,
        "broken_blocks_found": 2,
        "failed": [],
    }


@pytest.mark.parametrize(
    ("bad", "unfound", "faults", "met"),
    [
        ("", "", 1500, True),
        ("<failure/>", "", 1500, False),
        ("<error/>", "", 1500, False),
        ("", "<failure/>", 1500, False),
        ("", "", 1000, False),
    ],
)
def test_a_failure_or_too_few_cases_show(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    bad: str,
    unfound: str,
    faults: int,
    met: bool,
) -> None:
    written = {}

    def run(title: str, arguments: list[str], console: object) -> tuple[int, list[str]]:
        report = _report(tmp_path, bad=bad, unfound=unfound, faults=faults)
        assert f"--junitxml={report}" in arguments
        return 0, []

    def keep(name: str, figures: object, *, met: bool) -> None:
        written[name] = met

    monkeypatch.setattr(contract, "FOLDER", tmp_path)
    monkeypatch.setattr(contract, "run_pytest", run)
    monkeypatch.setattr(contract, "write_result", keep)
    assert contract.main([]) == int(not met)
    assert written == {"contract": met}
