"""Properties that a user demands: conditions that hold always or within a time.

A TOML file states them in Structured Text. A Python file states them as functions of the cell:

    import rcx_harness as rcx

    @rcx.always
    def gripper_is_closed_while_moving(cell):
        return not (cell["Main.Open"] and cell["Main.Moving"])

    @rcx.eventually(within="5s", after=lambda cell: cell["Main.Start"])
    def start_is_answered(cell):
        return cell["Main.State"] != "CELL_READY"
"""

from __future__ import annotations

import dis
import importlib.util
import os
import sys
import traceback
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol, overload

from rcx_harness.cell import Cell
from rcx_harness.verify.handshakes.waits import waits
from structured_text.bench import Bench
from structured_text.bench.agenda import Duration
from structured_text.engines.base import Program
from structured_text.engines.conditions import Condition, conditions
from structured_text.errors import InputError, Violation
from structured_text.language.displayed import value_text
from structured_text.output.toml_files import check_keys, line_of
from structured_text.output.units import format_us, parse_us

__all__ = [
    "Areas",
    "Declared",
    "Followed",
    "Follower",
    "Judge",
    "always",
    "declared_in",
    "eventually",
    "followed",
    "from_python",
    "judge_run",
    "sometimes",
]

#: A property in Python: a function of the cell that is called after each scan.
Asked = Callable[[Any], object]
#: Type of a function that returns the areas that the PLC has read and written in the last scan.
Areas = Callable[[], Sequence[tuple[bytes, bytes]]]


@dataclass(frozen=True)
class Declared:
    """A property as it was declared.

    Attributes:
        name: The name in messages.
        that: The demanded condition, or a function of the cell that returns it.
        within_us: `that` must hold within this time [us]. None: `that` must hold after every scan.
        after: The time starts when this condition becomes true. None: the time runs whenever `that`
            is false.
        file: The file that declares the property.
        home: If `file` is a copy, the path of the original file, else None.
        sometimes: `that` must hold after at least one scan of all runs of a campaign. A single run
            cannot break this property.
    """

    name: str
    that: str | Asked
    within_us: int | None = None
    after: str | Asked | None = None
    file: str | None = None
    home: str | None = None
    sometimes: bool = False

    @property
    def shown_file(self) -> str | None:
        """Return the file that a message names."""
        return self.home or self.file

    @property
    def kind(self) -> str:
        """Return the kind of the failures that this property reports."""
        if self.sometimes:
            return f"sometimes {self.name}"
        return f"{'always' if self.within_us is None else 'eventually'} {self.name}"

    @property
    def texts(self) -> tuple[str, ...]:
        """Return the conditions in Structured Text. `follow` gets the compiled conditions."""
        return tuple(text for text in (self.that, self.after) if isinstance(text, str))

    def follow(
        self, made: Iterator[Condition], program: Program, cell: Bench | None, areas: Areas | None
    ) -> Follower:
        """Return the property, ready to be evaluated scan by scan.

        Args:
            made: The compiled conditions, in the order of `texts`.
            program: The running program.
            cell: The cell that properties in Python read, if there is a cell.
            areas: Function that returns the areas of the last scan. None if the program has no
                areas.
        """
        del program, areas
        that = _Asked(cell, self, next(made) if isinstance(self.that, str) else self.that)
        after = None
        if self.after is not None:
            after = _Asked(cell, self, next(made) if isinstance(self.after, str) else self.after)
        for asked in filter(None, (that, after)):
            asked.now()
        return Followed(self, that, after)

    def __call__(self, cell: Bench) -> object:
        """Evaluate the property; a test can still call the decorated function."""
        assert callable(self.that)
        return self.that(cell)


@overload
def always(asked: Asked) -> Declared: ...
@overload
def always(*, name: str) -> Callable[[Asked], Declared]: ...
def always(asked: Asked | None = None, *, name: str = "") -> Any:
    """Declare a property that holds after every scan.

    `name` appears in messages; by default it is the name of the function, with blanks.
    """

    def declare(asked: Asked) -> Declared:
        return Declared(name or _name(asked), asked, file=_file(asked))

    return declare if asked is None else declare(asked)


def eventually(
    *, within: Duration, after: Asked | None = None, name: str = ""
) -> Callable[[Asked], Declared]:
    """Declare a property that must hold within a time.

    Args:
        within: The time.
        after: The time starts when this condition becomes true. None: the time starts when the
            property is false.
        name: The name in messages. Default: the name of the function, with blanks.
    """
    within_us = parse_us(within)
    return lambda asked: Declared(name or _name(asked), asked, within_us, after, _file(asked))


def sometimes(asked: Asked) -> Declared:
    """Declare a condition that must hold after at least one scan of a campaign."""
    return Declared(_name(asked), asked, file=_file(asked), sometimes=True)


def _name(asked: Asked) -> str:
    return getattr(asked, "__name__", "property").replace("_", " ")


def _file(asked: Asked) -> str | None:
    code = getattr(asked, "__code__", None)
    return getattr(code, "co_filename", None)


def from_python(file: Path) -> list[Declared]:
    """Return the properties that a Python file declares, in their order."""
    name = f"rcx_properties_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    exits = sys.exit
    try:
        spec.loader.exec_module(module)
    except BaseException as error:
        raise _blamed(error, str(file)) from None
    finally:
        # the file may replace sys.exit, but the command must end with its own exit code
        sys.exit = exits
    found = [one for one in vars(module).values() if isinstance(one, Declared)]
    if not found:
        raise InputError(
            "declares no property", file=file, hint="write @rcx.always above a function"
        )
    own = os.path.abspath(file)
    return [replace(one, file=str(file)) if one.file == own else one for one in found]


def _blamed(
    error: BaseException, file: str | None, property_: str = "", home: str | None = None
) -> BaseException:
    """Return the error to show the user for an exception in the user's code.

    `sys.exit(0)` in that code is an error as well, because it would end the command with success.

    `property_` is the name of the evaluated property; empty while the file is loaded. `home` is the
    user's path of the file if `file` is a copy.
    """
    if isinstance(error, KeyboardInterrupt) and not _is_raised(error):
        return error  # Ctrl-C of the user is not an error of the property
    name = f"{property_}: " if property_ else ""
    line = _line(error, file)
    if isinstance(error, InputError):
        if error.file is not None:
            return error
        return InputError(f"{name}{error.message}", file=home or file, line=line, hint=error.hint)
    hint = "return True or False from a property" if isinstance(error, SystemExit) else ""
    return InputError(f"{name}{_words(error)}", file=home or file, line=line, hint=hint)


def _is_raised(error: BaseException) -> bool:
    """Return whether a `raise` statement raised the exception; Ctrl-C is raised elsewhere."""
    last = error.__traceback__
    while last is not None and last.tb_next is not None:
        last = last.tb_next
    if last is None:
        return False
    return dis.opname[last.tb_frame.f_code.co_code[last.tb_lasti]] == "RAISE_VARARGS"


def _words(error: BaseException) -> str:
    """Return type and text of an exception from the user's code in one printable line."""
    try:
        text = " ".join(str(error).split())
    except Exception:  # the method __str__ of the user's exception failed
        text = "no text"
    shown = "".join(c if c.isprintable() else f"\\x{ord(c):02x}" for c in text)
    kind = type(error).__name__
    return f"{kind}: {shown}" if shown else kind


def _line(error: BaseException, file: str | None) -> int | None:
    """Return the innermost line of the user's file in the traceback of an exception."""
    places = [(one.filename, one.lineno) for one in traceback.extract_tb(error.__traceback__)]
    if isinstance(error, SyntaxError):
        places.append((error.filename or "", error.lineno))
    whole = os.path.abspath(file or "")
    own = [line for at, line in places if os.path.abspath(at) == whole]
    return own[-1] if own else None


class _Asked:
    """A condition, or a function of the cell, that is evaluated after each scan."""

    def __init__(self, cell: Bench | None, declared: Declared, that: Condition | Asked) -> None:
        self._cell, self._declared, self._that = cell, declared, that
        self.condition = that if isinstance(that, Condition) else None

    def now(self) -> bool:
        """Return whether the condition holds after the last scan."""
        if isinstance(self._that, Condition):
            return self._that.holds()
        assert self._cell is not None
        declared = self._declared
        try:
            holds = self._that(self._cell)
        except BaseException as error:
            raise _blamed(error, declared.file, declared.name, declared.home) from None
        if holds is True or holds is False:
            return holds
        code = getattr(self._that, "__code__", None)
        raise InputError(
            f"{declared.name}: a property returns {type(holds).__name__}, not bool",
            file=declared.shown_file,
            line=getattr(code, "co_firstlineno", None),
            hint="return True or False, for example the result of a comparison",
        )


class Follower(Protocol):
    """A property of a program that is evaluated scan by scan."""

    @property
    def declared(self) -> Declared:
        """Return the declaration of this property."""

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the variables that the property names."""

    @property
    def has_before(self) -> bool:
        """Return whether the property compares with values of an earlier scan."""

    def scan(self, now_us: int) -> bool:
        """Evaluate a scan, and return whether the property is newly broken in it."""

    def forget(self) -> None:
        """Reset the memory of the property, because the program restarts."""

    def told(self, program: Program) -> str:
        """Return the message about this broken property."""

    def snapshot(self) -> object:
        """Return a snapshot of the memory of the property."""

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the memory of the property."""

    def memory(self, now_us: int) -> Hashable:
        """Return the memory without absolute times. Equal memory means equal behaviour."""

    def remember(self, memory: Any, now_us: int) -> None:
        """Restore the memory that `memory` returned; the time is now `now_us`."""


class Followed:
    """A condition that always holds or must hold within a time, evaluated scan by scan."""

    def __init__(self, declared: Declared, that: _Asked, after: _Asked | None) -> None:
        self.declared, self._that, self._after = declared, that, after
        self._broken = False
        self._due_us: int | None = None
        self._was = True
        self.reached = False
        """Whether the condition of a property of the kind `sometimes` has held."""

    def scan(self, now_us: int) -> bool:
        """Evaluate a scan, and return whether the property is newly broken in it."""
        holds = self._that.now()
        if self.declared.sometimes:
            self.reached = self.reached or holds
            self._mark()
            return False
        if self.declared.within_us is None:
            broken, was, self._broken = not holds, self._broken, not holds
            self._mark()
            return broken and not was
        # The deadline starts with the rising edge of `after`. Without `after` it starts when the
        # property is false. A running deadline is not restarted. If the property holds, the
        # deadline ends. A
        # missed deadline is reported once.
        if self._after is None:
            starts = not holds
        else:
            after = self._after.now()
            starts, self._was = after and not self._was, after
        if starts and self._due_us is None:
            self._mark()
            self._due_us = now_us + self.declared.within_us
        if holds:
            self._due_us = None
        if self._due_us is None or now_us <= self._due_us:
            return False
        self._due_us = None
        return True

    def forget(self) -> None:
        """Reset the memory of the property, because the program restarts."""
        self._broken, self._due_us, self._was = False, None, True
        self._mark()

    def _mark(self) -> None:
        for one in (self._that, self._after):
            if one is not None and one.condition is not None:
                one.condition.mark()

    def told(self, program: Program) -> str:
        """Return the message, with the current values of the property's variables."""
        condition = self._that.condition
        what = self.declared.name if condition is None else condition.text
        said = "is not so" if self.declared.within_us is None else "has not come"
        within_us = self.declared.within_us
        limit = "" if within_us is None else f" within {format_us(within_us)}"
        shown = ", ".join(
            f"{path} = {value_text(program.type_of(path), program.read(path))}"
            for path in dict.fromkeys(self.paths)
        )
        return f"{what} {said}{limit}; {shown}"

    def snapshot(self) -> object:
        """Return a snapshot of the memory of the property."""
        return self._broken, self._due_us, self._was, self._then()

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the memory of the property."""
        self._broken, self._due_us, self._was, before = snapshot
        for one, then in zip(self._both(), before, strict=True):
            if one is not None and one.condition is not None:
                one.condition.before = then

    def memory(self, now_us: int) -> Hashable:
        """Return the memory without absolute times. Equal memory means equal behaviour."""
        left_us = None if self._due_us is None else self._due_us - now_us
        return left_us, self._was, tuple(self._then())

    def remember(self, memory: Any, now_us: int) -> None:
        """Restore the memory that `memory` returned; the time is now `now_us`."""
        left_us, was, before = memory
        self.restore((False, None if left_us is None else now_us + left_us, was, before))

    def _then(self) -> list[Any]:
        return [one and one.condition and one.condition.before for one in self._both()]

    def _both(self) -> tuple[_Asked, _Asked | None]:
        return self._that, self._after

    @property
    def has_before(self) -> bool:
        """Return whether the property compares with values of an earlier scan."""
        return any(
            one.condition.has_before for one in self._both() if one and one.condition is not None
        )

    @property
    def paths(self) -> tuple[str, ...]:
        """Return the variables that the conditions name."""
        return tuple(
            path
            for one in self._both()
            if one is not None and one.condition is not None
            for path in one.condition.paths
        )


class Judge:
    """The evaluation of the properties of a cell, scan by scan.

    Args:
        found: Function that is called for each finding with its kind and a sentence.
    """

    def __init__(
        self, cell: Bench, declared: Sequence[Declared], found: Callable[[str, str], None]
    ) -> None:
        self._cell, self._found = cell, found
        areas = getattr(cell, "exchanged", None)
        self._properties = followed(cell.program, declared, cell, areas)
        cell.trace.listen(self.take)
        cell.plc.on_start.append(self._forget)

    def take(self, record: Any) -> None:
        """Take a record of the trace, and evaluate the properties once per scan."""
        if self._cell.ends_scan(record):
            for one in self._properties:
                if one.scan(record.t_us):
                    self._found(one.declared.kind, self._told(one))
            for robot in getattr(self._cell, "robots", ()):
                if robot.machine.ports.accesses:
                    robot.machine.ports.accesses.clear()

    @property
    def reached(self) -> tuple[str, ...]:
        """Return the names of the properties `sometimes` that have held so far."""
        return tuple(
            one.declared.name
            for one in self._properties
            if isinstance(one, Followed) and one.reached
        )

    def forget_reached(self) -> None:
        """Regard no property `sometimes` as reached, because another run begins."""
        for one in self._properties:
            if isinstance(one, Followed):
                one.reached = False

    def _told(self, one: Follower) -> str:
        """Return the message. For a time-out it also names the signals for which the cell waits."""
        text = one.told(self._cell.program)
        late = type(one) is Followed and one.declared.within_us is not None
        standing = waits(self._cell) if late and isinstance(self._cell, Cell) else ""
        return f"{text}; {standing}" if standing else text

    def expected(self, kind: str) -> str:
        """Return the condition of the property that was broken with this kind, for a stimulus.

        The text is empty if the property is a Python function or compares with an earlier scan.
        """
        for one in self._properties:
            that = one.declared.that
            if one.declared.kind == kind and isinstance(that, str) and not one.has_before:
                return that
        return ""

    def paths(self, kind: str) -> tuple[str, ...]:
        """Return the variables in the conditions of the property with this kind of failure."""
        return next((one.paths for one in self._properties if one.declared.kind == kind), ())

    def _forget(self) -> None:
        for one in self._properties:
            one.forget()

    def snapshot(self) -> object:
        """Return a snapshot of the memory of all properties."""
        return [one.snapshot() for one in self._properties]

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the memory of all properties."""
        for one, state in zip(self._properties, snapshot, strict=True):
            one.restore(state)

    def memory(self, now_us: int) -> Hashable:
        """Return the memory of each property without absolute times."""
        return tuple(one.memory(now_us) for one in self._properties)


def judge_run(cell: Bench, declared: Sequence[Declared]) -> None:
    """Report broken properties as violations of a cell, like broken rules."""

    def found(kind: str, text: str) -> None:
        told = f"plc, scan {cell.scans}: property: {kind}: {text}"
        cell.report([Violation(cell.now_us, "property", told)])

    Judge(cell, declared, found)


def followed(
    program: Program,
    declared: Sequence[Declared],
    cell: Bench | None = None,
    areas: Areas | None = None,
) -> list[Follower]:
    """Return the declared properties of a program, ready to be evaluated.

    Properties in Python read `cell`; `areas` returns the areas of the last scan.
    """
    texts = [text for one in declared for text in one.texts]
    made = iter(_checked(program, declared, texts))
    return [one.follow(made, program, cell, areas) for one in declared]


def _checked(program: Program, declared: Sequence[Declared], texts: list[str]) -> list[Condition]:
    """Return the compiled conditions; an error names the file that declares the condition."""
    try:
        return conditions(program, texts)
    except InputError as error:
        for one in declared:
            if error.message.startswith(tuple(f"{text}:" for text in one.texts)):
                text = f"{one.name}: {error.message}"
                raise InputError(text, file=one.shown_file, hint=error.hint) from None
        raise


def declared_in(table: Mapping[str, Any], file: Path) -> list[Declared]:
    """Return the properties always, eventually and sometimes of a TOML file."""
    found = []
    for kind in ("always", "eventually", "sometimes"):
        timed = kind == "eventually"
        needs = {"that", "within"} if timed else {"that"}
        knows = needs | ({"name", "after"} if timed else {"name"})
        tables = table.get(kind, [])
        if not isinstance(tables, list) or not all(isinstance(one, dict) for one in tables):
            hint = f"write [[{kind}]]"
            raise InputError(f"{kind!r} is not a list of tables", file=file, hint=hint)
        for number, one in enumerate(tables, 1):
            where, line = f"[[{kind}]] {number}", line_of(file, kind, number)
            check_keys(one, sorted(knows), where, file, every="keys are")
            for key, value in one.items():
                if not isinstance(value, str):
                    raise InputError(f"{where}: {key} is not a text", file=file, line=line)
            for key in sorted(needs - one.keys()):
                raise InputError(f"{where}: {key} is missing", file=file, line=line)
            try:
                within_us = parse_us(one["within"]) if kind == "eventually" else None
            except InputError as error:
                text = f"{where}: {error.message}"
                raise InputError(text, file=file, line=line, hint=error.hint) from None
            name = one.get("name", one["that"])
            after, is_goal = one.get("after"), kind == "sometimes"
            found.append(
                Declared(name, one["that"], within_us, after, str(file), sometimes=is_goal)
            )
    return found
