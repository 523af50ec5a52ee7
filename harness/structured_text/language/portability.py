"""The portability rules that a type checker cannot find; they bind the library.

Each rule comes from a difference between real compilers: matiec, STruC++, IronPLC, RuSTy, CODESYS
and TwinCAT do not all accept the construct, or do not all treat it alike. The rules are binding for
the library. A user's program gets warnings only, unless the user requests binding rules.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import place_text
from structured_text.language import cache
from structured_text.language import syntax as s
from structured_text.language.constructs import Use
from structured_text.language.lexer import KEYWORDS, tokens
from structured_text.language.parser import parse
from structured_text.language.scalars import CORE, ELEMENTARY
from structured_text.language.source import origin, source_text, title_of
from structured_text.language.standard import BLOCKS
from structured_text.language.syntax import Position
from structured_text.language.walk import nodes
from structured_text.language.words import ACCESS_WORDS, OBJECT_WORDS

__all__ = ["LintFinding", "lint", "reserved_names", "text_findings", "unportable"]

_HERE = Path(__file__)
_INTERFACE = ("VAR_OUTPUT", "VAR_IN_OUT", "VAR_EXTERNAL", "VAR_GLOBAL")
_SHIFTS = ("SHL", "SHR", "ROL", "ROR")
_PARTS_OF_TEXTS = ("MID", "LEFT", "RIGHT")
_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
#: Reserved words since IEC 61131-3:2013, and USTRING since 2025. Newer PLCs refuse them as names.
_RESERVED_SINCE_2013 = (
    ACCESS_WORDS
    | (OBJECT_WORDS - {"POINTER", "PROPERTY", "END_PROPERTY", "REFERENCE"})
    | {"CHAR", "CLASS", "CONTINUE", "END_CLASS", "LDATE", "LDATE_AND_TIME", "LDT", "LTIME", "LTOD"}
    | {"LTIME_OF_DAY", "NULL", "OVERLAP", "REF", "USTRING", "WCHAR"}
)
#: Greatest number of blocks in one declaration of variables. With three, matiec crashes.
_MOST_BLOCKS = 2


@dataclass(frozen=True)
class LintFinding:
    """A violation of a portability rule; `strict` is true if the rule binds the file."""

    file: Path
    at: s.Position
    text: str
    strict: bool

    def __str__(self) -> str:
        """Return the finding as a line of text, in the form of compiler messages."""
        kind = "rule" if self.strict else "warning"
        return f"{place_text(self.file, self.at.line, self.at.column)}: {kind}: {self.text}"


def lint(
    files: Sequence[Path],
    library: Collection[Path] = (),
    context: Sequence[Path] = (),
    *,
    binding: bool = False,
    prefix: str = "",
) -> list[LintFinding]:
    """Check files that the front end has found free of errors.

    Args:
        files: The files.
        library: The files that belong to the library, for which more rules apply.
        context: Further files with types that they use.
        binding: Whether the rules bind all files, not only those of the library.
        prefix: Prefix of the names of the library's types.

    Returns:
        The findings, in the order of the files and of their lines.
    """
    # The key must also distinguish which files belong to the library. This module's own file
    # separates the groups in the list, because it is in neither group.
    whose = [_HERE, *(file for file in files if file in library), _HERE]
    key = cache.sources_key((*files, *whose, *context, *([_HERE] if binding else [])))
    key = key and f"{key}-{prefix}"
    every = (*files, *context)
    return list(
        cache.made_of(
            "lint",
            key,
            every,
            lambda: _lint(files, library, context, binding=binding, prefix=prefix),
        )
    )


def _lint(
    files: Sequence[Path],
    library: Collection[Path],
    context: Sequence[Path],
    *,
    binding: bool,
    prefix: str,
) -> list[LintFinding]:
    declaring = [file for file in context if "END_TYPE" in source_text(file).upper()]
    members = {
        name.key
        for source in map(parse, [*files, *declaring])
        for one in source.declarations
        if isinstance(one, s.TypeDecl) and isinstance(one.spec, s.EnumSpec)
        for name in one.spec.members
    }
    findings = []
    for file in files:
        source = parse(file)
        found = list(text_findings(file))
        for declaration in source.declarations:
            found += _declaration(declaration, members)
            found += reserved_names(declaration)
            found += _third_edition(declaration)
        if file in library:
            found += _library(source, prefix)
        strict = binding or file in library
        if strict:
            found += [(use.at, str(use)) for use in source.uses]
        findings += [LintFinding(file, at, text, strict) for at, text in sorted(found)]
    return findings


def unportable(uses: Sequence[Use], library: Collection[Path] = ()) -> list[LintFinding]:
    """Return findings for the constructs beyond the portable subset.

    Returns:
        For files in `library`, a violation for every use of a construct. For other files, one
        warning per construct, at its first use.
    """
    findings = []
    places: dict[tuple[Path, str], list[Use]] = {}
    for use in sorted(uses, key=lambda use: (str(use.file), use.at)):
        if use.file in library:
            findings.append(LintFinding(use.file, use.at, str(use), strict=True))
        else:
            places.setdefault((use.file, use.construct), []).append(use)
    for (file, construct), found in places.items():
        more = f" ({len(found)} places)" if len(found) > 1 else ""
        text = f"{construct} is not portable{more}; {found[0].instead}"
        findings.append(LintFinding(file, found[0].at, text, strict=False))
    return findings


_Found = Iterator[tuple[s.Position, str]]


def _library(source: s.Source, prefix: str) -> _Found:
    """Yield violations of the library's rules: one declaration per file, named after the file.

    All names of types must begin with the prefix of the library.
    """
    for extra in source.declarations[1:]:
        yield extra.at, "a second declaration; the library has one per file"
    for one in source.declarations[:1]:
        if one.name.text != title_of(source.file):
            yield (
                one.name.at,
                f"{one.name.text} is not in a file of this name but in {source.file.stem}",
            )
    for one in source.declarations:
        if isinstance(one, s.TypeDecl) and not one.name.key.startswith(prefix.upper()):
            yield one.name.at, f"the type {one.name.text} does not begin with {prefix}"


def _declaration(one: s.Declaration, members: set[str]) -> _Found:
    if isinstance(one, s.TypeDecl):
        yield from _type(one)
    elif isinstance(one, s.Pou):
        for section in one.sections:
            yield from _section(section, one)
        if one.kind == "FUNCTION":
            yield from _function(one)
        for statement in one.body:
            yield from _code(statement, members)


def reserved_names(declaration: s.Declaration) -> Iterator[tuple[Position, str]]:
    """Yield declared names that are reserved in a newer edition."""
    for node in nodes(declaration):
        if isinstance(node, (s.TypeDecl, s.Pou)):
            names: tuple[s.Name, ...] = (node.name,)
        elif isinstance(node, s.VarDecl):
            names = node.names
        else:
            names = node.members if isinstance(node, s.EnumSpec) else ()
        for name in names:
            if name.key in _RESERVED_SINCE_2013:
                yield name.at, f"{name.text} is a reserved word of the newer standard: rename it"


def _third_edition(declaration: s.Declaration) -> _Found:
    """Yield types, and literals of types, of the third edition."""
    for node in nodes(declaration):
        name = ""
        if isinstance(node, s.NamedSpec):
            name = node.name.key
        elif isinstance(node, s.Literal) and node.kind == "TYPED":
            prefix = node.text.partition("#")[0].upper()
            name = {"LT": "LTIME", "LD": "LDATE"}.get(prefix, prefix)
        elif isinstance(node, s.Literal) and node.text.startswith('"'):
            name = "WSTRING"
        if name in ELEMENTARY and name not in CORE:
            yield node.at, f"{name} came with the third edition: use a type of the second"


def _type(one: s.TypeDecl) -> _Found:
    if isinstance(one.spec, s.StructSpec):
        for variable in one.spec.fields:
            yield from _variable(variable, "a structure")
    elif isinstance(one.spec, s.ArraySpec):
        yield from _array(one.spec)


def _section(section: s.Section, pou: s.Pou) -> _Found:
    inside = pou.kind != "PROGRAM"
    if inside and section.kind in ("VAR_EXTERNAL", "VAR_GLOBAL"):
        yield section.at, f"{section.kind} in a block: global variables are not portable"
    if inside and section.qualifier == "RETAIN":
        yield section.at, "RETAIN in a block"
    for variable in section.variables:
        yield from _variable(variable, "")
        several = len(variable.names) > _MOST_BLOCKS
        if several and isinstance(variable.spec, s.NamedSpec) and _is_block(variable.spec):
            yield variable.at, "three blocks in one declaration: matiec crashes; declare each alone"
        if inside and variable.address is not None:
            yield variable.at, "a located variable in a block"


def _variable(variable: s.VarDecl, where: str) -> _Found:
    if isinstance(variable.spec, s.ArraySpec):
        yield variable.at, "an array without a name: declare a type for it and use its name"
        yield from _array(variable.spec)
    elif isinstance(variable.spec, s.NamedSpec) and where and _is_block(variable.spec):
        yield variable.at, f"a block in {where}"
    if isinstance(variable.initial, (s.ArrayInit, s.StructInit)):
        yield variable.at, "an initial value for a whole array or structure: assign it in code"
    elif isinstance(variable.initial, s.Literal):
        yield from _literal(variable.initial)


def _array(spec: s.ArraySpec) -> _Found:
    for dimension in spec.dimensions:
        for bound in (dimension.low, dimension.high):
            plain = bound.operand if isinstance(bound, s.Unary) else bound
            if not isinstance(plain, s.Literal):
                yield bound.at, "array bounds must be literals"
    if isinstance(spec.element, s.NamedSpec) and _is_block(spec.element):
        yield spec.at, "an array of blocks"


def _is_block(spec: s.NamedSpec) -> bool:
    return spec.name.key in BLOCKS or spec.name.key.startswith("FB_")


def _function(pou: s.Pou) -> _Found:
    inputs = [section for section in pou.sections if section.kind == "VAR_INPUT"]
    if not any(section.variables for section in inputs):
        yield pou.at, "a function without an input"
    for section in pou.sections:
        if section.kind in _INTERFACE:
            yield section.at, f"{section.kind} in a function: use a block"
    for section in inputs:
        for variable in section.variables:
            if isinstance(variable.spec, s.NamedSpec):
                if variable.spec.name.key in CORE:
                    continue
                yield variable.at, "an input of a function that is not elementary"


def _code(statement: s.Statement, members: set[str]) -> _Found:
    """Yield the violations in a statement and in all nodes inside it."""
    for node in nodes(statement):
        if isinstance(node, s.For):
            yield node.at, "FOR: compilers differ in it (0 TO 0, final value); use WHILE"
        elif isinstance(node, s.Case):
            for branch in node.branches:
                for label in branch.labels:
                    yield from _label(label, members)
        elif isinstance(node, s.Literal):
            yield from _literal(node)
        elif isinstance(node, s.Call):
            yield from _call(node)
        elif isinstance(node, s.Binary) and node.op in _COMPARISONS:
            for side in (node.left, node.right):
                yield from _promoted(side)
        elif isinstance(node, s.Unary) and node.op == "NOT" and _compares(node.operand):
            yield (
                node.at,
                "NOT of a comparison: use the opposite operator or a function",
            )


def _compares(operand: s.Expression) -> bool:
    """Return whether an operand has a comparison. A nested NOT is checked separately."""
    if isinstance(operand, s.Unary):
        return False
    return any(isinstance(one, s.Binary) and one.op in _COMPARISONS for one in nodes(operand))


def _label(label: s.Expression | s.Range, members: set[str]) -> _Found:
    parts = [label.low, label.high] if isinstance(label, s.Range) else [label]
    for part in parts:
        plain = part.operand if isinstance(part, s.Unary) else part
        if isinstance(plain, s.Literal):
            if plain.kind != "INTEGER" or "#" in plain.text:
                yield part.at, f"the label {plain.text}: use decimal numbers or bare members"
        elif isinstance(plain, s.Name) and plain.key not in members:
            yield part.at, f"the label {plain.text} is not a member of an enumeration"


_DURATION = re.compile(r"\d+(?:d|h|m|s|ms)", re.IGNORECASE)
_DATES = ("D", "DATE", "TOD", "TIME_OF_DAY", "DT", "DATE_AND_TIME")
_DATE = re.compile(r"(?:\d{4}-\d\d-\d\d)?-?(?:\d+:\d+:\d+(?:\.\d+)?)?")


def _literal(literal: s.Literal) -> _Found:
    if literal.kind != "TYPED":
        return
    prefix, _, value = literal.text.partition("#")
    if prefix.upper() in ("T", "TIME"):
        if not _DURATION.fullmatch(value):
            yield literal.at, f"{literal.text}: write a TIME with one whole number and unit"
    elif prefix.upper() in _DATES and not _DATE.fullmatch(value):
        yield literal.at, f"{literal.text}: write each number of a date, with two digits"
    elif value.startswith(("-", "+")):
        yield literal.at, f"{literal.text}: a sign after # is not portable"


def _call(call: s.Call) -> _Found:
    if call.function.key in _PARTS_OF_TEXTS:
        for argument in call.arguments:
            if isinstance(argument.value, s.Literal) and argument.value.kind == "STRING":
                yield call.at, f"{call.function.text} of a literal: assign it to a variable first"
    source, separator, target = call.function.key.partition("_TO_")
    if separator and "TIME" in (source, target):
        yield call.at, f"{call.function.text}: conversions of TIME differ"


def _promoted(side: s.Expression) -> _Found:
    shift = isinstance(side, s.Call) and side.function.key in _SHIFTS
    if shift or (isinstance(side, s.Unary) and side.op == "NOT"):
        yield side.at, "a comparison of NOT or a shift: assign the result to a variable first"


_LONGEST = 100
#: Matches escaped quotes, at which some compilers end the text, and also `$$`, which is harmless.
_QUOTE = re.compile(r"\$(?:([\'\"])|.)")
#: Matches a line with a single text. The line may be longer, because the text cannot be broken.
#: Each byte may be an escape such as `$E3`.
_ONE_TEXT = re.compile(r"\s*[\w.]+ := '(?:\$[0-9A-F]{2}|[^$'])+';")


def text_findings(file: Path) -> Iterator[tuple[Position, str]]:
    """Check lines and tokens of a file that has no syntax error."""
    text = source_text(file)
    for number, line in enumerate(text.splitlines(), start=1):
        if "\t" in line:
            at = Position(*origin(file, number, line.index("\t") + 1))
            yield at, "a tab; indent with two spaces"
        if len(line) > _LONGEST and not _ONE_TEXT.fullmatch(line):
            at = Position(*origin(file, number, _LONGEST + 1))
            yield at, f"longer than {_LONGEST} characters"
    for token in tokens(text, file):
        here = Position(token.line or 1, token.column or 1)
        if token.type in KEYWORDS and token.value != token.type:
            yield here, f"{token.value}: write keywords in upper case"
        elif token.type == "STRING":
            for escape in _QUOTE.finditer(token.value):
                if escape[1]:
                    code = f"${ord(escape[1]):02X}"
                    text = f"{escape[0]} ends the text on some PLCs: write {code}"
                    yield Position(here.line, here.column + escape.start()), text
