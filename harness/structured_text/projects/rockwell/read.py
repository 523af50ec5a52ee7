"""The elements of an L5X: data types, instructions, tags, programs and tasks.

The types are read first, because the statements of routines need them for conversions. A routine
that cannot be translated becomes a `Foreign` body with the reason. Such a body is an error only if
other parts of the project need it (see `open`).
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from structured_text.errors import VARIABLES, InputError
from structured_text.language.source import Line
from structured_text.projects.model import (
    Foreign,
    Lines,
    Piece,
    Project,
    Unit,
    in_comment,
    made,
)
from structured_text.projects.numbers import milliseconds_us, priority_of, whole
from structured_text.projects.rockwell import prescan
from structured_text.projects.rockwell.array_sizes import size_parameters
from structured_text.projects.rockwell.data import NUMBERS, Data, Instruction, Types
from structured_text.projects.rockwell.decorated import type_name, undeclared, used_types
from structured_text.projects.rockwell.expression_reader import (
    COUNTER,
    FIRST_SCAN,
    Routine,
    plain_tag,
    tokens_of,
)
from structured_text.projects.rockwell.instructions import BLOCKS, HELPER_MEMBERS, HELPERS
from structured_text.projects.rockwell.modules import module_tags
from structured_text.projects.rockwell.routines import (
    Read,
    RoutineReader,
    chosen,
    code_of,
    copies,
    declarations,
    returns,
    statements_of,
)
from structured_text.projects.rockwell.sheets.reader import enables_in
from structured_text.projects.rockwell.subroutines import declared_parameters, subroutine_of
from structured_text.projects.rockwell.unknown import unknown_types
from structured_text.projects.rockwell.values import ENABLE, Values
from structured_text.projects.tasks import ToolTask, configuration
from structured_text.projects.xml import Element

__all__ = ["read_l5x"]

_SECTIONS = {"Input": "VAR_INPUT", "Output": "VAR_OUTPUT", "InOut": "VAR_IN_OUT"}
_PRESCANNED, _SCANNED = f"{VARIABLES}Prescanned", f"{VARIABLES}Scanned"

#: Areas of a module's tags that are set to 0 when the connection to the module is opened.
_IMAGES = frozenset(("INPUTAREA", "OUTPUTAREA"))
#: Matches a statement of a prescan that sets a tag or an element of a tag.
_CLEARED = re.compile(r"\s*(\w+)(?:\[[^\]]*\])?\s*:=")
#: Matches the target of an alias: a tag with its members, elements and bits.
_ALIASED = re.compile(r"(\\?\w+(?::\w+)*)(?:\.\w+|\[\d+(?:,\d+)*\])*")
_MOST_ALIASES = 50
_OF_TAG = re.compile(r"(?<![\w.:])([^\W\d]\w*)\s*\.\s*([^\W\d]\w*)")
_MEMBER = re.compile(r"\.\s*([^\W\d]\w*)")
#: Interval of a periodic task without one, in milliseconds: the default of the tool (assumed).
_RATE = "10"
#: Largest number of elements in a dimension.
_LARGEST = (1 << 31) - 1


def read_l5x(root: Element, file: Path) -> Project:
    """Read a project, or an exported part of a project.

    Raise InputError if the file violates the format, or its Structured Text has unsupported parts.
    """
    return _Reader(root, file).project()


class _Reader:
    def __init__(self, root: Element, file: Path) -> None:
        self._root, self._file = root, file
        self._types = Types()
        self._types.members.update(HELPER_MEMBERS)
        self._kinds = list(root.below("DataType"))
        self._aois = list(root.below("AddOnInstructionDefinition"))
        self._parameters: dict[str, dict[str, Element]] = {}
        self._notes: list[str] = []
        options = next(root.below("Controller"), root).attributes
        self._routines = RoutineReader(file, self._types, self._notes, options)
        self._values = Values(self._types, self._parameters, self._data, self._note)
        self._needs: set[str] = set()
        self._first: list[str] = []
        #: Whether an instruction asks for the first scan of the program that calls it.
        self._asked = False
        for kind in self._kinds:
            self._know_type(kind)
        size_parameters(root)
        for aoi in (*self._aois, *self._aois):  # the type of an alias may be in a later one
            self._know_instruction(aoi)
        for encoded in root.below("EncodedData"):
            self._types.protected.add(encoded.get("Name").upper())
        code = code_of(root)
        self._types.read_members.update(_MEMBER.findall(code))
        for tag, member in _OF_TAG.findall(code):
            self._types.used.setdefault(tag, set()).add(member)
        self._types.read_members.update(enables_in(root))
        controller = next(root.below("Controller"), root)
        self._modules = module_tags(root)
        self._made = self._not_declared()
        self._tags, self._aliases = self._told_apart(controller, self._modules.aliases)
        self._tags += self._modules.tags
        self._global = {_key(one): self._data(one) for one in self._tags}
        shared = {_key(one): one for one in self._tags}
        for owner in root.below("Program", "AddOnInstructionDefinition"):
            local = (*owner.all("Tags", "Tag"), *owner.all("LocalTags", "LocalTag"))
            texts = [one.text() for one in owner.below("Text")]
            self._values.know_presets(texts, {**shared, **{_key(one): one for one in local}})

    def _error(self, message: str, element: Element, hint: str = "") -> InputError:
        return InputError(message, file=self._file, line=element.at, hint=hint)

    def _note(self, text: str, element: Element) -> None:
        self._notes.append(f"{self._file}:{element.at}: {text}")

    # --- types and tags -------------------------------------------------------------------

    def _know_type(self, kind: Element) -> None:
        members = [one for one in kind.all("Members", "Member") if one.get("Hidden") != "true"]
        if kind.get("Family") == "StringFamily":
            sizes = [self._data(one).sizes for one in members if _key(one) == "DATA"]
            self._types.strings[_key(kind)] = sizes[0][0] if sizes and sizes[0] else 82
        else:
            self._types.members[_key(kind)] = {_key(one): self._data(one) for one in members}

    def _not_declared(self) -> list[Element]:
        """Return the types that the file uses without a declaration, and know them.

        They are described by values, or they are predefined.
        """
        guessed = self._modules.guessed
        for tag in guessed:
            text = f"the type of {tag.get('Name')} is made from its uses, because the file has no"
            self._note(f"{text} data of this module", tag)
        whole_file = Element("", {}, 1, [self._root, *guessed])
        found = self._known(undeclared(whole_file, self._names()))
        for kind in found:
            if kind.get("Family"):
                length = f"its length is {self._types.strings[_key(kind)]}"
                self._note(f"the text type {kind.get('Name')} is not in the file; {length}", kind)
        typed = [*self._root.below("Member", "Tag", "LocalTag", "Parameter"), *guessed]
        values = unknown_types(self._root, typed, self._names(), self._modules.members, self._note)
        return found + self._known(undeclared(Element("", {}, 1, [*values]), self._names()))

    def _known(self, kinds: list[Element]) -> list[Element]:
        for kind in kinds:
            self._know_type(kind)
        return kinds

    def _names(self) -> set[str]:
        """Return the names of all types that are known so far, in upper case."""
        types = self._types
        return {*types.members, *types.strings, *types.protected, "BOOL", "BIT", *NUMBERS}

    def _know_instruction(self, aoi: Element) -> None:
        parameters = aoi.all("Parameters", "Parameter")
        local = {_key(one): one for one in aoi.all("LocalTags", "LocalTag")}
        for one in parameters:  # an alias has the type of the local tag that it refers to
            if one.get("AliasFor") and not one.get("DataType"):
                found = self._part_of(one.get("AliasFor"), local)
                one.attributes["DataType"] = found.type if found is not None else ""
                if found is not None and found.sizes:
                    one.attributes["Dimensions"] = " ".join(map(str, found.sizes))
        self._parameters[_key(aoi)] = {_key(one): one for one in parameters}
        self._types.members[_key(aoi)] = {_key(one): self._data(one) for one in parameters}
        self._types.instructions[_key(aoi)] = Instruction(
            tuple(
                (plain_tag(one.get("Name")), one.get("Usage"))
                for one in parameters
                if one.get("Required") == "true" and _key(one) not in ENABLE
            ),
            aoi.get("ExecuteEnableInFalse") == "true",
            "ENABLEOUT" in code_of(aoi),
            {_key(one): one.get("Usage") for one in parameters if _key(one) not in ENABLE},
        )

    def _part_of(self, path: str, local: Mapping[str, Element]) -> Data | None:
        """Return the type of a local tag of an instruction, or of a member or bit of it."""
        name, *members = path.split(".")
        if plain_tag(name).upper() not in local:
            return None
        found = self._data(local[plain_tag(name).upper()])
        for member in members:
            if member.isdigit():
                return Data("BOOL")
            inner = self._types.members.get(found.type.upper(), {}).get(member.upper())
            if inner is None or found.sizes:
                return None
            found = inner
        return found

    def _data(self, element: Element) -> Data:
        kind = type_name(element.get("DataType"))
        given = element.get("Dimensions") or element.get("Dimension")
        what = f"a dimension of {element.get('Name')}"
        numbers = [
            whole(one, what, 0, _LARGEST, self._file, element.at)
            for one in given.replace(",", " ").split()
        ]
        sizes = tuple(one for one in numbers if one)
        if kind.upper() in ("BIT", "BOOL", *NUMBERS):
            kind = {"BIT": "BOOL"}.get(kind.upper(), kind.upper())
        return Data(kind, sizes)

    def _told_apart(
        self, owner: Element, known: Mapping[str, str]
    ) -> tuple[list[Element], dict[str, str]]:
        """Return the real tags of a controller or program, and the target of each alias.

        A tag or alias of a program hides an alias of the controller.
        """
        own = owner.all("Tags", "Tag")
        tags = [one for one in own if one.get("TagType") != "Alias"]
        hidden = {_key(one) for one in tags}
        aliases = {key: tag for key, tag in known.items() if key not in hidden}
        named = {_key(one): one for one in own if one.get("TagType") == "Alias"}
        aliases |= {key: one.get("AliasFor") for key, one in named.items()}
        for key, tag in named.items():
            self._check_alias(key, tag, aliases)
        return tags, aliases

    def _check_alias(self, key: str, tag: Element, aliases: Mapping[str, str]) -> None:
        """Raise InputError for an alias that leads to itself, or to no tag."""
        name, seen = tag.get("Name"), {key}
        target = aliases[key]
        while True:
            found = _ALIASED.fullmatch(target)
            if found is None:
                text = f"the alias {name} stands for {target!r:.60}"
                raise self._error(text, tag, "name a tag, with its members and elements")
            base = found[1].upper()
            if base not in aliases:
                return
            if base in seen:
                hint = "name its tag in AliasFor"
                raise self._error(f"the alias {name} leads to itself", tag, hint)
            if len(seen) > _MOST_ALIASES:
                text = f"the alias {name} leads to more than {_MOST_ALIASES} others"
                raise self._error(text, tag, "name the tag itself in AliasFor")
            seen.add(base)
            target = aliases[base]

    # --- units ----------------------------------------------------------------------------

    def project(self) -> Project:
        tags = self._root.below("Tag", "LocalTag", "Parameter", "Member")
        typed = [type_name(one.get("DataType")) for one in (*tags, *self._modules.tags)]
        used = used_types(typed, self._types.members)
        kinds = [*self._kinds, *(one for one in self._made if _key(one) in used)]
        units = [self._structure(kind) for kind in kinds]
        units += [self._instruction(aoi) for aoi in self._aois]
        units += list(self._globals())
        programs = list(self._root.below("Program"))
        read = [self._program(one) for one in programs]
        units += [self._prescanned(unit, some) for unit, some in read]
        units += self._shared_prescan()
        if self._asked:
            lines = made(1, "VAR_GLOBAL", f"  {FIRST_SCAN} : BOOL;", "END_VAR")
            units.append(Unit("VAR_GLOBAL", Piece("L5X_FIRST_SCAN", lines), self._file))
        used |= self._needs
        own = {_key(one) for one in (*self._kinds, *self._aois)}
        for name, text in HELPERS.items():
            if name in used - own:
                lines = made(1, *text.splitlines())
                kind = text.partition(" ")[0]
                units.append(Unit(kind, Piece(name, lines), self._file, generated=True))
        arrays = [self._array(name, data) for name, data in self._types.arrays.items()]
        names = {_key(one): self._name_of(one) for one in programs}
        tasks = list(self._tasks(names))
        found = Project((*arrays, *units), tuple(self._notes))
        if not found.units:
            raise InputError("has no data type, instruction or program", file=self._file)
        return found.plus(configuration(tasks))

    def _array(self, name: str, data: Data) -> Unit:
        text = f"TYPE {name} : {self._types.array(data)}; END_TYPE"
        return Unit("TYPE", Piece(name, made(1, text)), self._file)

    def _structure(self, kind: Element) -> Unit:
        name = plain_tag(kind.get("Name"))
        if _key(kind) in self._types.strings:
            text = f"TYPE {name} : STRING[{self._types.strings[_key(kind)]}]; END_TYPE"
            return Unit("TYPE", Piece(name, made(kind.at, text)), self._file)
        lines = [*made(kind.at, f"TYPE {name} : STRUCT")]
        for one in kind.all("Members", "Member"):
            if one.get("Hidden") != "true":
                lines += made(one.at, f"    {self._declared(one)}")
        lines += made(kind.end, "  END_STRUCT;", "END_TYPE")
        return Unit("TYPE", Piece(name, tuple(lines)), self._file)

    def _declared(self, element: Element, initial: str = "") -> str:
        kind = self._types.written(self._data(element))
        value = f" := {initial}" if initial else ""
        text = f"{plain_tag(element.get('Name'))} : {plain_tag(kind)}{value};"
        said = element.first("Description")
        note = " ".join(said.text().split()) if said is not None else ""
        return f"{text} (* {in_comment(note)} *)" if note else text

    def _section(
        self, word: str, tags: Iterable[Element], cleared: Iterable[str] = ()
    ) -> Iterator[Line]:
        """Declare tags, as RETAIN except for the tags in `cleared`.

        An instance is not declared as RETAIN, because its own declarations decide.
        """
        kept: list[Element] = []
        anew: list[Element] = []
        for one in tags:
            kind = type_name(one.get("DataType")).upper()
            inside = kind in self._types.instructions or kind in BLOCKS
            (anew if inside or _key(one) in cleared else kept).append(one)
        retain = word if word == "VAR_IN_OUT" else f"{word} RETAIN"
        for head, some in ((retain, kept), (word, anew)):
            if some:
                yield from made(some[0].at, f"  {head}")
                for one in some:
                    initial = "TRUE" if _key(one) == "ENABLEIN" else self._values.initial(one)
                    yield from made(one.at, f"    {self._declared(one, initial)}")
                yield from made(some[-1].end, "  END_VAR")

    def _globals(self) -> Iterator[Unit]:
        section = self._section("VAR_GLOBAL", self._tags, _IMAGES | self._modules.images)
        lines = tuple(replace(line, text=line.text[2:]) for line in section)
        if lines:
            yield Unit("VAR_GLOBAL", Piece("Controller", lines), self._file)

    def _instruction(self, aoi: Element) -> Unit:
        name = plain_tag(aoi.get("Name"))
        parameters = aoi.all("Parameters", "Parameter")
        local = aoi.all("LocalTags", "LocalTag")
        routines = {_key(one): one for one in aoi.all("Routines", "Routine")}
        tags = {_key(one): self._data(one) for one in (*parameters, *local)}
        scope = Routine(self._file, self._types, tags, {}, {})
        logic = self._logic(aoi, routines, scope)
        body = logic.body
        said, first = "", Lines()
        if not isinstance(body, Foreign):
            said = "\n".join(line.text for line in body).upper()
            prescanned = self._routine("PRESCAN", routines, scope).body
            first = () if isinstance(prescanned, Foreign) else prescanned
        self._needs |= scope.needs
        cleared = {found[1].upper() for line in first if (found := _CLEARED.match(line.text))}
        lines = [*made(aoi.at, f"FUNCTION_BLOCK {name}")]
        for usage, word in _SECTIONS.items():
            own = (
                one
                for one in parameters
                if one.get("Usage") == usage and (_key(one) not in ENABLE or _key(one) in said)
            )
            lines += self._section(word, own, cleared)
        lines += self._section("VAR", local, cleared)
        begun = [text for part in scope.first.get("LOGIC", ()) for text in part.lines]
        first = (*made(aoi.at, *(f"    {text}" for text in begun)), *first)
        if first and not isinstance(body, Foreign):
            at = first[0].at
            lines += made(at, f"  VAR {_PRESCANNED} : BOOL; END_VAR")
            begin = made(at, f"  IF NOT {_PRESCANNED} THEN")
            end = made(at, f"    {_PRESCANNED} := TRUE;", "  END_IF;")
            body = (*begin, *first, *end, *body)
        if aoi.get("ExecutePostscan") == "true" and code_of(routines.get("POSTSCAN", aoi)):
            self._note(f"the routine Postscan of {name} is not read", aoi)
        if FIRST_SCAN in scope.needs and next(self._root.below("Program"), None) is None:
            text = "S:FS in an instruction needs a program in the file"
            body = Foreign("ST", aoi.at, text)
        self._asked = self._asked or FIRST_SCAN in scope.needs
        lines += self._extra(scope, aoi.at)
        if not isinstance(body, Foreign):
            body = (*copies(parameters, "Input"), *body, *copies(parameters, "Output"))
        end = made(aoi.end, "END_FUNCTION_BLOCK")
        piece = Piece(name, tuple(lines), body, end, diagram=logic.diagram)
        return Unit("FUNCTION_BLOCK", piece, self._file)

    def _routine(
        self, name: str, routines: Mapping[str, Element], scope: Routine, *, may_return: bool = True
    ) -> Read:
        """Return a routine of an instruction; without statements if there is none of this name.

        The rungs of routines other than Logic are named with their routine.
        """
        if name not in routines:
            return Read()
        read = self._routines.read(routines[name], scope, may_return=may_return)
        if name == "LOGIC" or isinstance(read.body, Foreign):
            return read
        behind = f" of {plain_tag(routines[name].get('Name'))}"
        lines = (
            replace(line, network=f"{line.network}{behind}") if line.network else line
            for line in read.body
        )
        return Read(tuple(lines))

    def _logic(self, aoi: Element, routines: Mapping[str, Element], scope: Routine) -> Read:
        """Return the statements for both values of EnableIn, and the diagram of Logic."""
        parameters = aoi.all("Parameters", "Parameter")
        may_return = not any(one.get("TagType") == "Alias" for one in parameters)
        block = self._types.instructions[_key(aoi)]
        read = self._routine("LOGIC", routines, scope, may_return=may_return)
        logic = read.body
        if isinstance(logic, Foreign):
            return read
        if block.false_routine:
            other = self._routine("ENABLEINFALSE", routines, scope, may_return=may_return).body
            if isinstance(other, Foreign):
                text = f"its routine EnableInFalse {other.says}"
                return Read(Foreign(other.language, other.at, text))
            logic = chosen("EnableIn", logic, other, aoi.at)
        if block.enable_out:
            value = "EnableIn" if block.false_routine else "TRUE"
            logic = (*made(aoi.at, f"  EnableOut := {value};"), *logic)
        return Read(logic, read.diagram)

    def _extra(self, scope: Routine, at: int) -> Lines:
        counter = {COUNTER: "DINT"} if COUNTER in scope.needs else {}
        return made(at, *declarations({**counter, **scope.added}))

    def _shared_prescan(self) -> list[Unit]:
        """Return the prescan of the tags of the controller; nothing if no ladder writes them."""
        if not self._first:
            return []
        state = made(1, "VAR_GLOBAL", f"  {prescan.VARIABLE} : BOOL;", "END_VAR")
        lines = prescan.function(self._first, 1)
        return [
            Unit("VAR_GLOBAL", Piece(f"{prescan.FUNCTION}_STATE", state), self._file),
            Unit("FUNCTION", Piece(prescan.FUNCTION, lines), self._file, generated=True),
        ]

    def _prescanned(self, unit: Unit, lines: Sequence[str]) -> Unit:
        """Return a program that begins with the prescan, `lines` for its own tags."""
        piece, shared = unit.piece, bool(self._first)
        if isinstance(piece.body, Foreign) or not (lines or shared):
            return unit
        at = piece.head[0].at
        part = prescan.of_program(piece.name, lines, at, shared=shared)
        declared = made(at, f"  VAR {prescan.DONE} : BOOL; END_VAR")
        piece = replace(
            piece,
            head=(*piece.head, *declared),
            body=(*made(at, f"  {prescan.METHOD}();"), *piece.body),
            parts=(part, *piece.parts),
        )
        return replace(unit, piece=piece)

    def _name_of(self, program: Element) -> str:
        """Return the name of a program, which may be that of a tag on the controller."""
        name = plain_tag(program.get("Name"))
        return f"{name}_Program" if _key(program) in self._global else name

    def _program(self, program: Element) -> tuple[Unit, list[str]]:
        """Return a program, and the prescan of its own tags."""
        name = self._name_of(program)
        own, aliases = self._told_apart(program, self._aliases)
        tags = {**self._global, **{_key(one): self._data(one) for one in own}}
        routines = {_key(one): one for one in program.all("Routines", "Routine")}
        main = routines.pop(_key_of(program, "MainRoutineName"), None)
        words = {key: plain_tag(one.get("Name")) for key, one in routines.items()}
        # tags and routines have names of their own on the controller, but not in the standard
        names = {key: f"{word}_Routine" if key in tags else word for key, word in words.items()}
        if main is None and routines and not program.get("MainRoutineName"):
            text = f"the program {name} has no main routine in this file, so no routine runs"
            self._note(text, program)
        scope = Routine(self._file, self._types, tags, aliases, names)
        called = {
            key: subroutine_of(names[key], tokens_of(statements_of(one)), scope)
            for key, one in routines.items()
        }
        scope = replace(scope, subroutines=called)
        read = self._routines.read(main, scope) if main is not None else Read()
        body = read.body
        parts = tuple(self._part(name, names[key], one, scope) for key, one in routines.items())
        lines = [*made(program.at, f"PROGRAM {name}")]
        lines += self._section("VAR", own, _IMAGES)
        lines += self._extra(scope, program.at)
        if FIRST_SCAN in scope.needs or self._asked:
            if not self._asked:
                lines += made(program.at, f"  VAR {FIRST_SCAN} : BOOL := TRUE; END_VAR")
            if not isinstance(body, Foreign) and (self._asked or returns(body)):
                lines += made(program.at, f"  VAR {_SCANNED} : BOOL; END_VAR")
                begin = (f"  {FIRST_SCAN} := NOT {_SCANNED};", f"  {_SCANNED} := TRUE;")
                body = (*made(program.at, *begin), *body)
            elif not isinstance(body, Foreign):
                body = (*body, *made(program.end, f"  {FIRST_SCAN} := FALSE;"))
        end = made(program.end, "END_PROGRAM")
        self._needs |= scope.needs
        parts_first = prescan.in_order(_key_of(program, "MainRoutineName"), scope.first)
        shared, mine = prescan.by_scope(parts_first, {plain_tag(_key(one)) for one in own})
        self._first += shared
        piece = Piece(name, tuple(lines), body, end, parts, read.diagram)
        return Unit("PROGRAM", piece, self._file), mine

    def _part(self, program: str, name: str, routine: Element, scope: Routine) -> Piece:
        """Return a routine that JSR calls."""
        variables: dict[str, str] = {}
        own = scope.subroutines[_key(routine)]
        read = self._routines.read(routine, replace(scope, own=own), variables)
        parameters = declared_parameters(own, self._types, routine.at)
        head = made(routine.at, f"METHOD {name}", *declarations(variables))
        head = (head[0], *parameters, *head[1:])
        end = made(routine.end, "END_METHOD")
        return Piece(f"{program}.{name}", head, read.body, end, diagram=read.diagram)

    def _tasks(self, names: Mapping[str, str]) -> Iterator[ToolTask]:
        for task in self._root.below("Task"):
            programs = []
            for one in task.all("ScheduledPrograms", "ScheduledProgram"):
                name = names.get(one.get("Name").upper())
                if name is None:
                    self._note(f"the program {one.get('Name')} is not in this file", one)
                else:
                    programs.append((name, name))
            kind = task.get("Type")
            name = plain_tag(task.get("Name"))
            if kind == "EVENT":
                self._note(f"the task {name} waits for an event and does not run", task)
                continue
            periodic, rate = kind == "PERIODIC", task.get("Rate")
            if periodic and "Rate" not in task.attributes:
                self._note(f"the task {name} has no interval; it is {_RATE} ms", task)
                rate = _RATE
            yield ToolTask(
                name if periodic else "",
                milliseconds_us(rate, name, self._file, task.at) if periodic else 0,
                priority_of(task.get("Priority"), name, self._file, task.at),
                tuple(programs),
                self._file,
                task.at,
            )


def _key(element: Element) -> str:
    return _key_of(element, "Name")


def _key_of(element: Element, attribute: str) -> str:
    return element.get(attribute).upper()
