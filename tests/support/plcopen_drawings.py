"""Projects in PLCopen XML with diagrams: short calls that write the elements of a file."""

from __future__ import annotations

from pathlib import Path

from structured_text.engines.builtin import BuiltinProgram
from structured_text.language.load import load
from structured_text.projects.open import read_project
from structured_text.projects.sources import source_files

__all__ = ["block", "element", "notes_of", "program_of", "project", "scanned", "text_of", "value"]

_XHTML = 'xmlns="http://www.w3.org/1999/xhtml"'
_FILE = """<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="{company}" productName="p" productVersion="1"/>
<types><pous>
{pous}</pous></types></project>
"""


def project(variables: str, body: str, *, company: str = "Beremiz", more: str = "") -> str:
    """Return a project with the program Main; `variables` are like `A B : BOOL; T : TON`."""
    declared = ""
    for names, _, kind in (part.partition(":") for part in variables.split(";")):
        for name in names.split():
            declared += (
                f'<variable name="{name}"><type><derived name="{kind.strip()}"/></type></variable>'
            )
    pou = (
        f'<pou name="Main" pouType="program"><interface><localVars>{declared}</localVars>'
        f"</interface>\n<body>\n{body}</body></pou>\n"
    )
    return _FILE.format(company=company, pous=more + pou)


def _lines(sources: str) -> str:
    """Return connections; a source is `5`, or `5.Q` for a pin of a block."""
    pins = (source.partition(".") for source in sources.split())
    return "".join(
        f'<connection refLocalId="{number}"' + (f' formalParameter="{pin}"/>' if pin else "/>")
        for number, _, pin in pins
    )


def element(
    kind: str, number: int | str, text: str = "", sources: str = "", at: str = "", **given: str
) -> str:
    """Return an element with its variable or expression and its connections.

    `at` is the position, such as `10 20`.
    """
    values = "".join(f' {key}="{one}"' for key, one in given.items())
    x, y = at.split() if at else ("0", "0")
    point = f"<connectionPointIn>{_lines(sources)}</connectionPointIn>" if sources else ""
    part = "variable" if kind in ("contact", "coil") else "expression"
    inner = f"<{part}>{text}</{part}>" if text else ""
    if kind == "comment":
        inner = f"<content><p {_XHTML}>{text}</p></content>"
    return (
        f'<{kind} localId="{number}"{values}><position x="{x}" y="{y}"/>{point}{inner}</{kind}>\n'
    )


def block(
    number: int | str,
    kind: str,
    inputs: dict[str, str],
    outputs: str,
    at: str = "0 0",
    in_outs: dict[str, str] | None = None,
    call: str = "",
    code: str = "",
    **given: str,
) -> str:
    """Return a block.

    An input is given by its sources; `NOT 5` is a negated pin, `rising 5` one with an edge. An
    output is `Q`, or `ET=Name` with a target.
    """
    x, y = at.split()
    values = "".join(f' {key}="{one}"' for key, one in given.items())
    text = f'<block localId="{number}" typeName="{kind}"{values}><position x="{x}" y="{y}"/>\n'
    text += f"<inputVariables>{''.join(map(_pin, inputs.items()))}</inputVariables>"
    text += f"<inOutVariables>{''.join(map(_pin, (in_outs or {}).items()))}</inOutVariables>"
    text += "<outputVariables>"
    for name, _, target in (pin.partition("=") for pin in outputs.split()):
        inner = f"<expression>{target}</expression>" if target else ""
        text += f'<variable formalParameter="{name}"><connectionPointOut>{inner}'
        text += "</connectionPointOut></variable>"
    text += "</outputVariables>"
    if call:
        space = "http://www.3s-software.com/plcopenxml"
        text += f'<addData><data name="{space}/fbdcalltype"><CallType>{call}</CallType></data>'
        text += f'<data name="{space}/stcode"><STCode>{code}</STCode></data></addData>'
    return f"{text}</block>\n"


def _pin(pin: tuple[str, str]) -> str:
    name, sources = pin
    more = ""
    if sources.startswith("NOT "):
        more, sources = ' negated="true"', sources.removeprefix("NOT ")
    if sources.startswith("rising "):
        more, sources = ' edge="rising"', sources.removeprefix("rising ")
    point = f"<connectionPointIn>{_lines(sources)}</connectionPointIn>"
    return f'<variable formalParameter="{name}"{more}>{point}</variable>'


def _file(folder: Path, text: str) -> Path:
    file = folder / "plc.xml"
    file.write_text(text, encoding="utf-8")
    return file


def program_of(folder: Path, text: str) -> BuiltinProgram:
    """Return the program of a project for the built-in engine."""
    return BuiltinProgram.build(load(source_files(_file(folder, text), None).all))


def notes_of(folder: Path, text: str) -> str:
    """Return the notes about parts of a project that are not read."""
    return "\n".join(source_files(_file(folder, text), None).notes)


def text_of(folder: Path, text: str, unit: str = "Main") -> list[tuple[int, str, str]]:
    """Return the lines of a POU: their lines in the file, their networks and their texts."""
    units = read_project([_file(folder, text)]).units
    (found,) = (one for one in units if one.name == unit)
    return [(line.at, line.network, line.text.strip()) for line in found.piece.lines()]


def value(program: BuiltinProgram, name: str) -> object:
    """Return a variable of Main; a BOOL as a number."""
    found = program.read(f"Main.{name}")
    return int(found) if isinstance(found, bool) else found


def scanned(program: BuiltinProgram, inputs: str, outputs: str, *rows: str) -> list[str]:
    """Return the outputs of each scan; a row has the inputs of a scan, such as `1 0`.

    A scan takes 10 ms. Inputs are BOOL.
    """
    found = []
    for scan, row in enumerate(rows):
        for name, given in zip(inputs.split(), row.split(), strict=True):
            program.write(f"Main.{name}", given == "1")
        program.scan(scan * 10_000)
        found.append(" ".join(str(value(program, name)) for name in outputs.split()))
    return found
