"""A check that is repeated after a change finds what a new check finds, and looks at less."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from random import Random

import pytest

from structured_text.editor.checker import Checker
from structured_text.language import syntax as s
from structured_text.language.load import analyse
from structured_text.language.parser import read_text

FILES = {
    "Types.st": """\
TYPE Colour : (Red, Green, Blue);
END_TYPE
TYPE Pair :
STRUCT
    First : INT;
    Second : Colour;
END_STRUCT
END_TYPE
""",
    "Globals.st": """\
VAR_GLOBAL
    Speed : INT := 5;
    Shade : Colour;
    Both : Pair;
END_VAR
VAR_GLOBAL CONSTANT
    Most : INT := 7;
END_VAR
""",
    "Twice.st": """\
FUNCTION Twice : INT
VAR_INPUT
    Value : INT;
END_VAR
Twice := Value * 2;
END_FUNCTION
FUNCTION Thrice : INT
VAR_INPUT
    Value : INT;
END_VAR
Thrice := Twice(Value) + Value;
END_FUNCTION
""",
    "Base.st": """\
FUNCTION_BLOCK Base
VAR_INPUT
    Go : BOOL;
END_VAR
VAR_OUTPUT
    Done : BOOL;
    Where : Pair;
END_VAR
VAR
    Table : ARRAY [0..Most] OF INT;
    Start : INT := Speed;
END_VAR
Done := Go;
Where.First := Twice(Where.First);
METHOD PUBLIC Step : BOOL
VAR_INPUT
    Size : INT;
END_VAR
Table[1] := Size;
Step := Size > 3;
END_METHOD
PROPERTY Level : INT
GET
Level := Table[0];
END_GET
SET
Table[0] := Level;
END_SET
END_PROPERTY
END_FUNCTION_BLOCK
""",
    "Child.st": """\
FUNCTION_BLOCK Child EXTENDS Base IMPLEMENTS Able
VAR
    Count : INT;
    Delay : TON;
END_VAR
SUPER^();
Delay(IN := Done, PT := T#1s);
IF Delay.Q THEN
    Count := Count + 1;
    Where.Second := Colour#Green;
END_IF;
METHOD Run : INT
Run := Count;
END_METHOD
END_FUNCTION_BLOCK
INTERFACE Able
METHOD Run : INT
END_METHOD
END_INTERFACE
""",
    "Main.st": """\
PROGRAM Main
VAR
    C : Child;
    N : INT;
    P : POINTER TO INT;
END_VAR
C(Go := TRUE);
N := Thrice(Speed) + C.Run();
Helper();
C.Level := 3;
Both.First := N;
P := ADR(N);
END_PROGRAM
""",
    "Helper.st": """\
PROGRAM Helper
VAR
    B : Base;
    A : Able;
    X : INT := Most;
END_VAR
B(Go := Main.C.Done);
IF B.Step(Size := 2) THEN
    X := B.Where.First;
    Shade := Red;
END_IF;
END_PROGRAM
""",
}
#: Number of bodies and starts in these files: 2 functions, Base with 3 methods, Child with 1, 2
#: programs, and 2 lists of global variables.
BODIES = 12
#: Texts that a random change inserts.
TEXTS = (
    *("INT", "BOOL", "Red", "Pair", "Child", "Base", "Helper", "Main", "Twice", "Speed", "X", "N"),
    *(";", "(", ")", "END_IF", "IF", "\n", "END_VAR", "VAR", "Level", "Run", "(* c *)", "1", "'a'"),
    *("Most", "Able", "Step", ":=", ".", " ", "Extra : INT;", "Speed := 4;", "CONSTANT", "C"),
    *("Helper();", "METHOD Run : INT", "END_METHOD"),
)
#: Kinds of random changes.
KINDS = (*("replace", "insert", "insert", "blank"), *("delete", "repeat", "lose", "restore"))


class Project:
    """Files that change, and the two checks of them."""

    def __init__(self) -> None:
        self.texts = dict(FILES)
        self.checker = Checker()

    def read(self, path: Path) -> s.Source:
        """Parse a file of the project."""
        return read_text(self.texts[path.name], path)

    def repeated(self) -> list[str]:
        """Return the errors of the repeated check."""
        return list(map(str, self.checker.check(list(map(Path, self.texts)), self.read)))

    def anew(self) -> list[str]:
        """Return the errors of a check that begins anew."""
        _, errors = analyse(list(map(Path, self.texts)), self.read, sys.maxsize)
        return list(map(str, errors))

    def change(self, file: str, old: str, new: str) -> list[str]:
        """Change a text, and return the errors of the repeated check."""
        assert old in self.texts[file]
        self.texts[file] = self.texts[file].replace(old, new)
        return self.repeated()


@pytest.fixture
def project() -> Project:
    project = Project()
    assert project.repeated() == []
    assert project.checker.checked_bodies == BODIES
    return project


def test_a_change_in_a_body_checks_its_file_only(project: Project) -> None:
    found = project.change("Child.st", "Count := Count + 1", "\n    Count := Wrong")
    assert found == ["Child.st:10:14: Wrong is not declared"]
    assert project.checker.checked_bodies == 2  # Child, Child.Run


def test_a_moved_method_has_its_mistake_at_the_new_line(project: Project) -> None:
    project.change("Base.st", "Step := Size > 3", "Step := Size > 'a'")
    found = project.change("Base.st", "Done := Go;", "Done := Go;\n\n")
    assert [one.partition(" ")[0] for one in found] == ["Base.st:22:16:"]


def test_a_changed_interface_checks_only_those_that_see_it(project: Project) -> None:
    found = project.change("Twice.st", "FUNCTION Thrice : INT", "FUNCTION Thrice : BOOL")
    assert "Main.st:8:6: a BOOL cannot be added" not in found
    assert any(one.startswith("Main.st:8:") for one in found)
    assert project.checker.checked_bodies == 3  # both functions of the file, and Main


def test_a_mistake_in_another_file_remains(project: Project) -> None:
    project.change("Helper.st", "X := B.Where.First", "X := B.Where.Third")
    found = project.change("Child.st", "Count := Count + 1", "Count := Wrong")
    assert found == [
        "Child.st:9:14: Wrong is not declared",
        "Helper.st:9:18: Pair has no member Third",
    ]


def test_a_program_that_is_no_longer_called_is_missed(project: Project) -> None:
    project.change("Main.st", "Helper();", "")
    assert project.repeated() == project.anew()
    found = project.change("Helper.st", "B(Go := Main.C.Done);", "B();")
    assert found == project.anew()


def _edit(random: Random, texts: dict[str, str]) -> None:
    """Change a text at random: a word, a place, a line, or back to the beginning."""
    name = random.choice(list(texts))
    text = texts[name]
    words = [found.span() for found in re.finditer(r"\w+|[^\w\s]|\n", text)]
    begin, end = random.choice(words) if words else (0, 0)
    kind = random.choice(KINDS)
    if kind == "replace":
        text = text[:begin] + random.choice(TEXTS) + text[end:]
    elif kind == "insert":
        text = f"{text[:begin]} {random.choice(TEXTS)} {text[begin:]}"
    elif kind == "blank":
        text = f"{text[:begin]}\n{text[begin:]}"
    elif kind == "delete":
        text = text[:begin] + text[end:]
    elif kind == "restore":
        text = FILES[name]
    else:
        lines = text.split("\n")
        line = lines.pop(random.randrange(len(lines)))
        if kind == "repeat":
            lines.insert(random.randrange(len(lines) + 1), line)
            lines.insert(random.randrange(len(lines) + 1), line)
        text = "\n".join(lines)
    texts[name] = text


@pytest.mark.parametrize(
    "seed",
    [0, *(pytest.param(seed, marks=pytest.mark.exhaustive) for seed in range(1, 80))],
)
def test_after_any_edits_both_checks_agree(seed: int) -> None:
    random = Random(seed)
    project = Project()
    for _ in range(20):
        assert project.repeated() == project.anew()
        if random.random() < 0.3:
            project.texts = dict(FILES)
        for _ in range(random.choice([1, 1, 1, 2])):
            _edit(random, project.texts)
