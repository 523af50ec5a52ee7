"""The code of a project, shared by all instances of its program."""

from __future__ import annotations

import marshal
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from types import FrameType, FunctionType, TracebackType
from typing import TYPE_CHECKING, Any

from structured_text.engines.builtin import byte_views, heap, references
from structured_text.engines.builtin.blocks import CLASSES, bodies
from structured_text.engines.builtin.code import Code
from structured_text.engines.builtin.collector import Collector, collecting
from structured_text.engines.builtin.runtime import NAMES
from structured_text.engines.builtin.storage import slot_name
from structured_text.language import cache
from structured_text.language.dialects import rules_of
from structured_text.language.project import Project

__all__ = ["Module", "module_of"]

if TYPE_CHECKING:
    from structured_text.language.paths import Resolved


class Module:
    """The executed code of a project; used by `BuiltinProgram`.

    Without `collector` nothing is counted.

    Attributes:
        project: The project from which it was compiled.
        names: All names of the module: classes, `f_POU`, `save_T` and so on.
        resolved: Resolved paths of variables, which are the same for each instance.
    """

    def __init__(self, project: Project, collector: Collector | None = None) -> None:
        self.project = project
        self.resolved: dict[str, Resolved] = {}
        self.names: dict[str, Any] = {**NAMES, **references.NAMES, **byte_views.NAMES}
        self.names.update(heap.NAMES)
        self.names.update({f"b_{name}": found for name, found in CLASSES.items()})
        executed = bodies(rules_of(project.dialect))
        self.names.update({f"body_{name}": found for name, found in executed.items()})
        self._noted: set[str] = set()
        # All instances of the noted blocks record their calls, even if no user takes the records.
        # Therefore the number of records is limited.
        self._calls: deque[tuple[int, int]] = deque(maxlen=100_000)

        def made() -> Code:
            from structured_text.engines.builtin.compile import (
                compiled,  # not imported if the cache has the code
            )

            return compiled(project, collector, self.names)

        self._code = cache.kept("code", project.key if collector is None else "", made)
        for part in marshal.loads(self._code.body):
            exec(part, self.names)

    def note_calls(self, blocks: Mapping[str, int | None]) -> deque[tuple[int, int]]:
        """Replace the functions of these blocks by functions that record each call.

        Returns:
            The calls: pairs of the identity of the instance, and the identity of its VAR_IN_OUT or
            0.
        """
        for name, place in blocks.items():
            if name not in self._noted and f"f_{name}" in self.names:
                self._noted.add(name)
                self.names[f"f_{name}"] = _noting(self.names[f"f_{name}"], place, self._calls)
        return self._calls

    def origin(self, trace: TracebackType | None) -> tuple[str, int] | None:
        """Return file and line of the Structured Text statement that raised an exception.

        The innermost frame of the generated code decides. Its line number is an index into the
        origins of the lines.
        """
        found = None
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == self._code.file:
                found = trace.tb_lineno
            trace = trace.tb_next
        return None if found is None else self._origin(found)

    def running(self, frame: FrameType | None) -> Iterator[tuple[str, int]]:
        """Yield file and line of the statements that run in a frame and in its callers."""
        while frame is not None:
            if frame.f_code.co_filename == self._code.file:
                found = self._origin(frame.f_lineno)
                if found is not None:
                    yield found
            frame = frame.f_back

    def _origin(self, line: int) -> tuple[str, int] | None:
        """Return file and line of the Structured Text for a line of the generated code."""
        index = line - 1 - self._code.first
        return self._code.origins[index] if 0 <= index < len(self._code.origins) else None

    @contextmanager
    def skipping(self, block: str, place: int, called: Callable[[int], None]) -> Iterator[None]:
        """Report the calls of one instance of a block instead of executing them.

        `place` is the identity of the instance; `called` receives it.
        """
        keys = [f"{kind}_{block.upper()}" for kind in ("f", "body")]
        before = {key: self.names[key] for key in keys if key in self.names}

        def skipped(body: Callable[..., Any]) -> Callable[..., Any]:
            def call(instance: Any, *others: Any) -> Any:
                return called(place) if id(instance) == place else body(instance, *others)

            return call

        self.names.update({key: skipped(body) for key, body in before.items()})
        try:
            yield
        finally:
            self.names.update(before)

    @contextmanager
    def answering(self, answers: Mapping[str, Callable[..., Any]]) -> Iterator[None]:
        """Replace some FUNCTIONs of the program by Python functions inside the `with`."""
        keys = {f"f_{name.upper()}": answer for name, answer in answers.items()}
        before = {key: self.names[key] for key in keys if key in self.names}
        self.names.update({key: keys[key] for key in before})
        try:
            yield
        finally:
            self.names.update(before)

    @contextmanager
    def replacing(
        self, pous: Iterable[str], replace: Callable[[str, Callable[..., Any]], Callable[..., Any]]
    ) -> Iterator[None]:
        """Call `replace(name, function)(...)` for these FUNCTIONs and methods inside the `with`.

        A method is named `Block.Method`. POUs that the program does not have are ignored.
        """
        found = {name: self.names.get(f"f_{slot_name(name)}") for name in pous}
        made = {one: replace(name, one) for name, one in found.items() if one is not None}
        before = {key: one for key, one in self.names.items() if _is_among(one, made)}
        attributes = [
            (kind, name, one)
            for key, kind in self.names.items()
            if key.startswith("b_") and isinstance(kind, type)
            for name, one in vars(kind).items()
            if _is_among(one, made)
        ]
        self.names.update({key: made[one] for key, one in before.items()})
        for kind, name, one in attributes:
            setattr(kind, name, made[one])
        try:
            yield
        finally:
            self.names.update(before)
            for kind, name, one in attributes:
                setattr(kind, name, one)


def _is_among(value: Any, functions: Mapping[Callable[..., Any], Any]) -> bool:
    return isinstance(value, FunctionType) and value in functions


def _noting(
    body: Callable[..., Any], place: int | None, calls: deque[tuple[int, int]]
) -> Callable[..., Any]:
    """Return a function that records a call and then runs the body of the block."""

    def noted(instance: Any, *in_outs: Any) -> Any:
        calls.append((id(instance), 0 if place is None else id(in_outs[place])))
        return body(instance, *in_outs)

    return noted


def module_of(project: Project) -> Module:
    """Return the code of a project, compiled once without and once with coverage counters."""
    return _module_of(project, collecting())


@lru_cache(maxsize=24)
def _module_of(project: Project, collector: Collector | None) -> Module:
    return Module(project, collector)
