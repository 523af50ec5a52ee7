"""The statements of the blocks of a sheet, and the values at their pins."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from structured_text.errors import COMMAND, VARIABLES, near
from structured_text.projects.rockwell.data import INTEGERS, Data, First
from structured_text.projects.rockwell.expression_reader import Routine, Value, bare
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import LadderError
from structured_text.projects.rockwell.ladder.operands import OperandReader
from structured_text.projects.rockwell.ladder.paths import Path, paths_of
from structured_text.projects.rockwell.sheets.blocks import (
    CALLED,
    FUNCTIONS,
    GATES,
    Called,
    Function,
)
from structured_text.projects.rockwell.sheets.model import Node
from structured_text.projects.rockwell.sheets.order import Feed, Graph
from structured_text.projects.rockwell.sheets.structures import STRUCTURES
from structured_text.projects.rockwell.subroutines import jump_of

__all__ = ["Blocks", "no_array"]

_ENABLE_IN, _ENABLE_OUT = "ENABLEIN", "ENABLEOUT"


@dataclass
class Blocks:
    """The translation of single elements.

    Attributes:
        body: The routine, and the variables that the translation adds.
        graph: The lines of the routine.
        variables: The variables with the values of functions, by the `id` of the element.
        latched: The variables with the latched values of input references.
        kinds: The types of the variables, by their names in upper case.
    """

    body: Body
    graph: Graph
    variables: dict[str, str] = field(default_factory=dict)
    latched: dict[str, str] = field(default_factory=dict)
    kinds: dict[str, Data] = field(default_factory=dict)

    def __post_init__(self) -> None:
        tags = ChainMap(self.kinds, dict(self.body.routine.tags))
        self.scope = replace(self.body.routine, tags=tags)

    # --- values ---------------------------------------------------------------------------

    def reader(self, text: str, node: Node) -> OperandReader:
        """Return the reader of a text in the language of Logix, which may name the variables."""
        return OperandReader(text, node.at, self.scope)

    def add_variable(self, name: str, kind: str, *, kept: bool = False) -> str:
        """Return a new variable of the translation."""
        made = self.body.variable(name, kind, kept=kept)
        self.kinds[made.upper()] = Data(kind)
        return made

    def remember(self, node: Node) -> None:
        """Declare the variable of a function whose value of the last scan is used."""
        kind = "BOOL"
        if node.name not in (*GATES, "BNOT"):
            structure = FUNCTIONS[node.name].type if node.name in FUNCTIONS else "SELECT"
            members = STRUCTURES[structure].members()
            kind = members["DEST" if "DEST" in members else "OUT"].type
        self.variables[node.id] = self.add_variable(f"{node.name}_{node.id}", kind, kept=True)

    def latch(self, node: Node) -> str:
        """Return the statement that latches an input reference."""
        text, kind = self.reader(_operand(node), node).value()
        self.latched[node.id] = name = self.add_variable(f"Input_{node.id}", kind)
        return f"{name} := {bare(text)};"

    def source(self, feed: Feed) -> str:
        """Return the value of an output in the language of Logix."""
        node, pin = feed.node, feed.output
        if node.kind == "IRef":
            return self.latched.get(node.id) or _operand(node)
        if node.kind == "Function":
            return self.variables[node.id]
        if node.kind in ("Block", "AddOnInstruction"):
            block = self.body.routine.types.instructions.get(node.name.upper())
            if pin.upper() == _ENABLE_OUT and block is not None and not block.enable_out:
                text = (
                    f"EnableOut of {node.name} is not supported, because its logic does not set it"
                )
                raise _wrong(node, text, "remove the wire")
            return f"{node.operand}.{pin}"
        raise _wrong(node, f"return parameters of {node.kind} are not supported", _hint())

    def paths(self, node: Node) -> frozenset[Path]:
        """Return the tags that a reference names."""
        reader = self.reader(_operand(node), node)
        return paths_of(reader.value()[0] if node.kind == "IRef" else reader.tag()[0])

    def written(self, node: Node) -> frozenset[Path] | None:
        """Return the tags that a block may write; None if it may write any tag."""
        if node.kind == "JSR":
            return None
        found: frozenset[Path] = frozenset()
        if node.kind in ("Block", "AddOnInstruction"):
            for text in (node.operand, *node.arguments.values()):
                if text:
                    found |= paths_of(self.reader(text, node).tag(element=False)[0])
        return found

    def assigned(self, node: Node) -> list[str]:
        """Return the assignment of an output reference."""
        for _, feed in self.graph.inputs(node):
            target = self.reader(_operand(node), node)
            tag = target.tag(written=True)
            if target.varying_bit():
                raise _wrong(node, "a bit with a varying number cannot be written", "use a number")
            value = self.reader(self.source(feed), feed.node).value()
            return [target.assigned(tag, value)]
        raise _wrong(node, "it is not connected", "connect it, or remove it")

    # --- blocks ---------------------------------------------------------------------------

    def statements(self, node: Node) -> list[str]:
        """Return the statements of an element that is executed."""
        if node.kind in ("SBR", "RET", "JSR"):
            if node.arguments or any(True for _ in self.graph.inputs(node)):
                text = f"parameters of {node.kind} are not supported in a function block diagram"
                raise _wrong(node, text, "pass the values by tags")
            return [self._jump(node)] if node.kind == "JSR" else []
        if node.kind == "AddOnInstruction":
            return self._add_on(node)
        if node.kind == "Function":
            return self._function(node)
        name = node.name.upper()
        if name in CALLED:
            return [self._called(node, CALLED[name])]
        if name in FUNCTIONS:
            return self._calculated(node, FUNCTIONS[name])
        known = sorted({*CALLED, *FUNCTIONS})
        text = f"the instruction {node.name} is not supported"
        raise _wrong(node, text, f"{near(name, known, 'similar:')}; {_hint()}")

    def _jump(self, node: Node) -> str:
        self.body.first.append(First(routine=node.name.upper()))
        return jump_of((node.name, "0"), node.at, self.body.routine)

    def _instance(self, node: Node, kind: str) -> str:
        """Return the tag of a block, whose structure must be `kind`."""
        if not node.operand:
            raise _wrong(node, "it has no tag", "complete the block in its tool")
        text, data = self.reader(node.operand, node).tag()
        defined = self.body.routine.types.instructions
        if data.sizes or data.type.upper() != kind or (kind in defined and kind in STRUCTURES):
            raise _wrong(node, f"{node.operand} is not a {kind}", f"use a tag of the type {kind}")
        return text

    def _inputs(self, node: Node, inputs: Mapping[str, Data]) -> Iterator[tuple[str, str]]:
        """Yield the wired pins of a block with their values."""
        for pin, feed in self.graph.inputs(node):
            kind = inputs.get(pin.upper())
            if kind is None:
                names = ", ".join(sorted(inputs)) or "none"
                text = f"{pin or 'a wire without a pin'} is not an input of {node.name}"
                raise _wrong(node, text, f"the inputs are {names}")
            reader = self.reader(self.source(feed), feed.node)
            yield pin, bare(reader.converted(reader.value(), kind.type))

    def _called(self, node: Node, called: Called) -> str:
        instance = self._instance(node, called.type)
        inputs = STRUCTURES[called.type].of_inputs()
        arguments = [f"{pin} := {text}" for pin, text in self._inputs(node, inputs)]
        arguments += [called.settings] if called.settings else []
        for name in called.arrays:
            text = node.arguments.get(name.upper(), "")
            if not text and name in called.optional:
                arguments.append(f"{name} := {no_array(self.body.routine)}")
                continue
            if not text:
                raise _wrong(node, f"it has no {name}", "complete the block in its tool")
            tag, data = self.reader(text, node).tag(element=False)
            if data.type != "REAL" or len(data.sizes) != 1:
                raise _wrong(node, f"{text} is not an array of REAL", f"use one for {name}")
            arguments.append(f"{name} := {tag}")
        return f"{instance}({', '.join(arguments)});"

    def _calculated(self, node: Node, function: Function) -> list[str]:
        """Return the statements of a block with a structure of data."""
        instance = self._instance(node, function.type)
        inputs = STRUCTURES[function.type].of_inputs()
        names = {name.upper(): name for name in function.inputs}
        if function.inputs == ("Source",) and "SOURCE" not in inputs:
            names = {"SOURCE": "SourceA", "SOURCEA": "SourceA"}
        pins = {**{pin: inputs[name.upper()] for pin, name in names.items()}}
        pins[_ENABLE_IN] = Data("BOOL")
        found = dict(self._inputs(node, pins))
        lines = [
            f"{instance}.{names.get(pin.upper(), 'EnableIn')} := {text};"
            for pin, text in found.items()
        ]
        texts = {name: f"{node.operand}.{names[name.upper()]}" for name in function.inputs}
        value = self._value(node, function, texts)
        target = self.reader(f"{node.operand}.{function.output}", node)
        lines_of_value = [target.assigned(target.tag(written=True), value)]
        seen = self.body.routine.types.read_members
        if _ENABLE_IN in {pin.upper() for pin in found} or _ENABLE_IN in seen:
            lines += [f"{instance}.EnableOut := {instance}.EnableIn;"]
            lines += [f"IF {instance}.EnableIn THEN"]
            return [*lines, *(f"  {line}" for line in lines_of_value), "END_IF;"]
        if _ENABLE_OUT in seen:
            lines.append(f"{instance}.EnableOut := TRUE;")
        return [*lines, *lines_of_value]

    def _function(self, node: Node) -> list[str]:
        """Return the assignment of the value of a function to its variable."""
        feeds = {pin.upper(): self.source(feed) for pin, feed in self.graph.inputs(node)}
        value = self._of_function(node, feeds)
        name = self.variables.get(node.id)
        if name is None:
            name = self.variables[node.id] = self.add_variable(f"{node.name}_{node.id}", value[1])
        return [self.reader(name, node).assigned((name, self.kinds[name.upper()]), value)]

    def _of_function(self, node: Node, feeds: Mapping[str, str]) -> Value:
        function = FUNCTIONS.get(node.name)
        if function is not None:
            return self._value(node, function, _all(node, function.inputs, feeds))
        if node.name in GATES:
            texts = [text for pin, text in sorted(feeds.items()) if pin.startswith("IN")]
            if len(texts) < len(feeds) or len(texts) < 2:
                raise _wrong(node, "it needs two or more inputs", "connect them")
            found = self._flag(node, f" {GATES[node.name]} ".join(texts))
        elif node.name == "BNOT":
            found = self._flag(node, f"NOT ({_all(node, ('In',), feeds)['In']})")
        elif node.name == "SEL":
            texts = list(_all(node, ("SelectorIn", "In1", "In2"), feeds).values())
            values = [self.reader(text, node).value() for text in texts]
            kind = "REAL" if "REAL" in (values[1][1], values[2][1]) else values[1][1]
            made = [
                self.reader(text, node).converted(value, kind)
                for text, value in zip(texts[1:], values[1:], strict=True)
            ]
            selector = self.reader(texts[0], node).converted(values[0], "BOOL")
            found = f"SEL({bare(selector)}, {bare(made[0])}, {bare(made[1])})", kind
        else:
            known = sorted({*FUNCTIONS, *GATES, "BNOT", "SEL"})
            text = f"the function {node.name} is not supported"
            raise _wrong(node, text, f"{near(node.name, known, 'similar:')}; {_hint()}")
        return found

    def _flag(self, node: Node, text: str) -> Value:
        value = self.reader(text, node).value()
        if value[1] != "BOOL":
            raise _wrong(node, f"its inputs are {value[1]}, not BOOL", "connect inputs of BOOL")
        return value

    def _value(self, node: Node, function: Function, texts: Mapping[str, str]) -> Value:
        if function.expression:
            return self.reader(function.expression.format(**texts), node).value()
        reader = self.reader(texts["Source"], node)
        value = reader.value()
        if value[1] not in INTEGERS:
            raise _wrong(node, f"its source is a {value[1]}, not a whole number", "convert it")
        return _BCD[node.name.upper()](reader, value)

    # --- Add-On Instructions --------------------------------------------------------------

    def _add_on(self, node: Node) -> list[str]:
        types = self.body.routine.types
        name = node.name.upper()
        if name in types.protected:
            text = f"the source of {node.name} is protected and not in the file"
            raise _wrong(node, text, "write it in Structured Text, and call that")
        block = types.instructions.get(name)
        if block is None:
            raise _wrong(
                node, f"there is no instruction {node.name} in this file", "export it, too"
            )
        instance = self._instance(node, name)
        kinds = types.members[name]
        inputs = {pin: kinds[pin] for pin, usage in block.usages.items() if usage == "Input"}
        found = dict(self._inputs(node, {**inputs, _ENABLE_IN: Data("BOOL")}))
        enable = next((found.pop(pin) for pin in list(found) if pin.upper() == _ENABLE_IN), "")
        arguments = [f"{pin} := {text}" for pin, text in found.items()]
        if block.false_routine:
            arguments.insert(0, f"EnableIn := {enable or 'TRUE'}")
        for pin, usage in block.usages.items():
            if usage != "InOut":
                continue
            given = node.arguments.get(pin, "")
            if not given:
                raise _wrong(node, f"it has no argument for {pin}", "complete it in its tool")
            text, data = self.reader(given, node).tag()
            kind = kinds[pin]
            if (data.type.upper(), data.sizes) != (kind.type.upper(), kind.sizes) or data.stored:
                sizes = "".join(f"[{size}]" for size in kind.sizes)
                raise _wrong(node, f"{given} is not a {kind.type}{sizes}", "use a tag of this type")
            arguments.append(f"{pin} := {text}")
        call = f"{instance}({', '.join(arguments)});"
        if enable and not block.false_routine:
            return [f"IF {enable} THEN", f"  {call}", "END_IF;"]
        return [call]


def no_array(routine: Routine) -> str:
    """Return a variable in place of an array that is optional, and declare it."""
    name = f"{VARIABLES}NoArray"
    routine.added[name] = routine.types.written(Data("REAL", (1,)))
    return name


def _operand(node: Node) -> str:
    """Return the text of a reference; a negative number is in parentheses."""
    if not node.operand or node.operand == "?":
        raise _wrong(node, "it names no tag", "complete it in its tool")
    return f"({node.operand})" if node.operand.startswith("-") else node.operand


def _all(node: Node, names: tuple[str, ...], feeds: Mapping[str, str]) -> dict[str, str]:
    """Return the values of all inputs of a function, or raise LadderError."""
    for pin in feeds:
        if pin not in {name.upper() for name in names}:
            text = f"{pin or 'a wire without a pin'} is not an input"
            raise _wrong(node, text, f"the inputs are {', '.join(names)}")
    for name in names:
        if name.upper() not in feeds:
            raise _wrong(node, f"its input {name} is not connected", "connect it")
    return {name: feeds[name.upper()] for name in names}


def _to_bcd(reader: OperandReader, value: Value) -> Value:
    text = f"DINT_TO_UDINT(ABS({bare(reader.converted(value, 'DINT'))}))"
    return f"DWORD_TO_DINT(UDINT_TO_BCD_DWORD({text}))", "DINT"


def _from_bcd(reader: OperandReader, value: Value) -> Value:
    bits = f"DINT_TO_DWORD({bare(reader.converted(value, 'DINT'))})"
    return f"UDINT_TO_DINT(DWORD_BCD_TO_UDINT({bits}))", "DINT"


_BCD: Mapping[str, Callable[[OperandReader, Value], Value]] = {
    "TOD": _to_bcd,
    "TO_BCD": _to_bcd,
    "FRD": _from_bcd,
    "BCD_TO": _from_bcd,
}


def _hint() -> str:
    return f"write the routine in Structured Text: {COMMAND} --replace Program.Routine=file.st"


def _wrong(node: Node, text: str, hint: str) -> LadderError:
    """Return the error for an element; the caller adds the sheet and the element."""
    return LadderError(text, node.at, hint)
