"""Mutants of Python modules and of tables are created, and killed by tests."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from for_each import for_each
from rcx_tools.evidence.checks import CHECKS
from rcx_tools.evidence.mutants import __main__ as command
from rcx_tools.evidence.mutants.copies import Copies
from rcx_tools.evidence.mutants.harness import KINDS
from rcx_tools.evidence.mutants.pool import run_tasks
from rcx_tools.evidence.mutants.python import (
    PYTHON_OPERATORS,
    concerned,
    file_key,
    function_at,
    functions,
    python_changes,
    python_meaning,
)
from rcx_tools.evidence.mutants.sample import sampled
from rcx_tools.evidence.mutants.seeded import Bug, bugs
from rcx_tools.evidence.mutants.select import alike, cheapest, naming_tests, nearest
from rcx_tools.evidence.mutants.tables import (
    TABLE_OPERATORS,
    marks_of,
    table_changes,
    table_meaning,
)
from structured_text.mutants.judging import MutantTask
from structured_text.mutants.text import edited

_MODULE = '''"""A robot that has it all."""

__all__ = ["Robot"]
_BITS = 0x0200


class Robot:
    """One."""

    slow: float = 0.5

    def __init__(self, config: Config) -> None:
        self.config = config
        self.on = False

    def take(self, bits: int, names: set[str]) -> int:
        """Take the inputs."""
        if bits & _BITS and not self.on:
            self.on = True
            names.add("SI12")
        if bits < 3 or "SI14" in names:
            raise Refused(self.config.busy_alarm)
        if bits == 7:
            raise InputError("7 is no input", hint="give 8")
        self.count += min(bits, 4)
        return self.count if self.on else bits - 1

    def refuse(self) -> str:
        return self.config.mode_alarm if self.phase is Phase.READY else Phase.RUN.name
'''
_TABLE = """# 12 is no number here

[[enumeration]]
name = "RCX_HAND"
section = "guide 4.2.1"
members = [
  ["HAND_NONE", 0, "none, 4 of them"],
  ["HAND_LEFT", 2, "left"],
]

[[enumeration]]
name = "RCX_ARM"
members = [
  ["ARM_RIGHT", 0, "right"],
]

[[block]]
name = "FB_Move"
commands = ["MovePtp", "MoveArch"]
timeout = "T#60s"
robot = true
inputs = [
  { pin = "Hand", type = "RCX_HAND", bits = [3, 4], default = "HAND_NONE", error = "16#8041" },
  { pin = "Speed", values = { 0 = "slow", 1 = "fast" }, default = "5", comment = "1 to 9" },
]
"""


def test_every_operator_of_python_makes_its_mistake() -> None:
    found = {
        (change.operator, change.pou, edited(_MODULE, change.edits).splitlines()[line - 1].strip())
        for change in python_changes(_MODULE, "harness/rcx_harness/robot/robot.py")
        for line in [_MODULE.count("\n", 0, change.edits[0].span.start) + 1]
    }
    take, head = "robot/robot.py:Robot.take", "robot/robot.py"
    expected = {
        ("mask", head, "_BITS = 0x0400"),
        ("constant", head, "slow: float = 1.0"),
        ("constant", "robot/robot.py:Robot.__init__", "self.on = True"),
        ("boolean", take, "if (bits & _BITS or not self.on):"),
        ("operand", take, "if (bits & _BITS):"),
        ("arithmetic", take, "if (bits | _BITS) and not self.on:"),
        ("negation", take, "if bits & _BITS and self.on:"),
        ("condition", take, "if (not (bits & _BITS and (not self.on))):"),
        ("dropped statement", take, "pass"),
        ("relational", take, 'if (bits <= 3) or "SI14" in names:'),
        ("off-by-one", take, 'if bits < 4 or "SI14" in names:'),
        ("dropped exit", take, "pass"),
        ("neighbour", take, "names.add('SI14')"),
        ("neighbour", take, "raise Refused(self.config.mode_alarm)"),
        ("swapped", take, "self.count += max(bits, 4)"),
        ("arithmetic", take, "self.count -= min(bits, 4)"),
        ("swapped", take, "return (bits - 1 if self.on else self.count)"),
        (
            "neighbour",
            "robot/robot.py:Robot.refuse",
            "return self.config.mode_alarm if self.phase is Phase.RUN else Phase.RUN.name",
        ),
    }
    assert expected - found == set()
    assert {operator for operator, _, _ in found} == set(PYTHON_OPERATORS)
    told = [line for _, _, line in found if "InputError" in line or "__all__" in line]
    assert told == []  # messages and `__all__` are not mutated


def test_a_kind_of_mutants_has_files_of_one_suffix() -> None:
    """Otherwise the tests of its modules are selected as if the modules were tables.

    The engine has tables of its own (dialects.toml), which are no mutants.
    """
    root = Path(command.__file__).parents[4]
    found = {kind.name: {file.suffix for file in kind.files(root)} for kind in KINDS}
    assert found == {
        "controller": {".py"},
        "monitors": {".py"},
        "engine": {".py"},
        "tables": {".toml"},
    }


def test_functions_are_known_by_where_their_code_begins() -> None:
    text = "class A:\n    @property\n    def b(self):\n        def c(): ...\n\n\nd = 1\n"
    assert functions(text) == {2: "A.b", 4: "A.b.c"}
    path = "harness/rcx_harness/robot/a.py"
    assert function_at(text, text.index("c()"), path) == "robot/a.py:A.b"
    assert function_at(text, text.index("d ="), path) == "robot/a.py"


def test_every_operator_of_tables_makes_its_mistake() -> None:
    found = {
        (change.operator, change.pou, table_meaning(edited(_TABLE, change.edits)))
        for change in table_changes(_TABLE)
    }
    changed = {
        ("swapped values", "RCX_HAND"): [('NONE", 0', 'NONE", 2'), ('LEFT", 2', 'LEFT", 0')],
        ("number", "RCX_HAND"): [('LEFT", 2', 'LEFT", 3')],
        ("number", "FB_Move"): [("bits = [3, 4]", "bits = [3, 5]")],
        ("swapped values", "FB_Move"): [('"MovePtp", "MoveArch"', '"MoveArch", "MovePtp"')],
        ("constant", "FB_Move"): [("true", "false")],
        ("default", "FB_Move"): [('"5"', '"6"')],
        ("swapped names", "RCX_HAND"): [("X_HAND", "?"), ("X_ARM", "X_HAND"), ("?", "X_ARM")],
    }  # fmt: skip
    for (operator, entry), edits in changed.items():
        text = _TABLE.replace('type = "RCX_HAND"', 'type = "kept"')
        for before, after in edits:
            text = text.replace(before, after, 1)
        text = text.replace('type = "kept"', 'type = "RCX_HAND"')
        assert (operator, entry, table_meaning(text)) in found, (operator, entry)
    more = ("T#120s", "16#8042", "HAND_LEFT'}", "{'0': 'fast', '1': 'slow'}")
    assert [one for one in more if not any(one in text for _, _, text in found)] == ["HAND_LEFT'}"]
    assert {operator for operator, _, _ in found} == set(TABLE_OPERATORS)
    texts = ("13 is no", "guide 5", "5 of them", "1 to 10")
    assert not any(text in content for text in texts for _, _, content in found)


def test_tests_are_about_an_entry_and_about_what_names_it(tmp_path: Path) -> None:
    file = tmp_path / "blocks.toml"
    file.write_text(_TABLE, encoding="utf-8")
    assert marks_of("RCX_HAND", [file]) == ("Move", "MoveArch", "MovePtp", "RCX_HAND")
    assert marks_of("MoveArch", [file]) == ("Move", "MoveArch", "MovePtp")
    assert marks_of("RCX_ARM", [file]) == ("RCX_ARM",)
    assert marks_of("SI12_Start", [file]) == ("SI12",)


def test_of_the_tests_that_run_a_function_those_with_words_of_the_line_are_added() -> None:
    """Of the tests that run a function, those whose names have words of the line run first.

    Tests with more words come first. At most eight tests are chosen.
    """
    many = [f"tests/a.py::test_time_{k}" for k in range(20)]
    nodes = ["tests/operating.py::test_it", *many, "tests/a.py::test_operating_time", "b::test_no"]
    found = alike("Accumulated.observe self.operating_us += time", nodes)
    assert found == ["tests/a.py::test_operating_time", *many[:7]]


def test_the_quickest_tests_of_each_test_function_come_first_up_to_a_time() -> None:
    seconds = {"a::long[1]": 3.0, "a::short[1]": 0.5, "a::short[2]": 0.25, "b::it": 1.0}
    of_each = ["a::short[2]", "b::it", "a::long[1]"]
    assert cheapest(seconds, seconds, 4.25) == of_each
    assert cheapest(seconds, seconds, 4.75) == [*of_each, "a::short[1]"]
    assert cheapest(seconds, seconds, 0.2) == []


def test_the_tests_that_run_the_fewest_functions_come_first_up_to_a_time() -> None:
    seconds = {"a::whole": 0.1, "a::unit": 1.0, "b::unit": 0.5, "b::some": 2.0}
    ran = {"a::whole": "FGHI", "a::unit": "F", "b::unit": "F", "b::some": "FG"}
    about = {node: frozenset(functions) for node, functions in ran.items()}
    assert nearest(ran, about, seconds, 3.5) == ["b::unit", "a::unit", "b::some"]
    assert nearest(ran, about, seconds, 3.4) == ["b::unit", "a::unit"]


def test_a_test_file_judges_the_blocks_that_its_docstring_names(tmp_path: Path) -> None:
    (tmp_path / "tests/area").mkdir(parents=True)
    for name, text in {
        "area/test_b.py": '"""FB_One and FB_OneWords, twice: FB_One."""',
        "test_a.py": '"""Of FB_One\'s twin FB_OneWords."""\nx = "FB_Two"',
        "area/test_none.py": 'x = "FB_Two"',
        "area/other.py": '"""FB_Two."""',
    }.items():
        (tmp_path / "tests" / name).write_text(text, encoding="utf-8")
    both = ("tests/area/test_b.py", "tests/test_a.py")
    assert naming_tests(tmp_path) == {"FB_One": both, "FB_OneWords": both}


def test_a_value_with_a_name_is_judged_by_the_tests_of_those_that_use_it() -> None:
    text = """_ADD, _SUBTRACT = 0x234, 0x235
_OTHER: int = 1


class Points:
    size = 4

    def take(self, code: int) -> int:
        return -1 if code == _SUBTRACT else self.size


def other() -> int:
    return _OTHER
"""
    texts = {"robot/a.py": text, "robot/b.py": "SEEN = 1\n\n\ndef show(at):\n    at.size\n"}
    found = [concerned("robot/a.py", line, texts) for line in (1, 2, 6)]
    take = "ROBOT/A.PY:POINTS.TAKE"
    assert found == [{take}, {"ROBOT/A.PY:OTHER"}, {take, "ROBOT/B.PY:SHOW"}]
    assert concerned("robot/b.py", 1, texts) == {"ROBOT/B.PY"}, "the name is not used"
    assert concerned("robot/a.py:other", 13, texts) == {"ROBOT/A.PY:OTHER"}


@pytest.mark.exhaustive
def test_a_sample_is_the_same_for_the_same_seed_and_has_nothing_twice(tmp_path: Path) -> None:
    text = _MODULE.replace("bits < 3", "bits < 3 and bits < 3")

    def drawn(one_of: int, seed: int, name: str = "robot.py", text: str = text) -> list[str]:
        file = tmp_path / "harness" / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
        found = python_changes(text, f"harness/{name}")
        mutants = sampled(tmp_path, file, found, python_meaning, one_of=one_of, seed=seed)
        return sorted(f"{one.operator} {one.before} -> {one.after}" for one in mutants)

    assert drawn(4, 1) == drawn(4, 1) != drawn(4, 2)
    every = drawn(1, 1)
    found = python_changes(text, "harness/robot.py")
    assert len(every) < len(found)  # equal operands: removing either is one mutant
    assert len(found) / 8 < len(drawn(4, 1)) < len(found) / 2
    assert set(drawn(8, 1)) < set(drawn(4, 1)) < set(every)
    assert len(drawn(10**9, 1)) == 1

    grown = f"_FIRST = 1\n\n\n{text}"
    assert drawn(4, 1, "other.py") == drawn(4, 1)
    assert [one for one in drawn(4, 1, "other.py", grown) if "_FIRST" not in one] == drawn(4, 1)


# --- a run ---

_LATCH = '''"""A latch, for tests of mutants."""


class Latch:
    def __init__(self) -> None:
        self.on = False

    def take(self, value: int) -> None:
        if value >= 10:
            self.on = True

    def lose_power(self) -> None:
        self.on = False


def filled(to: int) -> int:
    level = 0
    while level < to:
        level += 1
    return level
'''
#: A test that detects all mutants except the mutants of the limit 10.
_TEST = """from pathlib import Path

import pytest
from rcx_harness.robot.latch import Latch, filled


def test_the_latch():
    latch = Latch()
    latch.take(5)
    assert not latch.on
    latch.take(20)
    assert latch.on
    latch.lose_power()
    assert not latch.on


@pytest.fixture(scope="module")
def levels():
    return filled(0), filled(3)


def test_nothing_is_filled(levels):
    assert levels[0] == 0


def test_filled(levels):
    assert levels[1] == 3


def test_the_generated_block():
    block = Path(__file__).parents[2] / "plc/lib/command/movement/FB_MovePtp.st"
    assert "T#60s" in block.read_text(encoding="utf-8")
"""
_SEEDED = """[[bug]]
file = "harness/rcx_harness/robot/latch.py"
name = "the latch holds over a power cycle"
old = "    def lose_power(self) -> None:\\n        self.on = False"
new = "    def lose_power(self) -> None:\\n        pass"
tests = ["tests/robot"]

[[bug]]
file = "harness/rcx_harness/robot/latch.py"
name = "the limit is one too high"
old = ">= 10"
new = ">= 11"
tests = ["tests/robot/test_latch.py"]

[[bug]]
file = "spec/blocks.toml"
name = "a movement may take 61 s"
old = '''commands = ["MovePtp"]
done = "the robot has reached the target"
timeout = "T#60s"'''
new = '''commands = ["MovePtp"]
done = "the robot has reached the target"
timeout = "T#61s"'''
tests = ["tests/robot"]
"""


@pytest.fixture
def house(tmp_path: Path, repository: Path) -> Path:
    """Copy the harness with an additional module, its test, and one generated block."""
    house = tmp_path / "house"
    for folder in ("harness", "spec"):
        shutil.copytree(repository / folder, house / folder)
    block = "plc/lib/command/movement/FB_MovePtp.st"
    files = {
        "harness/rcx_harness/robot/latch.py": _LATCH,
        "tests/robot/test_latch.py": _TEST,
        "tests/tools/evidence/seeded.toml": _SEEDED,
        "tests/support/nothing.py": "",
        "pyproject.toml": "[tool.pytest.ini_options]\n",
        block: (repository / block).read_text(encoding="utf-8"),
    }
    for path, text in files.items():
        (house / path).parent.mkdir(parents=True, exist_ok=True)
        (house / path).write_text(text, encoding="utf-8")
    return house


def _run(house: Path) -> tuple[int, str, list[dict[str, object]]]:
    command = [sys.executable, "-m", "rcx_tools.evidence.mutants", "--root", str(house), "--all"]
    done = subprocess.run(
        [*command, "--kinds", "controller,seeded", "--patience", "3", "latch.py", "blocks.toml"],
        capture_output=True,
        text=True,
        check=False,
        cwd=house,
    )
    outcomes = (house / "out/verification/mutants.jsonl").read_text(encoding="utf-8")
    return done.returncode, done.stdout + done.stderr, list(map(json.loads, outcomes.splitlines()))


@pytest.mark.exhaustive
def test_a_run_finds_survivors_endless_loops_and_seeded_bugs_and_leaves_the_tree_alone(
    house: Path,
) -> None:
    before = _content(house)
    code, told, outcomes = _run(house)
    by = {(one["operator"], one["after"]): (one["killed"], one["by"]) for one in outcomes}
    survivors = {after for (_, after), (killed, _) in by.items() if not killed}
    limits = {"if (value > 10):", "if value >= 11:", "if value >= 9:"}
    assert survivors == limits, told
    latch = "tests/robot/test_latch.py::test_"
    assert (True, "a test does not end") in by.values()
    assert by["constant", "self.on = False"] == (True, f"{latch}the_latch")
    seeded = [one for one in outcomes if one["operator"] == "seeded"]
    assert [one["killed"] for one in seeded].count(False) == 1
    slow = next(one for one in seeded if "T#61s" in str(one["after"]))
    assert slow["by"] == f"{latch}the_generated_block"  # the mutant in the generated text
    assert code == 1
    assert "seeded: 2 of 3 mutants killed" in told
    assert _content(house) == before

    rows = house / "out/verification/mutants-without-reason-harness.toml"
    text = rows.read_text(encoding="utf-8")
    assert text.count('block = "robot/latch.py:Latch.take"') == 3
    table = house / "tests/tools/evidence/survivors_harness.toml"
    table.write_text(text.replace('reason = ""', 'reason = "nobody minds"'), encoding="utf-8")
    _, told, again = _run(house)
    assert len(again) == len(outcomes), told  # no mutant was run again
    assert "(3 survivors with a reason)" in told


def _content(house: Path) -> dict[str, bytes]:
    files = (file for file in house.rglob("*") if file.is_file())
    return {
        str(file): file.read_bytes()
        for file in files
        if not {"__pycache__", "out"} & set(file.relative_to(house).parts)
    }


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("old = 'nothing of the kind'", "`old` stands 0 times in pyproject.toml"),
        ("old = 'p'", "`old` stands 2 times in pyproject.toml"),
        ("new = '[tool.'", "`old` stands 1 times in pyproject.toml"),
        ("file = 'gone.py'", "`old` stands 0 times in gone.py"),
        ("tests = ['tests/gone']", "there is no tests/gone"),
        ("tests = []", "none of them empty"),
        ("tets = []", "it needs name, file, old, new, tests"),
        ("tests =", "not valid TOML"),
    ],
)
def test_a_seeded_bug_that_cannot_be_put_in_is_told_in_one_message(
    line: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    row = {
        "file": "file = 'pyproject.toml'",
        "name": "name = 'w'",
        "old": "old = '[tool.'",
        "new": "new = '['",
        "tests": "tests = ['.']",
    }
    lines = (row | {line.partition(" ")[0]: line}).values()
    table = tmp_path / "tests/tools/evidence/seeded.toml"
    table.parent.mkdir(parents=True)
    table.write_text("\n".join(["[[bug]]", *lines]), encoding="utf-8")
    (tmp_path / "pyproject.toml").write_text("[tool.pytest.ini_options]\n", encoding="utf-8")
    assert command.main(["--root", str(tmp_path), "--kinds", "seeded"]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1


def test_a_full_disk_is_told_in_one_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*arguments: object, **options: object) -> None:
        raise OSError(28, "No space left on device")

    table = tmp_path / "tests/tools/evidence/seeded.toml"
    table.parent.mkdir(parents=True)
    table.write_text(_SEEDED.split("\n\n")[0], encoding="utf-8")
    (tmp_path / "tests/robot").mkdir()
    latch = tmp_path / "harness/rcx_harness/robot/latch.py"
    latch.parent.mkdir(parents=True)
    latch.write_text(_LATCH, encoding="utf-8")
    monkeypatch.setattr(shutil, "copytree", full)
    assert command.main(["--root", str(tmp_path), "--kinds", "seeded"]) == 2
    told = capsys.readouterr().err
    assert "cannot be copied" in told
    assert "No space left on device; make room there, or set TMPDIR" in " ".join(told.split())
    assert told.count("\n") == 1


def test_an_unknown_kind_is_refused_with_those_that_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    with pytest.raises(SystemExit) as exit_:
        command.main(["--kinds", "monitor"])
    assert exit_.value.code == 2
    assert "there is no kind 'monitor'; kinds are controller, monitors" in capsys.readouterr().err


def test_the_page_tells_the_figures_of_each_kind() -> None:
    rows = dict(next(check for check in CHECKS if check.name == "mutants").rows)
    one: dict[str, object] = {"mutants": 1250, "killed": 1200, "score": 96.0}
    one |= {"survivors": [{}] * 50, "survivors_with_a_reason": 49}
    figures = {"kinds": {"tables": one, "seeded": {"mutants": 79, "killed": 78}}}
    told = "1,200 of 1,250 killed, 96.0 %; survivors 50, 49 with a reason"
    assert rows["mutants of the tables"](figures) == told
    assert rows["seeded bugs found"](figures) == "78 of 79"


# --- the seeded bugs in seeded.toml ---

_BUGS = bugs(Path(__file__).with_name("seeded.toml"))
#: Maps mutants with a fast test file to this file.
_QUICK_MUTANTS = {
    "MOD takes the sign of the divisor": "tests/structured_text/engines/builtin/test_arithmetic.py",
    "exactly 100 ms count as too short": "tests/watch/test_wire.py",
    "semi-absolute axes keep their origin without power": "tests/robot/test_robot_origin.py",
}


@pytest.mark.parametrize("bug", _BUGS, ids=lambda bug: bug.name)
def test_each_seeded_bug_can_be_put_in(bug: Bug, repository: Path) -> None:
    assert bug.mutant(repository).text != (repository / bug.file).read_text(encoding="utf-8")


def test_there_are_at_least_30_seeded_bugs_and_some_of_every_kind() -> None:
    files = [bug.file for bug in _BUGS]
    assert len({bug.name for bug in _BUGS}) == len(_BUGS) >= 30
    parts = ("spec/", "/robot/", "/watch/wire.py", "/watch/contract.py", "/engines/", "plc/lib/")
    for part in parts:
        assert sum(part in file for file in files) >= 3, part


@for_each("bug", _BUGS)
def test_the_tests_of_a_seeded_bug_are_in_the_folders_of_the_changed_code(bug: Bug) -> None:
    """The tests of each seeded bug are in the folders of the code that the bug changes."""
    part = file_key(bug.file).partition("/")[0]
    others = {
        "spec": ("tests/spec", "tests/command"),
        "engines": ("tests/structured_text/engines", "tests/structured_text/language"),
        "plc": tuple(f"tests/{name}" for name in ("area", "command", "core", "sequence")),
    }
    others["language"] = others["engines"]
    folders = others.get(part, (f"tests/{part}",))
    assert all(tests.startswith(folders) for tests in bug.tests)


@pytest.mark.exhaustive
def test_some_seeded_bugs_are_found(repository: Path) -> None:
    """Some seeded bugs are detected by their tests. `make mutants` tries all seeded bugs."""
    tasks = [
        MutantTask(bug.mutant(repository), (_QUICK_MUTANTS[bug.name],), 60.0, bug.name)
        for bug in _BUGS
        if bug.name in _QUICK_MUTANTS
    ]
    copies = Copies(repository)

    def run(task: MutantTask) -> str | None:
        changed = {task.mutant.file: task.mutant.text}
        return copies.first_failure(changed, task.tests)

    try:
        found = {
            one.task.key: one.by.partition("::")[0]
            for one in run_tasks(tasks, run, jobs=2, ended=copies.discard)
        }
    finally:
        copies.close()
    assert found == _QUICK_MUTANTS
