"""The robots of a program, and the blocks called for each of them, from its checked source.

A robot is a variable of type RCX_REF. The calls are followed from the program instances through the
user's own blocks, so that a robot is recognised behind each VAR_IN_OUT.
"""

from __future__ import annotations

from collections.abc import Container, Mapping
from dataclasses import dataclass, field

from rcx_harness.watch.calls_source import AREAS
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, StructType, Type
from structured_text.language.walk import nodes, parts

__all__ = ["Call", "Place", "Robot", "RobotsUsed", "pins_of", "robot_pins"]

_REF = "RCX_REF"

#: A variable by its names in upper case, from the program instance on; globals begin with "".
Place = tuple[str, ...]


def robot_pins(block: BlockType) -> list[str]:
    """Return the names of a block's VAR_IN_OUT of type RCX_REF, in upper case."""
    return [
        one.name.upper()
        for one in block.variables
        if one.section == "VAR_IN_OUT" and _is_robot(one.type)
    ]


def pins_of(block: BlockType) -> set[str]:
    """Return the names of a block's VAR_INPUT, in upper case."""
    return {one.name.upper() for one in block.variables if one.section == "VAR_INPUT"}


@dataclass(frozen=True, eq=False)
class _Frame:
    """A program, or one instance of a user's block that is called.

    Attributes:
        pou: The code of the program or block.
        place: The path of the instance; None if the source does not decide it.
        bound: The arguments of the block's VAR_IN_OUT, by name in upper case.
    """

    pou: t.Pou
    place: Place | None
    bound: Mapping[str, Place | None] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Call:
    """A call of a block for a robot.

    Attributes:
        instance: The path of the called instance; None if the source does not decide it.
        image: The process image among the arguments; None if there is none.
        frame: The frame of the program or block that makes the call.
    """

    pou: t.Pou
    file: str
    node: t.CallBlock
    name: str
    instance: Place | None
    image: Place | None
    frame: _Frame

    @property
    def block(self) -> BlockType:
        """Return the type of the called block."""
        return self.node.block

    @property
    def area(self) -> str:
        """Return `read` or `write` for an area block, else an empty text."""
        return AREAS.get(self.block.name.upper(), "")


@dataclass
class Robot:
    """A robot and the calls for it.

    Attributes:
        name: The name of the robot in messages.
        copy: If a block takes the robot as a copy: its VAR_INPUT, and this block.
        known: Whether the source decides every use of the robot.
    """

    name: str
    calls: list[Call] = field(default_factory=list)
    copy: tuple[t.Symbol, t.Pou] | None = None
    known: bool = True

    @property
    def others(self) -> list[Call]:
        """Return the calls of blocks other than area blocks."""
        return [one for one in self.calls if not one.area]


class RobotsUsed:
    """The robots of a project.

    Args:
        files: The user's files; the code of the library's blocks is not followed.

    Attributes:
        pous: The user's programs and blocks that are called.
        read_any: Whether FB_ReadArea is called for a robot that the source does not decide.
        written_any: Whether FB_WriteArea is called for such a robot.
        set_apart: Pins that are assigned outside of a call: (block, pin), in upper case.
    """

    def __init__(self, project: Project, files: Container[str]) -> None:
        self._project, self._files = project, files
        self.robots: dict[Place, Robot] = {}
        self.pous: list[t.Pou] = []
        self.read_any = self.written_any = False
        self.set_apart: set[tuple[str, str]] = set()
        self._globals = {id(symbol): key for key, symbol in project.global_symbols.items()}
        self._texts: dict[Place, str] = {}
        self._unsettled: set[Place] = set()
        self._given: dict[tuple[Place | None, str], list[tuple[t.Expression, _Frame]]] = {}
        self._seen: set[object] = set()
        self._members: set[tuple[t.Pou, str]] = set()
        self._bare: set[tuple[t.Pou, str]] = set()
        self._called_inside: set[str] = set()
        for name, block in project.instances.items():
            place: Place = (name.upper(),)
            self._texts[place] = ""
            self._walk(_Frame(project.pous[block.name.upper()], place))
        for place, robot in self.robots.items():
            parts = (place[:length] for length in range(1, len(place) + 1))
            robot.known = not any(part in self._unsettled for part in parts)

    def stays_false(self, call: Call, pin: str) -> bool:
        """Return whether a call leaves an input FALSE, as far as the source shows."""
        given = [value for name, value in call.node.inputs if name.upper() == pin.upper()]
        if given:
            return self._is_false(given[0], call.frame)
        instance = call.node.instance
        start = instance.symbol.initial if isinstance(instance, t.Use) else None
        return not (isinstance(start, dict) and start.get(pin))

    def only_members(self, pou: t.Pou, symbol: t.Symbol) -> bool:
        """Return whether the owner uses only pins of an instance, never the whole instance."""
        key = pou, symbol.name.upper()
        objects = self._project.objects
        inherits = objects.derived(pou.name.upper()) or pou.name.upper() in objects.extended
        used_whole = key in self._bare or key[1] in self._called_inside
        return key in self._members and not used_whole and not inherits

    def is_used(self, pou: t.Pou, symbol: t.Symbol) -> bool:
        """Return whether the owner calls an instance, or passes it on."""
        return (pou, symbol.name.upper()) in self._bare

    def initial_of(self, block: BlockType, pin: str) -> object:
        """Return the initial value of an input of a block; None if it has none."""
        pou = self._project.pous.get(block.name.upper())
        symbol = pou.symbols.get(pin.upper()) if pou is not None else None
        return symbol.initial if symbol is not None else None

    def input_place(self, value: t.Expression, frame: _Frame) -> Place | None:
        """Return the path of a variable that the program never writes; None for anything else.

        The input of a user's block is replaced by its argument.
        """
        if not isinstance(value, t.Use) or frame.place is None:
            return None
        symbol, key = value.symbol, value.symbol.name.upper()
        if symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL"):
            name = symbol.source.upper() or self._globals.get(id(symbol), key)
            written = any(name == variable for _, variable in self.set_apart)
            return None if written else ("", name)
        if frame.pou.symbols.get(key) is not symbol or symbol.section not in ("VAR", "VAR_INPUT"):
            return None
        if (frame.pou.name.upper(), key) in self.set_apart:
            return None
        given = self._given.get((frame.place, key), [])
        if given and symbol.section == "VAR_INPUT":
            return self.input_place(*given[0]) if len(given) == 1 else None
        return (*frame.place, key)

    def _is_false(self, value: t.Expression, frame: _Frame) -> bool:
        """Return whether an expression is always FALSE, such as an input that is not wired."""
        if isinstance(value, t.Constant):
            return value.value is False
        if not isinstance(value, t.Use) or frame.pou.kind != "FUNCTION_BLOCK":
            return False
        symbol, key = value.symbol, value.symbol.name.upper()
        if frame.pou.symbols.get(key) is not symbol or symbol.section != "VAR_INPUT":
            return False
        if symbol.initial or (frame.pou.name.upper(), key) in self.set_apart or not frame.place:
            return False
        given = self._given.get((frame.place, key), [])
        return all(self._is_false(one, outer) for one, outer in given)

    # --- following the calls ---

    def _walk(self, frame: _Frame) -> None:
        key = (frame.pou, frame.place, tuple(sorted(frame.bound.items(), key=lambda one: one[0])))
        if key in self._seen:
            return
        self._seen.add(key)
        if frame.pou not in self.pous:
            self.pous.append(frame.pou)
        name = frame.pou.name.upper()
        bodies = [frame.pou, *self._project.objects.all.get(name, {}).values()]
        above = self._project.objects.extended.get(name, "")
        while above:
            bodies.append(self._project.pous[above])
            above = self._project.objects.extended.get(above, "")
        for pou in bodies:
            if pou.file not in self._files:  # the block extends a block of the library
                continue
            self._note_uses(frame.pou, pou.body)
            for node in nodes(pou.body):
                self._take(node, frame, pou)

    def _take(self, node: object, frame: _Frame, pou: t.Pou) -> None:
        if isinstance(node, t.CallBlock):
            self._call(node, frame, pou)
        elif isinstance(node, t.Assign):
            self._written(node.target, frame)
            if _has_robot(node.value.type):  # the robot is a copy, so its requests are not certain
                self._let_go(node.value, frame, pou)
                self._let_go(node.target, frame, pou)
        elif isinstance(node, (t.CallFunction, t.CallMethod)):
            for _, variable in (*node.in_outs, *node.outputs):
                self._written(variable, frame)
                self._let_go(variable, frame, pou)
            if isinstance(node, t.CallMethod):
                self._method(node.instance, frame, pou)
        elif isinstance(node, t.Address):
            self._written(node.variable, frame)
            self._let_go(node.variable, frame, pou)

    def _call(self, node: t.CallBlock, frame: _Frame, pou: t.Pou) -> None:
        instance = self._place(node.instance, frame, pou)
        if isinstance(node.instance, t.Member):
            self._called_inside.add(node.instance.name.upper())
        for _, variable in (*node.outputs, *node.in_outs):
            self._written(variable, frame)
        bound = {name.upper(): self._place(one, frame, pou) for name, one in node.in_outs}
        name, image = _text(node.instance), bound.get("IMAGE")
        call = Call(frame.pou, pou.file, node, name, instance, image, frame)
        inner = self._project.pous.get(node.block.name.upper())
        follow = inner is not None and inner.file in self._files and not call.area
        for pin in robot_pins(node.block):
            self._note_call(call, bound.get(pin), follow=follow)
        if inner is not None and follow:
            for name, value in node.inputs:
                self._given.setdefault((instance, name.upper()), []).append((value, frame))
            self._walk(_Frame(inner, instance, bound))

    def _method(self, instance: t.Expression, frame: _Frame, pou: t.Pou) -> None:
        """Follow a block whose method is called, because the block itself may never be called."""
        if isinstance(instance, t.This) or not isinstance(instance.type, BlockType):
            return
        inner = self._project.pous.get(instance.type.name.upper())
        if inner is not None and inner.file in self._files:
            self._walk(_Frame(inner, self._place(instance, frame, pou)))

    def _note_call(self, call: Call, place: Place | None, *, follow: bool) -> None:
        if place is None:
            self.read_any = self.read_any or call.area == "read"
            self.written_any = self.written_any or call.area == "write"
            return
        robot = self.robots.setdefault(place, Robot(self._texts[place]))
        if not follow:
            robot.calls.append(call)
        own = call.frame.place == place[:-1]
        symbol = call.frame.pou.symbols.get(place[-1]) if own else None
        if symbol is not None and symbol.section == "VAR_INPUT":
            robot.copy = symbol, call.frame.pou

    def _written(self, variable: t.Expression, frame: _Frame) -> None:
        """Record an input of a block that is assigned outside of a call."""
        if isinstance(variable, t.Member) and isinstance(variable.base.type, BlockType):
            self.set_apart.add((variable.base.type.name.upper(), variable.name.upper()))
        elif isinstance(variable, t.Use):
            self.set_apart.add((frame.pou.name.upper(), variable.symbol.name.upper()))

    def _let_go(self, variable: t.Expression, frame: _Frame, pou: t.Pou) -> None:
        """Record that the source does not decide the further use of a variable."""
        place = self._place(variable, frame, pou)
        if place is not None:
            self._unsettled.add(place)

    def _note_uses(self, owner: t.Pou, node: object) -> None:
        """Record the instances whose pins are used, and the instances that are used as a whole."""
        if isinstance(node, t.Member) and isinstance(node.base, t.Use):
            self._members.add((owner, node.base.symbol.name.upper()))
        elif isinstance(node, t.Use):
            self._bare.add((owner, node.symbol.name.upper()))
        else:
            for one in parts(node):
                self._note_uses(owner, one)

    # --- paths of variables ---

    def _place(self, variable: t.Expression, frame: _Frame, pou: t.Pou) -> Place | None:
        """Return the path of a variable; None if the source does not decide it."""
        if isinstance(variable, t.Use):
            return self._of_symbol(variable.symbol, frame, pou)
        if isinstance(variable, t.This):
            return frame.place
        if isinstance(variable, t.Member):
            return self._inside(variable.base, variable.name, frame, pou)
        if isinstance(variable, t.Index):
            numbers = [one.value for one in variable.indices if isinstance(one, t.Constant)]
            if len(numbers) == len(variable.indices):
                name = f"[{', '.join(map(str, numbers))}]"
                return self._inside(variable.base, name, frame, pou)
            self._let_go(variable.base, frame, pou)
            return self._inside(variable.base, "[...]", frame, pou)
        return None

    def _of_symbol(self, symbol: t.Symbol, frame: _Frame, pou: t.Pou) -> Place | None:
        key = symbol.name.upper()
        if symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL"):
            own = symbol.source.upper() or self._globals.get(id(symbol), key)
            place: Place | None = ("", own)
        elif pou.kind == "METHOD" and pou.symbols.get(key) is symbol:
            return None
        elif symbol.section == "VAR_IN_OUT":
            return frame.bound.get(key)
        else:
            place = None if frame.place is None else (*frame.place, key)
        if place is not None:
            outer = self._texts.get(frame.place or (), "") if place[0] else ""
            self._texts.setdefault(place, f"{outer}.{symbol.name}" if outer else symbol.name)
        return place

    def _inside(self, base: t.Expression, name: str, frame: _Frame, pou: t.Pou) -> Place | None:
        outer = self._place(base, frame, pou)
        if outer is None:
            return None
        place = (*outer, name.upper())
        text = self._texts[outer]
        dot = "" if name.startswith("[") or not text else "."
        self._texts.setdefault(place, f"{text}{dot}{name}")
        return place


def _is_robot(kind: Type) -> bool:
    return isinstance(kind, StructType) and kind.name.upper() == _REF


def _has_robot(kind: Type) -> bool:
    if isinstance(kind, ArrayType):
        return _has_robot(kind.element)
    inner = kind.fields if isinstance(kind, StructType) else ()
    return _is_robot(kind) or any(_has_robot(one) for _, one in inner)


def _text(variable: t.Expression) -> str:
    if isinstance(variable, t.Use):
        return variable.symbol.name
    if isinstance(variable, t.Member):
        return f"{_text(variable.base)}.{variable.name}"
    if isinstance(variable, t.Index):
        return f"{_text(variable.base)}[...]"
    return "a block"
