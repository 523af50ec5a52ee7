"""A project with graphical bodies is checked, and runs if it does not need these bodies."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from structured_text.bench import Bench
from structured_text.errors import InputError
from structured_text.language.load import analyse, checked
from structured_text.language.unread import unread_bodies
from structured_text.projects.sources import source_files
from twincat_projects import written_project

_LAMP = """\
FUNCTION_BLOCK Lamp
VAR_INPUT
  On : BOOL;
END_VAR
VAR_OUTPUT
  Q : BOOL := TRUE;
END_VAR
--- {}
"""
_MAIN = "PROGRAM MAIN\nVAR\n  n : INT;\n  l : Lamp;\n{}\nEND_VAR\n---\nn := n + 1;\n{}"


def _built(folder: Path, objects: dict[str, str]) -> Bench:
    return Bench.build(source_files(written_project(folder / "P", objects), None), engine="builtin")


def _refused(folder: Path, objects: dict[str, str]) -> str:
    with pytest.raises(InputError) as caught:
        _built(folder, objects)
    return caught.value.message


@pytest.mark.parametrize(
    ("language", "shown"),
    [
        ("NWL", "Ladder or Function Block Diagram, or IL (LD/FBD/IL)"),
        ("SFC", "Sequential Function Chart (SFC)"),
        ("CFC", "Continuous Function Chart (CFC)"),
    ],
)
def test_a_body_in_another_language_is_listed_and_the_rest_is_checked(
    language: str, shown: str, tmp_path: Path
) -> None:
    """A graphical body is listed, and the rest of the project is checked.

    The only error is the misspelled `q` in MAIN.

    Source: docs/how-to/projects.md.
    """
    main = _MAIN.format("", "l(On := n);\nn := l.R;\n")
    objects = {"Lamp.TcPOU": _LAMP.format(language), "MAIN.TcPOU": main}
    files = source_files(written_project(tmp_path / "P", objects), None)
    lamp = tmp_path / "P/Lamp.TcPOU"
    assert files.notes == (f"{lamp}:8: the body of Lamp is in {shown} and is not read",)
    _, errors = analyse(files.all)
    assert [Path(one.file or "").name for one in errors] == ["MAIN.TcPOU", "MAIN.TcPOU"]


def test_a_program_runs_that_reads_the_block_but_does_not_call_it(tmp_path: Path) -> None:
    """A program runs that only reads the graphical block.

    The block's output keeps its initial value.

    Source: docs/how-to/projects.md.
    """
    main = _MAIN.format("", "IF l.Q THEN n := n + 10; END_IF\n")
    with _built(tmp_path, {"Lamp.TcPOU": _LAMP.format("CFC"), "MAIN.TcPOU": main}) as bench:
        bench.scan()
        assert bench["MAIN.n"] == 11


_STATION = """\
FUNCTION_BLOCK Station
VAR
  l : Lamp;
END_VAR
---
l(On := TRUE);
"""
_WITH_METHOD = "FUNCTION_BLOCK {} {}\n---\n;\n"


@pytest.mark.parametrize(
    ("variables", "statements"),
    [
        ("", "l(On := TRUE);"),
        ("", "IF n > 100 THEN l(); END_IF"),
        ("  s : Station;", "s();"),
        ("  r : REFERENCE TO Lamp;", "r REF= l;\nr();"),
        ("  s : Several;", "s.Fill(1);"),
    ],
)
def test_a_program_that_calls_the_block_is_refused_by_its_name(
    variables: str, statements: str, tmp_path: Path
) -> None:
    """A program that calls the graphical block is refused.

    The call may be direct, under a condition, or through a block, a reference or a method.

    Source: docs/how-to/projects.md.
    """
    several = "FUNCTION_BLOCK Several\nVAR\n  l : Lamp;\nEND_VAR\n---\n;\n"
    project = written_project(
        tmp_path / "P",
        {
            "Lamp.TcPOU": _LAMP.format("SFC"),
            "Station.TcPOU": _STATION,
            "Several.TcPOU": several,
            "MAIN.TcPOU": _MAIN.format(variables, statements),
        },
    )
    file = tmp_path / "P/Several.TcPOU"
    method = (
        '<Method Name="Fill"><Declaration>METHOD Fill\nVAR_INPUT\n  k : INT;\nEND_VAR'
        "</Declaration><Implementation><ST>l(On := k > 0);</ST></Implementation></Method></POU>"
    )
    file.write_text(file.read_text("utf-8").replace("</POU>", method), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        Bench.build(source_files(project, None), engine="builtin")
    assert (
        caught.value.message
        == "the body of Lamp is in Sequential Function Chart (SFC) and is not read"
    )
    assert caught.value.hint == "write it in Structured Text: --replace Lamp=file.st"


_INTERFACE = "INTERFACE Filler\n"
_GRAPHICAL_METHOD = (
    '<Method Name="Fill"><Declaration>METHOD Fill</Declaration>'
    "<Implementation><{}/></Implementation></Method></{}>"
)


@pytest.mark.parametrize("called", ["f.Fill();", "b.Fill();", "n := n + 1;"])
def test_a_graphical_method_is_refused_if_it_can_be_called(called: str, tmp_path: Path) -> None:
    """A graphical method is refused if a call can reach it.

    The call may also go through an interface that another block implements in ST.

    Source: docs/how-to/projects.md.
    """
    variables = "  a : Hand;\n  b : Robot;\n  f : Filler;\nEND_VAR\n---\nf := a;\n"
    objects = {
        "Filler.TcIO": _INTERFACE,
        "Hand.TcPOU": _WITH_METHOD.format("Hand", "IMPLEMENTS Filler"),
        "Robot.TcPOU": _WITH_METHOD.format("Robot", "EXTENDS Hand"),
        "MAIN.TcPOU": f"PROGRAM MAIN\nVAR\n  n : INT;\n{variables}{called}\n",
    }
    project = written_project(tmp_path / "P", objects)
    for name, tag, language in (("Hand.TcPOU", "POU", "ST"), ("Robot.TcPOU", "POU", "CFC")):
        file = tmp_path / "P" / name
        text = file.read_text("utf-8").replace(f"</{tag}>", _GRAPHICAL_METHOD.format(language, tag))
        file.write_text(text, encoding="utf-8")
    file = tmp_path / "P/Filler.TcIO"
    method = '<Method Name="Fill"><Declaration>METHOD Fill</Declaration></Method></Itf>'
    file.write_text(file.read_text("utf-8").replace("</Itf>", method), encoding="utf-8")
    files = source_files(project, None)
    if "Fill" in called:
        with pytest.raises(InputError, match=r"the body of Robot\.Fill is in Continuous"):
            Bench.build(files, engine="builtin")
    else:
        Bench.build(files, engine="builtin").close()


def test_all_bodies_that_a_program_needs_are_in_one_message(tmp_path: Path) -> None:
    """One message names all needed bodies in other languages.

    Source: docs/how-to/projects.md.
    """
    bulb = _LAMP.replace("Lamp", "Bulb").format("CFC")
    main = _MAIN.format("  b : Bulb;", "l();\nb();\n")
    text = _refused(
        tmp_path, {"Lamp.TcPOU": _LAMP.format("SFC"), "Bulb.TcPOU": bulb, "MAIN.TcPOU": main}
    )
    assert text.endswith("(SFC) and is not read; neither is Bulb (CFC)")


def test_a_program_in_another_language_is_refused_by_its_name(tmp_path: Path) -> None:
    """A program with a graphical body is refused by its name.

    Source: docs/how-to/projects.md.
    """
    objects = {"MAIN.TcPOU": "PROGRAM MAIN\nVAR\n  n : INT;\nEND_VAR\n--- CFC\n"}
    assert _refused(tmp_path, objects).startswith("the body of MAIN is in Continuous Function")


def test_an_export_refuses_a_body_in_another_language(tmp_path: Path) -> None:
    """An export refuses a graphical body, even of a block that is not called.

    The exported body would be empty.

    Source: docs/how-to/projects.md.
    """
    objects = {"Lamp.TcPOU": _LAMP.format("CFC"), "MAIN.TcPOU": _MAIN.format("", "")}
    files = source_files(written_project(tmp_path / "P", objects), None)
    with pytest.raises(InputError, match="the body of Lamp is in Continuous"):
        checked(files.all)


def test_a_worker_process_knows_the_bodies_too(tmp_path: Path) -> None:
    """Pickled sources still name the bodies that were not read.

    Source: structured_text.farm: the sources are pickled.
    """
    objects = {"Lamp.TcPOU": _LAMP.format("CFC"), "MAIN.TcPOU": _MAIN.format("", "")}
    files = source_files(written_project(tmp_path / "P", objects), None)
    copies = pickle.loads(pickle.dumps(files.own))
    assert [one.name for one in unread_bodies(copies)] == ["Lamp"]
