"""Python code for standard functions and conversions, and `Value`, the code of an expression."""

from __future__ import annotations

from dataclasses import dataclass

from structured_text.language import tree as t
from structured_text.language.dialects import Dialect
from structured_text.language.memory import NAMES as MEMORY_FUNCTIONS
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_CHARS,
    ANY_INT,
    ANY_REAL,
    ANY_STRING,
    INT_RANGE,
    MOMENTS,
    SIGNED,
    STRING_MAX,
    WIDTH,
    string_length,
)
from structured_text.language.types import ElementaryType, EnumType, Type, type_name

__all__ = ["JOINS", "Value", "of_type", "settle", "standard_call"]


@dataclass(frozen=True)
class Value:
    """The Python code of an expression, with facts about its value.

    Attributes:
        code: Python code, in parentheses if it needs them.
        limits: Least and greatest value of an integer before it is wrapped; (0, 0) for other types.
        wide: Whether a REAL is in double precision and not rounded yet.
    """

    code: str
    limits: tuple[int, int] = (0, 0)
    wide: bool = False


def of_type(code: str, kind: Type) -> Value:
    """Return a `Value` for code that stays within the range of its type."""
    return Value(code, INT_RANGE.get(type_name(kind), (0, 0)))


def settle(value: Value, kind: Type) -> str:
    """Return code that wraps or rounds a value, so that it fits its type."""
    name = type_name(kind)
    if value.wide and name == "REAL":
        return f"f32({value.code})"
    if name not in INT_RANGE:
        return value.code
    low, high = INT_RANGE[name]
    if low <= value.limits[0] and value.limits[1] <= high:
        return value.code
    mask = (1 << WIDTH[name]) - 1
    if low == 0:
        return f"({value.code} & {mask})"
    return f"(({value.code} + {-low} & {mask}) - {-low})"


_LREAL_FUNCTIONS = {
    **dict.fromkeys(("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "EXP", "SQRT")),
    "LN": "log",
    "LOG": "log10",
}
_CHAINS = {"GT": ">", "GE": ">=", "EQ": "==", "LE": "<=", "LT": "<"}
JOINS = {"ADD": "+", "MUL": "*", "AND": "&", "OR": "|", "XOR": "^"}
_BOOL_JOINS = {"AND": "and", "OR": "or", "XOR": "^"}
_JOINING = ("CONCAT", "INSERT", "REPLACE")
_STRINGS = ("LEFT", "RIGHT", "MID", "DELETE", *_JOINING)
#: Functions of the third edition of IEC 61131-3; the generated code calls functions of the same
#: names.
_CALENDAR = (
    *("CONCAT_DATE", "CONCAT_TOD", "CONCAT_LTOD", "CONCAT_DT", "CONCAT_LDT", "DAY_OF_WEEK"),
)


def standard_call(node: t.Standard, arguments: list[str], rules: Dialect) -> Value:
    """Return the code of a standard function.

    The code of each argument is already converted to the argument's type.
    """
    name, kind = node.name, node.type
    if name == "NOW":
        return Value("g.now")
    if name in ("LOWER_BOUND", "UPPER_BOUND"):
        array, dimension = arguments
        return of_type(f"{array}.bound({dimension}, {int(name == 'UPPER_BOUND')})", kind)
    if name in MEMORY_FUNCTIONS:
        return of_type(f"{name.lower()}({', '.join(arguments)})", kind)
    if name == "ADDRESS":
        return of_type(f"address({arguments[0]})", kind)
    if name == "MEMBER_TO_STRING":
        return Value(_member(node, arguments[0]))
    if "_TO_" in name:
        return _conversion(node, arguments[0], rules)
    if name in ("TO_BCD", "FROM_BCD"):
        return _bcd(node, arguments[0])
    if name in ("CONCAT_DATE_TOD", "CONCAT_DATE_LTOD"):
        return Value(f"({' + '.join(arguments)})")
    if name in _CALENDAR:
        code = f"{name.lower().replace('_l', '_')}({', '.join(arguments)})"
        return Value(code, (0, 6)) if name == "DAY_OF_WEEK" else Value(code)
    if name == "ATAN2":
        code = f"math.atan2({', '.join(arguments)})"
        return Value(f"f32({code})" if type_name(kind) == "REAL" else code)
    if name in _LREAL_FUNCTIONS:
        function = _LREAL_FUNCTIONS[name] or name.lower()
        code = f"math.{function}({arguments[0]})"
        if name == "SQRT" and rules.root != "stop":
            code = f"root_{rules.root}({arguments[0]})"
        return Value(f"f32({code})" if type_name(kind) == "REAL" else code)
    if name in _CHAINS:
        return Value(f"({f' {_CHAINS[name]} '.join(arguments)})")
    if name in JOINS:
        return _join(node, arguments, rules)
    if name in ("SHL", "SHR", "ROL", "ROR"):
        return _shift(node, arguments)
    if name == "ABS":
        return _absolute(node, arguments[0])
    if name == "TRUNC":
        return _unbounded(f"trunc({arguments[0]})")
    if name == "LEN":
        return Value(f"len({arguments[0]})", (0, _longest(node)))
    if name == "FIND":
        return Value(f"find({', '.join(arguments)})", (0, _longest(node)))
    if name == "MOVE":
        return of_type(arguments[0], kind)
    if name == "SEL":
        select, no, yes = arguments
        return of_type(f"({yes} if {select} else {no})", kind)
    assert name in (*_STRINGS, "MAX", "MIN", "LIMIT", "MUX"), name
    if name in _JOINING and isinstance(kind, ElementaryType) and kind.length is not None:
        # Without `most`, the engine's functions cut texts at the length of a STRING without a
        # length.
        arguments = [*arguments, f"most={kind.length}"]
    return of_type(f"{name.lower()}({', '.join(arguments)})", kind)


def _member(node: t.Standard, argument: str) -> str:
    """Return code that converts an enumeration to a text: a member's name, else the number."""
    kind = node.arguments[0].type
    assert isinstance(kind, EnumType)
    texts = dict(zip(kind.values or range(len(kind.members)), kind.members, strict=True))
    return f"member_text({texts!r}, {argument})"


def _longest(node: t.Standard) -> int:
    """Return the greatest declared length of the text arguments.

    If this length is at most STRING_MAX, the result is 128.
    """
    lengths = [
        string_length(one.type) for one in node.arguments if isinstance(one.type, ElementaryType)
    ]
    most = max(lengths)
    return 1 << 7 if most <= STRING_MAX else most


def _bcd(node: t.Standard, argument: str) -> Value:
    if node.name == "FROM_BCD":
        digits = WIDTH[type_name(node.arguments[0].type)] // 4
        return Value(f"from_bcd({argument})", (0, 10**digits - 1))
    return of_type(f"to_bcd({argument}, {WIDTH[type_name(node.type)] // 4})", node.type)


def _unbounded(code: str) -> Value:
    """Return a `Value` for an integer without known limits, which must be wrapped."""
    return Value(code, (-(1 << 70), 1 << 70))


def _join(node: t.Standard, arguments: list[str], rules: Dialect) -> Value:
    name = type_name(node.type)
    if name in ANY_BIT:
        joins = _BOOL_JOINS if name == "BOOL" and rules.operands == "needed" else JOINS
        return of_type(f"({f' {joins[node.name]} '.join(arguments)})", node.type)
    if name in ANY_REAL:
        left, right = arguments
        code = f"({left} {JOINS[node.name]} {right})"
        return Value(f"f32({code})" if name == "REAL" else code)
    return _unbounded(f"({f' {JOINS[node.name]} '.join(arguments)})")


def _shift(node: t.Standard, arguments: list[str]) -> Value:
    value, count = arguments
    name, kind = type_name(node.type), node.type
    if name == "BOOL":
        return Value(value if node.name[:2] == "RO" else f"({value} and {count} == 0)")
    constant = isinstance(node.arguments[1], t.Constant) and not count.startswith("(-")
    if node.name == "SHL":
        mask = INT_RANGE[name][1]
        if constant and int(count) < WIDTH[name]:
            return of_type(f"({value} << {count} & {mask})", kind)
        return of_type(f"shl({value}, {count}, {mask})", kind)
    if node.name == "SHR":
        return of_type(f"({value} >> {count})" if constant else f"shr({value}, {count})", kind)
    sign = "-" if node.name == "ROR" else ""
    return of_type(f"rol({value}, {sign}{count}, {WIDTH[name]})", kind)


def _absolute(node: t.Standard, argument: str) -> Value:
    name = type_name(node.type)
    if name not in INT_RANGE:
        return Value(f"abs({argument})")
    low, high = INT_RANGE[name]
    return Value(f"abs({argument})", (0, max(-low, high)))


def _conversion(node: t.Standard, argument: str, rules: Dialect) -> Value:
    source, target = node.name.split("_TO_")
    if source in ANY_CHARS or target in ANY_CHARS:
        return _characters(node, source, target, argument, rules)
    if target == "BOOL":
        return Value(f"({argument} != 0)")
    if target in ANY_REAL:
        return _to_real(source, target, argument, rules)
    if target in MOMENTS:
        return Value(_to_moment(source, target, argument, rules))
    return _to_integer(source, target, argument, rules)


def _characters(node: t.Standard, source: str, target: str, argument: str, rules: Dialect) -> Value:
    """Return the code of a conversion from or to texts and characters."""
    if target in ANY_STRING:
        code = _text(source, argument, rules)
        if source.startswith("W") and target == "STRING":
            code = f"narrow({code})"
        assert isinstance(node.type, ElementaryType)
        own = node.arguments[0].type
        assert isinstance(own, ElementaryType)
        held = string_length(own) if source in ANY_STRING else 1 if source in ANY_CHARS else 50
        most = string_length(node.type)
        return Value(f"{code}[:{most}]" if held > most else code)
    if target in ("CHAR", "WCHAR"):
        if source in ANY_CHARS:
            code = argument if source in ("CHAR", "WCHAR") else f"first({argument})"
            return Value(f"narrow({code})" if source[0] == "W" and target == "CHAR" else code)
        mask = 0xFF if target == "CHAR" else 0xFFFF
        return Value(f"chr({argument} & {mask})")
    if source in ("CHAR", "WCHAR"):
        return Value(f"ord({argument})", (0, 0xFF if source == "CHAR" else 0xFFFF))
    if target == "BOOL":
        return Value(f"string_to_bool({argument})")
    if target in ANY_REAL:
        code = f"string_to_real({argument})"
        return Value(f"f32({code})" if target == "REAL" else code)
    if target in MOMENTS:
        return Value(f"string_to_moment({argument}, {target!r})")
    return _unbounded(f"string_to_int({argument})")


def _to_moment(source: str, target: str, argument: str, rules: Dialect) -> str:
    if source in MOMENTS:
        pair = source.removeprefix("L"), target.removeprefix("L")
        if pair in (("DT", "DATE"), ("TIME", "DATE")):
            return f"day_of({argument})"
        return f"time_of({argument})" if pair in (("DT", "TOD"), ("TIME", "TOD")) else argument
    code = f"int({argument})" if source == "BOOL" else argument
    return f"trunc({code} * {rules.unit_ns(target)})"


def _text(source: str, argument: str, rules: Dialect) -> str:
    if source == "BOOL":
        return f"('TRUE' if {argument} else 'FALSE')"
    if source in ANY_CHARS:
        return argument
    if source in ANY_INT:
        return f"str({argument})"
    if rules.notation == "short":
        return _short_text(source, argument)
    if source in ANY_REAL:
        return f"real_to_string({argument})"
    if source in MOMENTS:
        return f"{source.lower()}_text({argument})"
    return f"bits_to_string({argument})"


def _short_text(source: str, argument: str) -> str:
    """Return the code of a text in the short notation of CODESYS."""
    if source in ANY_REAL:
        return f"short_{source.lower()}_text({argument})"
    if source in ("TIME", "LTIME", "TOD", "LTOD"):
        return f"short_{source.lower()}_text({argument})"
    if source in MOMENTS:
        return f"{source.lower()}_text({argument})"
    return f"str({argument})"


def _to_real(source: str, target: str, argument: str, rules: Dialect) -> Value:
    if source in MOMENTS:
        code = f"({argument} / {rules.unit_ns(source)})"
    elif source in ANY_REAL:
        code = argument
    else:
        code = f"float({argument})"
    return Value(f"f32({code})" if target == "REAL" and source != "BOOL" else code)


def _to_integer(source: str, target: str, argument: str, rules: Dialect) -> Value:
    if source == "BOOL":
        return Value(f"int({argument})", (0, 1))
    if source in ANY_REAL:
        rounds = "round" if target in SIGNED else "to_unsigned"
        return _unbounded(f"{rounds}({argument})")
    if source in MOMENTS:
        return _unbounded(f"div({argument}, {rules.unit_ns(source)})")
    return Value(argument, INT_RANGE[source])
