"""The entry points of the front end: check sources and return the project or the errors.

The order of the steps follows from their dependencies. First all names are registered and ordered
(`Registry`). Then types, the variables of POUs, globals and methods are resolved, so that all
interfaces are known. Only then are the bodies checked, because they may use any interface. Every
step reports its errors and continues. An error that is only the consequence of another error is
left out at the end (`_causes`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.compiling import deeply, uncollected
from structured_text.language.constructs import Use
from structured_text.language.dialects import dialect_of, rules_of
from structured_text.language.generics import instantiated
from structured_text.language.namespaces import separated
from structured_text.language.parser import read_text
from structured_text.language.phases import joined
from structured_text.language.project import Project, runnable
from structured_text.language.registry import ConsequenceError, base_name
from structured_text.language.source import is_narrow, source_text
from structured_text.language.stages import Visit, resolve
from structured_text.language.unread import not_executed, refusal, unread_bodies
from structured_text.language.walk import parts
from structured_text.output.limits import MOST_CHARACTERS, MOST_MISTAKES, MOST_TOKENS

__all__ = [
    "Read",
    "Resolve",
    "Visit",
    "analyse",
    "checked",
    "first_errors",
    "load",
    "read_file",
    "survey",
    "too_deep",
]

#: A function that parses one source.
Read = Callable[[Path], s.Source]
#: A function that checks all sources, as `stages.resolve`.
Resolve = Callable[..., Project | None]


def load(paths: Sequence[Path], read: Read | None = None) -> Project:
    """Parse and check Structured Text sources.

    A file that is given twice counts once. `read` replaces `read_file` as the parser.

    Returns:
        The checked project.

    Raises:
        InputError: The sources have a mistake (the first is reported, with file, line and hint), or
            the program executes a body in another language.
    """
    return not_executed(runnable(_whole(paths, read)), paths)


def checked(paths: Sequence[Path], read: Read | None = None) -> Project:
    """Parse and check sources that may also be a library without a PROGRAM, or raise InputError.

    Bodies in other languages are refused.
    """
    if unread := unread_bodies(paths):
        raise refusal(unread)
    return _whole(paths, read)


def _whole(paths: Sequence[Path], read: Read | None) -> Project:
    """Return the checked project, or raise InputError with the first mistake."""
    project, errors = analyse(paths, read)
    if errors:
        raise errors[0]
    assert project is not None
    return project


def analyse(
    paths: Sequence[Path],
    read: Read | None = None,
    most: int | None = None,
    *,
    every: bool = False,
    resolving: Resolve = resolve,
) -> tuple[Project | None, list[InputError]]:
    """Return the checked project, or None with all errors, in the order of the given files.

    Sources without a PROGRAM are checked as a library. Errors that are only the consequence of
    another error are left out. Errors beyond the number `most` (default: `MOST_MISTAKES`) are only
    counted. With `every`, all errors are returned, and consequences are `ConsequenceError`.
    Statistics need all errors, because a file without a returned error counts as accepted.
    `resolving` replaces `stages.resolve`.
    """
    read = read or read_file
    try:
        project, errors = deeply(partial(_analysed, paths, read, resolving, every=every))
        if every:
            return project, errors
        shown = first_errors(errors, MOST_MISTAKES if most is None else most)
        return project, shown or (errors[:1] if project is None else [])
    except RecursionError:
        return None, [too_deep(paths, read)]


def survey(paths: Sequence[Path], visit: Visit, read: Read | None = None) -> list[InputError]:
    """Check sources, and call `visit` for each body.

    `visit` gets the names that are known in the body, and its statements. It is called after all
    declarations are resolved as far as possible, even if there are errors. Return all errors.
    """
    return deeply(partial(_analysed, paths, read or read_file, partial(resolve, visit=visit)))[1]


def read_file(path: Path) -> s.Source:
    """Parse a file as far as it can be read, and collect its errors, or raise InputError."""
    text = source_text(path)
    source = read_text(text, path)
    narrow = None if text.isascii() else is_narrow(path)
    if narrow is None:
        return source
    use = Use("a source in Windows-1252", path, s.Position(narrow, 1))
    return replace(source, uses=(*source.uses, use))


def too_deep(paths: Sequence[Path], read: Read | None = None) -> InputError:
    """Return the error for sources that are nested too deeply for any stack.

    The error has the line with the deepest nesting.
    """
    sources = [(read or read_file)(path) for path in paths]
    waiting: list[tuple[int, Path, s.Position, Any]]
    waiting = [(0, one.file, s.Position(1, 1), one.declarations) for one in sources]
    deepest = waiting[0] if waiting else (0, None, s.Position(0, 0), None)
    while waiting:
        depth, file, at, node = waiting.pop()
        at = getattr(node, "at", at)
        if depth > deepest[0]:
            deepest = depth, file, at, node
        waiting += [(depth + 1, file, at, part) for part in [*parts(node)][::-1]]
    return InputError(
        "too many operators, brackets or calls inside each other",
        file=deepest[1],
        line=deepest[2].line,
        hint="assign parts of the expression to variables first",
    )


@uncollected()
def _analysed(
    paths: Sequence[Path], read: Read, resolving: Resolve = resolve, *, every: bool = False
) -> tuple[Project | None, list[InputError]]:
    errors: list[InputError] = []
    sources: list[s.Source] = []
    missing = False
    characters = tokens = 0
    for path in dict.fromkeys(paths):
        try:
            source = read(path)
            _check_size(characters, tokens, source)
        except InputError as error:
            errors.append(error)
            missing = True
        else:
            sources.append(source)
            characters, tokens = characters + source.characters, tokens + source.tokens
            errors += source.errors
    found: list[InputError] = []
    whole = instantiated(separated(joined(sources)))
    errors += [error for one in whole for error in one.errors if error not in errors]
    rules = rules_of(dialect_of(paths))
    project = resolving(whole, found, rules, whole=not errors)
    causes = _causes(found, sources)
    if every:
        caused = [_consequence(one) for one in found if one not in causes]
        return project, [*errors, *causes, *caused]
    # Declarations in an unreadable file are unknown to the other files.
    unread = {(one.file, one.line) for one in errors}
    errors += [
        one
        for one in causes
        if not ((missing or (one.file, one.line) in unread) and _UNKNOWN.match(one.message))
    ]
    errors = [one for one in errors if not isinstance(one, ConsequenceError)]
    ranks = {str(path): rank for rank, path in enumerate(paths)}
    errors.sort(key=lambda one: (ranks.get(one.file or "", -1), one.line or 0, one.column or 0))
    return project if not errors else None, list(dict.fromkeys(errors))


def _consequence(error: InputError) -> ConsequenceError:
    """Return an error, marked as the consequence of another error."""
    return ConsequenceError(
        error.message, file=error.file, line=error.line, column=error.column, hint=error.hint
    )


def _check_size(characters: int, tokens: int, source: s.Source) -> None:
    """Raise InputError if a source makes the program too large to be compiled.

    `characters` and `tokens` are the sizes of the sources before it.
    """
    for size, most, what in (
        (characters + source.characters, MOST_CHARACTERS, "characters"),
        (tokens + source.tokens, MOST_TOKENS, "words, numbers and signs"),
    ):
        if size > most:
            raise InputError(
                f"the sources up to this one have more than {most:,} {what}",
                file=source.file,
                hint="leave out what the program does not need",
            )


def first_errors(errors: list[InputError], most: int = MOST_MISTAKES) -> list[InputError]:
    """Return the first errors, up to a limit, and a note on the number of further errors.

    Errors with the same position and text count once.
    """
    errors = list({str(error): error for error in errors}.values())
    more = len(errors) - most
    if more <= 0:
        return errors
    last = errors[most - 1]
    text = f"there are more mistakes, which are not shown: {more:,}"
    return [*errors[:most], InputError(text, file=last.file, line=last.line)]


def _causes(errors: list[InputError], sources: list[s.Source]) -> list[InputError]:
    """Return the errors, except those that an error in a named interface has caused."""
    spoiled: dict[str, set[int]] = {}
    for error in (*errors, *(error for source in sources for error in source.errors)):
        spoiled.setdefault(error.file or "", set()).add(error.line or 0)
    names = {
        name
        for source in sources
        for lines in [spoiled.get(str(source.file), set())]
        for node in (source.declarations if lines else ())
        for name, first, behind in _interfaces(node)
        if any(first <= line < behind for line in lines)
    }

    extended = {
        node.name.key: base_name(node)
        for source in sources
        for node in source.declarations
        if isinstance(node, (s.Pou, s.TypeDecl)) and node.extends is not None
    }
    for key in extended:  # An error in a base also affects the declarations that extend the base.
        chain = [key]
        while chain[-1] in extended and extended[chain[-1]] not in chain:
            chain.append(extended[chain[-1]])
        if names & set(chain):
            names.add(key)

    def follows(error: InputError) -> bool:
        said = _OF.match(error.message)
        if said is None:
            return False
        name = said[1].upper()
        return name in names or name.partition(".")[0] in names

    return [error for error in errors if not follows(error)]


def _interfaces(node: s.Declaration) -> Iterator[tuple[str, int, int]]:
    """Yield name, first line and end line of the interface of a declaration and of its methods."""
    name, line = node.name.key, node.at.line
    if isinstance(node, s.TypeDecl):
        fields = node.spec.fields if isinstance(node.spec, s.StructSpec) else ()
        yield name, line, max((one.at.line + 1 for one in fields), default=line + 1)
    if isinstance(node, (s.Pou, s.Interface)):
        if isinstance(node, s.Pou):
            yield name, line, _behind(node.sections, line)
        for member in node.members:
            if isinstance(member, s.Method):
                first = member.at.line
                yield f"{name}.{member.name.key}", first, _behind(member.sections, first)


def _behind(sections: tuple[s.Section, ...], line: int) -> int:
    return max((one.at.line for part in sections for one in part.variables), default=line) + 1


#: Matches messages that may be a consequence of an error in the named declaration.
_OF = re.compile(
    r"(?:there is no (?:type|function|variable or namespace) )?"
    r"(\w+(?:\.\w+)?)(?: (?:takes|has no) .*)?$"
)
_UNKNOWN = re.compile(r"there is no |\S+ is not declared")
