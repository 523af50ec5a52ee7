"""PLCopen TC6 XML (2.00 and 2.01) of Beremiz, CODESYS, OpenPLC Editor and others.

CODESYS adds elements for features that the format lacks: methods, properties, interfaces and named
lists of global variables. It also adds each declaration as plain text. The text contains more than
the elements and is preferred to them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Line
from structured_text.projects.model import (
    Foreign,
    Library,
    Lines,
    Piece,
    Project,
    Unit,
    declared_kind,
    in_comment,
    made,
    trimmed,
)
from structured_text.projects.plcopen.devices import choose_device
from structured_text.projects.plcopen.drawn import Charted, drawn, text_of
from structured_text.projects.plcopen.networks import DRAWN
from structured_text.projects.plcopen.sortings import sorting_of
from structured_text.projects.plcopen.tasks import read_tasks, written_interval
from structured_text.projects.tasks import by_event, configuration
from structured_text.projects.xml import Element

__all__ = ["KINDS", "SECTIONS", "read_plcopen", "written_by"]

#: The kind of POU by its `pouType`.
KINDS = {"function": "FUNCTION", "functionBlock": "FUNCTION_BLOCK", "program": "PROGRAM"}
#: The section of variables by its XML element.
SECTIONS = {
    "inputVars": "VAR_INPUT",
    "outputVars": "VAR_OUTPUT",
    "inOutVars": "VAR_IN_OUT",
    "localVars": "VAR",
    "tempVars": "VAR_TEMP",
    "externalVars": "VAR_EXTERNAL",
    "globalVars": "VAR_GLOBAL",
}
_QUALIFIERS = {
    "constant": " CONSTANT",
    "retain": " RETAIN",
    "nonretain": " NON_RETAIN",
    "persistent": " PERSISTENT",
}
_PLAIN = "InterfaceAsPlainText"
#: Part of the name of each element that CODESYS adds to the format.
_CODESYS = "3s-software.com"
#: Words in the header of a file, with the dialect of the tool. The words are compared in this
#: order, those of TwinCAT before those of CODESYS.
_TOOLS = {
    "twincat": "twincat",
    "beckhoff": "twincat",
    "codesys": "codesys",
    "3s-smart": "codesys",
    "beremiz": "openplc",
    "openplc": "openplc",
}
_LANGUAGES = ("ST", "IL", "LD", "FBD", "SFC", "CFC")


def read_plcopen(root: Element, file: Path, device: str = "") -> Project:
    """Read the types, POUs, lists of variables and tasks of a project, or raise InputError.

    If there are several devices with programs, `device` is the name of the one to read. Bodies in
    LD, FBD and SFC are not translated yet; see `drawn`.
    """
    choose_device(root, device, file)
    reader = _Reader(file, written_by(root), sorting_of(root))
    units: list[Unit] = []
    for element in root.below("dataType", "pou", "Interface", "configuration", "globalVars"):
        units += reader.units(element)
    found = Project(tuple(units), reader.notes)
    if not any(unit.kind == "CONFIGURATION" for unit in units) and not reader.notes:
        tasks = [task for task in read_tasks(root.below("task"), file) if task.programs]
        found = found.plus(configuration(tasks))
    if not found.units:
        raise InputError("has no POU and no type", file=file)
    return replace(found, libraries=tuple(_libraries(root, file)))


def _libraries(root: Element, file: Path) -> Iterator[Library]:
    """Yield the libraries that CODESYS adds to an application, without system libraries."""
    for one in root.below("Libraries"):
        for library in one.all("Library"):
            title = library.get("DefaultResolution") or library.get("Name")
            name = title.split(",")[0].strip().removeprefix("#")
            space = library.get("Namespace") or name
            if name and library.get("SystemLibrary").lower() != "true" and name != "Standard":
                yield Library(name, space, file, library.at, noted=False)


def written_by(root: Element) -> str:
    """Return the dialect of the tool that has written a PLCopen XML file; empty if unknown."""
    said = " ".join(
        header.get(name)
        for header in root.all("fileHeader")
        for name in ("companyName", "productName")
    ).lower()
    found = next((name for word, name in _TOOLS.items() if word in said), "")
    if not found and any(_CODESYS in one.get("name") for one in root.below("data")):
        return "codesys"  # tools that are derived from CODESYS name themselves in the header
    return found


class _Reader:
    def __init__(self, file: Path, dialect: str, sorting: str) -> None:
        self._file, self._dialect, self._sorting = file, dialect, sorting
        self.notes: tuple[str, ...] = ()

    def _error(self, message: str, element: Element) -> InputError:
        return InputError(message, file=self._file, line=element.at)

    def units(self, element: Element) -> Iterator[Unit]:
        if element.name == "dataType":
            yield self._unit("TYPE", element, self._data_type(element))
        elif element.name == "pou":
            yield self._pou(element)
        elif element.name == "Interface":
            yield self._interface(element)
        elif element.name == "configuration":
            yield from self._configuration(element)
        elif element.children:
            head = _plain(element) or tuple(self._section(element, ""))
            yield self._unit("VAR_GLOBAL", element, head)

    def _unit(self, kind: str, element: Element, head: Lines) -> Unit:
        return Unit(kind, Piece(self._name(element), head), self._file)

    def _name(self, element: Element) -> str:
        name = element.get("name")
        if not name and element.name != "globalVars":
            raise self._error(f"<{element.name}> has no name", element)
        return name

    # --- POUs -----------------------------------------------------------------------------

    def _pou(self, element: Element) -> Unit:
        name = self._name(element)
        kind = KINDS.get(element.get("pouType"), "")
        head = _plain(element)
        if head:
            kind = declared_kind(head)
        elif kind:
            title = f"{kind} {name}{_extends(element)}"
            head = (*_comment(element), *self._head(element, title))
        if kind not in (*KINDS.values(), "INTERFACE"):
            raise self._error(f"{name} is not a function, function block or program", element)
        end = made(element.end, f"END_{kind}")
        parts = tuple(self._parts(element, name))
        piece = Piece(name, head, self._body(element), end, parts)
        return Unit(kind, piece, self._file)

    def _body(self, element: Element) -> Lines | Foreign:
        """Return the statements of a body; several sheets are joined."""
        lines: list[Line] = []
        bodies = element.all("body")
        for body in bodies:
            found = [one for one in body.children if one.name in _LANGUAGES]
            if not found:  # CODESYS writes CFC and other languages into additional elements
                found = list(body.below(*_LANGUAGES))
                if not found and any(body.below("data")):
                    found = [Element(next(body.below("data")).get("name"), {}, body.at)]
            for one in found:
                if one.name in DRAWN and len(bodies) == len(found) == 1:
                    return drawn(one, self._dialect, self._sorting)
                if one.name == "SFC" and len(bodies) == len(found) == 1:
                    transitions = element.all("transitions", "transition")
                    bodies_of = {one.get("name").upper(): self._body(one) for one in transitions}
                    return Charted("SFC", one.at, "", one, bodies_of, self._dialect, self._sorting)
                if one.name in (*DRAWN, "SFC"):
                    why = f"it has several bodies, and one is in {one.name} (draw a single body)"
                    return Foreign(one.name, one.at, why)
                if one.name != "ST":
                    return Foreign(re.sub(r".*/", "", one.name).upper(), one.at)
                lines += text_of(one)
        return tuple(lines)

    def _interface(self, element: Element) -> Unit:
        name = self._name(element)
        head = _plain(element) or made(element.at, f"INTERFACE {name}{_extends(element)}")
        parts = tuple(self._parts(element, name))
        end = made(element.end, "END_INTERFACE")
        return Unit("INTERFACE", Piece(name, head, (), end, parts), self._file)

    def _head(self, element: Element, title: str) -> Iterator[Line]:
        """Yield the first line of a POU or method, and its variables."""
        for interface in element.all("interface"):
            for result in interface.all("returnType")[:1]:
                title += f" : {self._type(_only(result, self._file))}"
        yield from made(element.at, title)
        yield from self._variables(element)

    def _variables(self, element: Element) -> Iterator[Line]:
        for interface in element.all("interface"):
            for one in interface.children:
                if one.name in SECTIONS:
                    yield from self._section(one, "  ")
                elif one.name == "accessVars":
                    raise self._error("access paths (VAR_ACCESS) are not supported", one)

    def _parts(self, element: Element, owner: str) -> Iterator[Piece]:
        """Yield methods, properties and actions, including those in the elements of CODESYS."""
        for one in element.children:
            if one.name in ("addData", "data", "actions", "Methods", "Properties"):
                yield from self._parts(one, owner)
            elif one.name == "Method":
                name = self._name(one)
                head = _plain(one) or tuple(self._head(one, f"METHOD {name}"))
                end = made(one.end, "END_METHOD")
                yield Piece(f"{owner}.{name}", head, self._body(one), end)
            elif one.name == "Property":
                yield self._property(one, owner)
            elif one.name in ("action", "Action"):
                name = self._name(one)
                head, end = made(one.at, f"ACTION {name}:"), made(one.end, "END_ACTION")
                yield Piece(f"{owner}.{name}", head, self._body(one), end)

    def _property(self, element: Element, owner: str) -> Piece:
        name = self._name(element)
        head = _plain(element) or tuple(self._head(element, f"PROPERTY {name}"))
        accessors = []
        for one in element.children:
            word = one.name.upper()
            if word in ("GETACCESSOR", "SETACCESSOR", "GET", "SET"):
                word = word[:3]
                head, end = made(one.at, word), made(one.end, f"END_{word}")
                title = f"{owner}.{name}.{word.capitalize()}"
                accessors.append(Piece(title, (*head, *self._variables(one)), self._body(one), end))
        end = made(element.end, "END_PROPERTY")
        return Piece(f"{owner}.{name}", head, (), end, tuple(accessors))

    # --- variables and types --------------------------------------------------------------

    def _section(self, element: Element, indent: str) -> Iterator[Line]:
        qualifiers = "".join(
            word for name, word in _QUALIFIERS.items() if element.get(name) in ("true", "1")
        )
        by_place = [one for one in element.all("variable") if _is_by_place(one)]
        others = [one for one in element.all("variable") if one not in by_place]
        sections = [(SECTIONS[element.name], others)]
        if by_place:
            sections.append(("VAR_IN_OUT", by_place))
        for word, variables in sections:
            yield from made(element.at, f"{indent}{word}{qualifiers}")
            for variable in variables:
                yield from self._variable(variable, f"{indent}  ")
            yield from made(element.end, f"{indent}END_VAR")

    def _variable(self, element: Element, indent: str) -> Lines:
        address = f" AT {element.get('address')}" if element.get("address") else ""
        given = element.first("type")
        if given is None:
            raise self._error(f"the variable {self._name(element)} has no type", element)
        kind = _open_array(element) or self._type(_only(given, self._file))
        kind += _start_arguments(element)
        text = f"{self._name(element)}{address} : {kind}{self._initial(element)};"
        return made(element.at, f"{indent}{text}{_note(element)}")

    def _data_type(self, element: Element) -> Lines:
        plain = _plain(element)
        if plain:
            return plain
        given = element.first("baseType")
        if given is None:
            raise self._error(f"the type {self._name(element)} has no base type", element)
        base = _only(given, self._file)
        lines = [*_comment(element), *made(element.at, f"TYPE {self._name(element)} :")]
        if base.name == "struct":
            lines += made(base.at, "  STRUCT")
            for variable in base.all("variable"):
                lines += self._variable(variable, "    ")
            lines += made(base.end, f"  END_STRUCT{self._initial(element)};")
        elif base.name == "enum":
            lines += self._enumeration(base, self._initial(element))
        else:
            lines += made(base.at, f"  {self._type(base)}{self._initial(element)};")
        return (*lines, *made(element.end, "END_TYPE"))

    def _enumeration(self, base: Element, initial: str) -> Iterator[Line]:
        members = list(base.below("value"))
        yield from made(base.at, "  (")
        for member in members:
            value = f" := {member.get('value')}" if member.get("value") else ""
            comma = "," if member is not members[-1] else ""
            yield from made(member.at, f"    {self._name(member)}{value}{comma}")
        kind = base.first("baseType")
        own = f" {self._type(_only(kind, self._file))}" if kind is not None else ""
        yield from made(base.end, f"  ){own}{initial};")

    def _type(self, element: Element) -> str:
        """Return a type as it is written in a declaration."""
        name = element.name
        if name == "derived":
            return self._name(element)
        if name in ("pointer", "reference", "array"):
            inner = self._type(_only(element.first("baseType") or element, self._file))
            if name != "array":
                return f"{name.upper()} TO {inner}"
            bounds = (f"{one.get('lower')}..{one.get('upper')}" for one in element.all("dimension"))
            return f"ARRAY [{', '.join(bounds)}] OF {inner}"
        if name in ("subrangeSigned", "subrangeUnsigned"):
            (base,), (limits,) = element.all("baseType")[:1], element.all("range")[:1]
            kind = self._type(_only(base, self._file))
            return f"{kind} ({limits.get('lower')}..{limits.get('upper')})"
        if name == "enum":
            return " ".join(line.text.strip() for line in self._enumeration(element, ""))[:-1]
        if name == "struct":
            fields = [
                line.text.strip()
                for one in element.all("variable")
                for line in self._variable(one, "")
            ]
            return f"STRUCT {' '.join(fields)} END_STRUCT"
        if name.lower() in ("string", "wstring"):
            length = f"[{element.get('length')}]" if element.get("length") else ""
            return f"{name.upper()}{length}"
        if name == "data":
            return self._type(_only(element, self._file))
        return name.upper()

    def _initial(self, element: Element) -> str:
        found = element.first("initialValue")
        return f" := {self._value(_only(found, self._file))}" if found is not None else ""

    def _value(self, element: Element) -> str:
        if element.name == "simpleValue":
            return element.get("value")
        if element.name == "structValue":
            fields = (
                f"{one.get('member')} := {self._value(_only(one, self._file))}"
                for one in element.children
            )
            return f"({', '.join(fields)})"
        items = []
        for one in element.children:
            count, item = one.get("repetitionValue", "1"), self._value(_only(one, self._file))
            items.append(item if count == "1" else f"{count}({item})")
        return f"[{', '.join(items)}]"

    # --- configurations -------------------------------------------------------------------

    def _configuration(self, element: Element) -> Iterator[Unit]:
        """Yield the named lists of variables and a tool's additions, then the configuration."""
        resources = element.all("resource")
        for one in element.below("pou", "dataType", "Interface", "globalVars"):
            if one.name != "globalVars" or one.get("name"):
                yield from self.units(one)
        unnamed = [one for part in (element, *resources) for one in _unnamed(part)]
        if not unnamed and not any(resource.all("task") for resource in resources):
            return
        name = self._name(element)
        found, called = Project(), 0
        lines = [*_comment(element), *made(element.at, f"CONFIGURATION {name}")]
        for one in _unnamed(element):
            lines += self._section(one, "  ")
        for resource in resources:
            lines += made(resource.at, f"  RESOURCE {self._name(resource)} ON PLC")
            for one in _unnamed(resource):
                lines += self._section(one, "    ")
            tasks, events = by_event(read_tasks(resource.all("task"), self._file))
            found = found.plus(events)
            elements = {task.get("name"): task for task in resource.all("task")}
            for task in tasks:
                if task.name:
                    settings = [f"INTERVAL := {written_interval(elements[task.name], task)}"]
                    if task.priority is not None:
                        settings.append(f"PRIORITY := {task.priority}")
                    text = f"TASK {task.name}({', '.join(settings)});"
                    lines += made(task.at, f"    {text}{_note(elements[task.name])}")
            for task in tasks:
                given = f" WITH {task.name}" if task.name else ""
                ones = elements[task.name].all("pouInstance") if task.name else ()
                lines += [line for one in ones for line in self._instance(one, given)]
                programs = () if task.name else task.programs
                lines += made(task.at, *(f"    PROGRAM {a} : {b};" for a, b in programs))
                called += len(task.programs)
            for one in resource.all("pouInstance"):
                lines += self._instance(one, "")
                called += 1
            lines += made(resource.end, "  END_RESOURCE")
        lines += made(element.end, "END_CONFIGURATION")
        yield from found.units
        self.notes += found.notes
        if called or unnamed or not found.notes:
            yield self._unit("CONFIGURATION", element, tuple(lines))

    def _instance(self, element: Element, task: str) -> Lines:
        name = self._name(element)
        program = element.get("typeName") or element.get("type") or name
        return made(element.at, f"    PROGRAM {name}{task} : {program};{_note(element)}")


def _unnamed(element: Element) -> list[Element]:
    """Return the global variables of a configuration or resource, without named lists."""
    return [one for one in element.all("globalVars") if not one.get("name")]


def _is_by_place(variable: Element) -> bool:
    """Return whether CODESYS has written a VAR_IN_OUT of open length as an input."""
    found = variable.all("addData", "data", "Attributes", "Attribute")
    scope = "variable_length_array_original_scope"
    return any(one.get("Name") == scope and one.get("Value") == "Inout" for one in found)


def _start_arguments(variable: Element) -> str:
    """Return the arguments for the `INIT` of a block, which CODESYS adds to the variable."""
    lists = variable.all("addData", "data", "InputAssignments")
    values = [one.text() for found in lists[:1] for one in found.all("InputAssignment", "Value")]
    return f"({', '.join(values)})" if values else ""


def _open_array(variable: Element) -> str:
    """Return the type of an array of open length, which CODESYS adds as an attribute."""
    found = variable.all("addData", "data", "Attributes", "Attribute")
    kinds = [one.get("Value") for one in found if one.get("Name") == "variable_length_array"]
    return kinds[0] if kinds else ""


def _only(element: Element, file: Path) -> Element:
    """Return the single child of an element; raise InputError if there is none."""
    found = [one for one in element.children if one.name not in ("documentation", "addData")]
    found = found or [data for one in element.all("addData", "data") for data in one.children]
    if not found:
        raise InputError(f"<{element.name}> is empty", file=file, line=element.at)
    return found[0]


def _plain(element: Element) -> Lines:
    """Return the declaration as plain text; empty if no tool has added it to this element."""
    waiting = list(element.children)
    while waiting:
        one = waiting.pop(0)
        if one.name == _PLAIN:
            return text_of(one)
        if one.name in ("addData", "data", "interface"):
            waiting += one.children
    return ()


def _extends(element: Element) -> str:
    """Return the text of EXTENDS and IMPLEMENTS, with the names that CODESYS has added."""
    text = ""
    for one in element.below("Inheritance", "pouInheritance"):
        bases = [base.text() or base.get("name") for base in one.below("Extends")]
        interfaces = [base.text() or base.get("name") for base in one.below("Implements")]
        text += f" EXTENDS {', '.join(bases)}" if bases else ""
        text += f" IMPLEMENTS {', '.join(interfaces)}" if interfaces else ""
    return text


def _comment(element: Element) -> Lines:
    """Return an element's documentation as a comment on lines of its own."""
    said = [line for one in element.all("documentation") for line in trimmed(one.lines())]
    if len(said) < 2:
        return tuple(Line(f"(* {in_comment(line.text)} *)", line.at) for line in said)
    lines = (Line(f" * {in_comment(line.text)}".rstrip(), line.at) for line in said)
    return (Line("(*", said[0].at), *lines, Line(" *)", said[-1].at))


def _note(element: Element) -> str:
    """Return an element's documentation as a comment at the end of its line."""
    said = " ".join(" ".join(one.text().split()) for one in element.all("documentation"))
    return f" (* {in_comment(said)} *)" if said else ""
