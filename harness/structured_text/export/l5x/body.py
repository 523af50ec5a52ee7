"""A checked POU as an Add-On Instruction, or as the tags and the routine of a program."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from structured_text.export.initial import differing, zero
from structured_text.export.l5x.expression_writer import ExpressionWriter, fold
from structured_text.export.l5x.model import (
    FIRST_SCAN,
    RESULT,
    STANDARD_BLOCKS,
    UNWRITTEN,
    Aoi,
    Data,
    Images,
    NotCarriedError,
    Tag,
    check_name,
    companion,
    data_of,
    image_element,
    is_whole,
    is_zero,
    passed,
    value_text,
)
from structured_text.export.losses import retain
from structured_text.export.parts import Part
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.syntax import Position
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.language.walk import root_of, statements

__all__ = ["copied", "translated", "written"]


def written(pou: t.Pou, pous: Mapping[str, t.Pou]) -> set[str]:
    """Return the names of variables that are assigned, or passed to a block that assigns them."""
    found: list[t.Variable] = []
    for one in statements(pou.body):
        if isinstance(one, t.Assign):
            found.append(one.target)
        elif isinstance(one, t.CallBlock):
            found += [target for _, target in one.outputs]
            callee = pous.get(one.block.name.upper())
            inside = written(callee, pous) if callee is not None else set()
            found += [variable for pin, variable in one.in_outs if pin in inside]
    return {symbol.name for one in found if (symbol := root_of(one)) is not None}


_COMMENT = re.compile(r"'(?:\$.|[^$'\n])*'|\(\*(.*?)\*\)", re.DOTALL)
_USAGES = {"VAR_INPUT": "Input", "VAR_OUTPUT": "Output", "VAR_IN_OUT": "InOut"}
_STEP = "  "


def translated(part: Part, pou: t.Pou, pous: Mapping[str, t.Pou], images: Images) -> Aoi:
    """Translate a POU, or raise NotCarriedError."""
    return _Writer(part, pou, pous, images).aoi()


class _Writer:
    """A writer of one POU in the Structured Text of Logix.

    A function sets its variables at the beginning of its logic, because a Logix tag keeps its value
    between calls. A block sets them in its Prescan routine. A structure, array or STRING is passed
    by reference. For each such pin of an instance, the caller has a tag of its own (`companion`).
    RETURN is not
    written: the code behind an `IF … THEN RETURN` moves into an IF with the opposite condition.
    """

    def __init__(self, part: Part, pou: t.Pou, pous: Mapping[str, t.Pou], images: Images) -> None:
        self._part, self._pou, self._pous, self._images = part, pou, pous, images
        self._expressions = ExpressionWriter(pous, images)
        self._comments = _comments(part)
        self._zeros: dict[str, Data] = {}
        self._at: Position | None = None
        self._aoi = Aoi(check_name(pou.name), part.header)

    def aoi(self) -> Aoi:
        """Return the translated POU; an error has the position of the statement that causes it."""
        try:
            return self._aoi_of_pou()
        except NotCarriedError as error:
            error.at = self._at
            raise

    def _aoi_of_pou(self) -> Aoi:
        for symbol in self._symbols():
            self._declare(symbol)
        body = self._returned(self._pou.body, "")
        aoi = self._aoi
        aoi.logic = [*self._cleared(), *body]
        aoi.prescan = [] if self._pou.kind == "FUNCTION" else list(self._initialised())
        self._at = None
        if self._pou.kind == "PROGRAM" and aoi.prescan:
            self._first_scan()
        for name, zeros in self._zeros.items():
            aoi.locals.append(Tag(name, zeros, "Local", None, UNWRITTEN))
        for name, instance in self._expressions.instances.items():
            aoi.locals.append(Tag(check_name(instance), Data(name), "Local", is_block=True))
            aoi.blocks[name] = None
        for name, data in self._expressions.temporaries.items():
            initial = None if data == "STRING" else "0"
            aoi.locals.append(Tag(name, Data(data), "Local", initial))
        names = [tag.name.upper() for tag in (*aoi.parameters, *aoi.locals)]
        if len(set(names)) != len(names):
            raise NotCarriedError("it uses a name that the translation needs for its own tag")
        return aoi

    def _first_scan(self) -> None:
        """Add the statements that set the initial values of a program in its first scan.

        A program has no Prescan routine, so it calls an instruction that has one.
        """
        aoi = self._aoi
        aoi.locals.append(Tag(f"{FIRST_SCAN}_1", Data(FIRST_SCAN), "Local", is_block=True))
        aoi.blocks[FIRST_SCAN] = None
        lines = (f"  {line}" for line in aoi.prescan)
        call = f"{FIRST_SCAN}({FIRST_SCAN}_1);"
        aoi.logic = [call, f"IF {FIRST_SCAN}_1.Q THEN", *lines, "END_IF;", *aoi.logic]

    def _symbols(self) -> list[t.Symbol]:
        result = [] if self._pou.result is None else [self._pou.result]
        return [*self._pou.symbols.values(), *result]

    # --- declarations ---------------------------------------------------------------------

    def _declare(self, symbol: t.Symbol) -> None:
        self._at = symbol.at
        inside = symbol.section == "VAR" and data_of(symbol.type, self._images) == Data("STRING")
        if is_whole(symbol.type) and not is_zero(symbol.initial) and not inside:
            self._check_set(symbol)
        result = symbol.section == "RESULT"
        name = RESULT if result else check_name(symbol.name)
        data = data_of(symbol.type, self._images)
        self._mention(symbol.type)
        usage = "Output" if result else _USAGES.get(symbol.section, "Local")
        if usage in ("Input", "Output") and is_whole(symbol.type):
            usage = "InOut"
        note = self._part.notes.get(symbol.name.upper(), "")
        members = getattr(symbol.type, "members", ())
        if members:
            note += f"{'; ' if note else ''}" + ", ".join(
                f"{value} {member}" for value, member in enumerate(members)
            )
        if isinstance(symbol.type, BlockType):
            self._aoi.locals.append(Tag(name, data, "Local", None, note, is_block=True))
            self._companions(name, symbol.type)
            return
        initial = 0 if symbol.initial is None else symbol.initial
        plain = not data.is_aggregate or (inside and initial)
        text = value_text(initial, symbol.type) if plain else None
        tag = Tag(name, data, usage, text, note)
        (self._aoi.locals if usage == "Local" else self._aoi.parameters).append(tag)

    def _companions(self, instance: str, block: BlockType) -> None:
        for pin in passed(block.variables):
            if pin.section != "VAR_IN_OUT":
                name, data = companion(instance, pin.name), data_of(pin.type, self._images)
                note = f"{pin.name} of {instance}"
                self._aoi.locals.append(Tag(name, data, "Local", None, note))
                self._mention(pin.type)

    def _mention(self, kind: Type) -> None:
        data = data_of(kind, self._images)
        if isinstance(kind, BlockType):
            self._aoi.blocks[data.type] = None
        elif data.type not in ("BOOL", "DINT", "REAL", "STRING", "SINT", "INT"):
            self._aoi.types[data.type] = None

    # --- initial values -------------------------------------------------------------------

    def _cleared(self) -> Iterator[str]:
        """Yield lines that reset variables at the beginning of each call.

        In a function, these are the result and all variables; in a block, the temporary
        variables.
        """
        function = self._pou.kind == "FUNCTION"
        first = self._pou.body[0] if self._pou.body else None
        at_once = first.target if isinstance(first, t.Assign) else None
        for symbol in self._symbols():
            self._at = symbol.at
            inside = symbol.section in ("VAR", "RESULT") and function
            soon = isinstance(at_once, t.Use) and at_once.symbol is symbol
            soon = soon and symbol.section == "RESULT"
            if (inside and not soon) or symbol.section == "VAR_TEMP":
                yield from self._begun(symbol)

    def _initialised(self) -> Iterator[str]:
        """Yield lines that set variables to their initial values at the start.

        Inputs, VAR_IN_OUT, temporary and retained variables are not set. Variables that a program
        never writes are not set either, because their values come from outside.
        """
        own = written(self._pou, self._pous) if self._pou.kind == "PROGRAM" else None
        retained = retain(self._part)
        for symbol in self._pou.symbols.values():
            self._at = symbol.at
            kept = symbol.section in ("VAR_IN_OUT", "VAR_INPUT", "VAR_TEMP")
            kept = kept or symbol.name.upper() in retained
            passed_out = symbol.section == "VAR_OUTPUT" and is_whole(symbol.type)
            outside = own is not None and symbol.name not in own
            outside = outside and not (is_whole(symbol.type) and not is_zero(symbol.initial))
            if not (kept or passed_out or outside or isinstance(symbol.type, BlockType)):
                yield from self._begun(symbol)
            if isinstance(symbol.type, BlockType):
                for pin in passed(symbol.type.variables):
                    if pin.section != "VAR_IN_OUT":
                        yield self._emptied(companion(symbol.name, pin.name), pin.type)
                if own is None:
                    yield from self._inputs(symbol.name, symbol.type)

    def _check_set(self, symbol: t.Symbol) -> None:
        """Refuse an initial value that statements at the start cannot set.

        Raise NotCarriedError for the value of a pin, a retained variable or a process image.
        """
        given = symbol.section == "VAR_INPUT" and self._pou.kind == "FUNCTION"
        pin = symbol.section in ("VAR_INPUT", "VAR_OUTPUT", "RESULT") and not given
        kept = symbol.name.upper() in retain(self._part) and symbol.section == "VAR"
        image = (
            isinstance(symbol.type, ArrayType)
            and image_element(symbol.type.name, self._images) != ""
        )
        if pin or kept or image:
            raise NotCarriedError(f"{symbol.name} has an initial value that is not a single number")

    def _begun(self, symbol: t.Symbol) -> Iterator[str]:
        """Yield lines that set a variable to its initial value.

        For a structure or array, there is a line for each scalar inside it that is not zero.
        """
        if is_zero(symbol.initial) or not isinstance(symbol.type, StructType | ArrayType):
            yield self._initial(symbol)
            return
        yield self._initial(replace(symbol, initial=None))
        leaves = differing(symbol.name, symbol.initial, zero(symbol.type), symbol.type, str)
        yield from (f"{path} := {value_text(value, kind)};" for path, value, kind in leaves)

    def _inputs(self, instance: str, block: BlockType) -> Iterator[str]:
        """Yield lines that set the inputs of a nested block instance to their defaults."""
        pou = self._pous.get(block.name.upper())
        for pin in block.variables:
            if pin.section == "VAR_INPUT" and not is_whole(pin.type):
                initial = pou.symbols[pin.name.upper()].initial if pou is not None else 0
                yield f"{instance}.{pin.name} := {value_text(initial or 0, pin.type)};"

    def _initial(self, symbol: t.Symbol) -> str:
        name = RESULT if symbol.section == "RESULT" else symbol.name
        if is_whole(symbol.type) and is_zero(symbol.initial):
            return self._emptied(name, symbol.type)
        initial = 0 if symbol.initial is None else symbol.initial
        return f"{name} := {value_text(initial, symbol.type)};"

    def _emptied(self, name: str, kind: Type) -> str:
        """Return a line that sets a whole tag to 0.

        The line copies from a tag that is always 0, because FLL exists in ladder only.
        """
        data = data_of(kind, self._images)
        if data == Data("STRING"):
            return f"{name} := '';"
        zeros = check_name(f"Zero_{data.type}{f'_{data.size}' if data.size else ''}")
        self._zeros[zeros] = data
        return copied(zeros, name, kind, self._images)

    # --- statements -----------------------------------------------------------------------

    def _returned(self, body: Sequence[t.Statement], indent: str) -> list[str]:
        """Return the statements of the whole POU, without RETURN.

        The code behind an `IF … THEN RETURN` moves into an IF with the opposite condition.
        """
        lines: list[str] = []
        for place, one in enumerate(body):
            if _returns(one):
                assert isinstance(one, t.If)
                self._expressions.begin()
                self._at = one.at
                lines += self._noted(one, indent)
                asked = one.branches[0][0]
                inverted = isinstance(asked, t.Unary)
                condition = self._expressions.text(
                    asked.operand if isinstance(asked, t.Unary) else asked
                )
                lines += self._taken(indent)
                lines.append(f"{indent}IF {condition if inverted else f'NOT ({condition})'} THEN")
                lines += self._returned(body[place + 1 :], indent + _STEP)
                return [*lines, f"{indent}END_IF;"]
            lines += self._statement(one, indent)
        return lines

    def _statements(self, body: Sequence[t.Statement], indent: str) -> list[str]:
        return [line for one in body for line in self._statement(one, indent)]

    def _noted(self, one: t.Statement, indent: str) -> list[str]:
        """Return the comments above and beside a statement that are not written yet."""
        lines = []
        while self._comments and self._comments[0][0] <= one.at.line:
            lines.append(f"{indent}(* {self._comments.pop(0)[1]} *)")
        return lines

    def _taken(self, indent: str) -> list[str]:
        return [indent + line for line in self._expressions.take()]

    def _statement(self, one: t.Statement, indent: str) -> list[str]:
        self._expressions.begin()
        self._at = one.at
        lines = self._noted(one, indent)
        if isinstance(one, t.Assign):
            return lines + self._assign(one.target, one.value, indent)
        if isinstance(one, t.CallBlock):
            return lines + self._call(one, indent)
        if isinstance(one, t.If):
            return lines + self._if(one.branches, one.otherwise, indent)
        if isinstance(one, t.Case):
            return lines + self._case(one, indent)
        if isinstance(one, t.While):
            condition = self._expressions.text(one.condition)
            before = self._expressions.take()
            lines += [indent + line for line in before]
            lines.append(f"{indent}WHILE {condition} DO")
            lines += self._statements(one.body, indent + _STEP)
            lines += [indent + _STEP + line for line in before]
            return [*lines, f"{indent}END_WHILE;"]
        if isinstance(one, t.Repeat):
            lines += [f"{indent}REPEAT", *self._statements(one.body, indent + _STEP)]
            self._expressions.begin()
            condition = self._expressions.text(one.condition)
            lines += self._taken(indent + _STEP)
            return [*lines, f"{indent}UNTIL {condition}", f"{indent}END_REPEAT;"]
        if isinstance(one, s.Exit):
            return [*lines, f"{indent}EXIT;"]
        if isinstance(one, t.For):
            raise NotCarriedError("a FOR loop")
        raise NotCarriedError("a RETURN that is not the only statement of an IF")

    def _assign(self, target: t.Variable, value: t.Expression, indent: str) -> list[str]:
        place = self._expressions.variable(target)
        whole = is_whole(target.type)
        line = self._whole(place, value) if whole else self._scalar(target, place, value)
        return [*self._taken(indent), indent + line]

    def _whole(self, place: str, value: t.Expression) -> str:
        text = self._expressions.text(value)
        if isinstance(value, t.Constant):
            return f"{place} := {text};"
        return copied(text, place, value.type, self._images)

    def _scalar(self, target: t.Variable, place: str, value: t.Expression) -> str:
        image = image_element(_array_name(target), self._images)
        if image:
            bits = {"SINT": 8, "INT": 16}[image]
            kept = self._expressions.kept(value)
            return f"{place} := {fold(kept, bits)[1:-1]};"
        if isinstance(value, t.Standard) and value.name == "REAL_TO_DINT":
            return f"{place} := {self._expressions.text(value.arguments[0])};"
        if isinstance(value, t.Standard) and value.name == "DINT_TO_REAL":
            return f"{place} := {self._expressions.kept(value.arguments[0])};"
        return f"{place} := {self._expressions.text(value)};"

    def _call(self, one: t.CallBlock, indent: str) -> list[str]:
        instance = self._expressions.variable(one.instance)
        given = dict(one.in_outs)
        inputs = []
        for pin, value in one.inputs:
            if is_whole(value.type):
                inputs.append(self._whole(companion(instance, pin), value))
            else:
                inputs.append(f"{instance}.{pin} := {self._expressions.text(value)};")
        arguments = [instance]
        for variable in passed(one.block.variables):
            if variable.name in given:
                arguments.append(self._expressions.variable(given[variable.name]))
            else:
                arguments.append(companion(instance, variable.name))
        lines = self._taken(indent)
        lines += [indent + line for line in inputs]
        name = STANDARD_BLOCKS.get(one.block.name, one.block.name)
        lines.append(f"{indent}{name}({', '.join(arguments)});")
        for pin, target in one.outputs:
            kind = next(pins.type for pins in one.block.variables if pins.name == pin)
            lines += self._assign(target, t.Member(one.instance, pin, kind), indent)
        return lines

    def _if(
        self,
        branches: tuple[tuple[t.Expression, tuple[t.Statement, ...]], ...],
        otherwise: tuple[t.Statement, ...],
        indent: str,
    ) -> list[str]:
        """Return the lines of an IF.

        If the condition of an ELSIF needs statements before it, it becomes an IF in the ELSE.
        """
        lines: list[str] = []
        for place, (condition, body) in enumerate(branches):
            self._expressions.begin()
            text = self._expressions.text(condition)
            before = self._expressions.take()
            if place and before:
                lines.append(f"{indent}ELSE")
                lines += self._if(branches[place:], otherwise, indent + _STEP)
                return [*lines, f"{indent}END_IF;"]
            lines += [indent + line for line in before]
            lines.append(f"{indent}{'ELSIF' if place else 'IF'} {text} THEN")
            lines += self._statements(body, indent + _STEP)
        if otherwise:
            lines += [f"{indent}ELSE", *self._statements(otherwise, indent + _STEP)]
        return [*lines, f"{indent}END_IF;"]

    def _case(self, one: t.Case, indent: str) -> list[str]:
        selector = self._expressions.kept(one.selector)
        members = getattr(one.selector.type, "members", None)
        lines = [*self._taken(indent), f"{indent}CASE {selector} OF"]
        for labels, body in one.branches:
            shown = ", ".join(str(a) if a == b else f"{a}..{b}" for a, b in labels)
            if members:
                shown += f"(*{', '.join(members[a] for a, _ in labels)}*)"
            lines.append(f"{indent}{_STEP}{shown}:")
            lines += self._statements(body, indent + 2 * _STEP)
        if one.otherwise:
            lines += [f"{indent}ELSE", *self._statements(one.otherwise, indent + _STEP)]
        return [*lines, f"{indent}END_CASE;"]


def _returns(one: t.Statement) -> bool:
    return (
        isinstance(one, t.If)
        and len(one.branches) == 1
        and not one.otherwise
        and len(one.branches[0][1]) == 1
        and isinstance(one.branches[0][1][0], s.Return)
    )


def _array_name(node: t.Variable) -> str:
    return str(getattr(node.base.type, "name", "")).upper() if isinstance(node, t.Index) else ""


def copied(source: str, target: str, kind: Type, images: Images) -> str:
    """Return the instruction that copies a structure, an array or a STRING."""
    if size := data_of(kind, images).size:
        return f"COP({source}[0], {target}[0], {size});"
    return f"COP({source}, {target}, 1);"


def _comments(part: Part) -> list[tuple[int, str]]:
    """Return the comments between statements, each with its line in the file."""
    return [
        (part.line + part.body.count("\n", 0, one.start()), " ".join(one[1].split()))
        for one in _COMMENT.finditer(part.body)
        if one[1] is not None
    ]
