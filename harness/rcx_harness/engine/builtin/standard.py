"""Python code for calls of standard functions and conversions."""

from __future__ import annotations

from rcx_harness.engine.builtin.value import Value, of_type, type_name
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.scalars import ANY_BIT, ANY_INT, ANY_REAL, INT_RANGE, WIDTH

__all__ = ["standard_call"]

_LREAL_FUNCTIONS = {
    **dict.fromkeys(("SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "EXP", "SQRT")),
    "LN": "log",
    "LOG": "log10",
}
_CHAINS = {"GT": ">", "GE": ">=", "EQ": "==", "LE": "<=", "LT": "<"}
_JOINS = {"ADD": "+", "MUL": "*", "AND": "&", "OR": "|", "XOR": "^"}
_BOOL_JOINS = {"AND": "and", "OR": "or", "XOR": "^"}
_STRINGS = ("LEFT", "RIGHT", "MID", "CONCAT", "INSERT", "DELETE", "REPLACE")
_TEXTS = {"TIME": "time_text", "DATE": "date_text", "TOD": "tod_text", "DT": "dt_text"}


def standard_call(node: t.Standard, arguments: list[str]) -> Value:
    """Code of a standard function.

    Args:
        node: The call.
        arguments: Code of each argument, of its type exactly.
    """
    name, kind = node.name, node.type
    if "_TO_" in name:
        return _conversion(node, arguments[0])
    if name in _LREAL_FUNCTIONS:
        function = _LREAL_FUNCTIONS[name] or name.lower()
        code = f"math.{function}({arguments[0]})"
        return Value(f"f32({code})" if type_name(kind) == "REAL" else code)
    if name in _CHAINS:
        return Value(f"({f' {_CHAINS[name]} '.join(arguments)})")
    if name in _JOINS:
        return _join(node, arguments)
    if name in ("SHL", "SHR", "ROL", "ROR"):
        return _shift(node, arguments)
    if name == "ABS":
        return _absolute(node, arguments[0])
    if name == "TRUNC":
        return _unbounded(f"trunc({arguments[0]})")
    if name == "LEN":
        return Value(f"len({arguments[0]})", (0, 1 << 7))
    if name == "FIND":
        return Value(f"find({', '.join(arguments)})", (0, 1 << 7))
    if name == "MOVE":
        return of_type(arguments[0], kind)
    if name == "SEL":
        select, no, yes = arguments
        return of_type(f"({yes} if {select} else {no})", kind)
    assert name in (*_STRINGS, "MAX", "MIN", "LIMIT", "MUX"), name
    return of_type(f"{name.lower()}({', '.join(arguments)})", kind)


def _unbounded(code: str) -> Value:
    """An integer that may be anything, to be wrapped."""
    return Value(code, (-(1 << 70), 1 << 70))


def _join(node: t.Standard, arguments: list[str]) -> Value:
    name = type_name(node.type)
    if name in ANY_BIT:
        joins = _BOOL_JOINS if name == "BOOL" else _JOINS
        return of_type(f"({f' {joins[node.name]} '.join(arguments)})", node.type)
    if name in ANY_REAL:
        left, right = arguments
        code = f"({left} {_JOINS[node.name]} {right})"
        return Value(f"f32({code})" if name == "REAL" else code)
    return _unbounded(f"({f' {_JOINS[node.name]} '.join(arguments)})")


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


def _conversion(node: t.Standard, argument: str) -> Value:
    source, target = node.name.split("_TO_")
    if target == "BOOL":
        return Value(f"string_to_bool({argument})" if source == "STRING" else f"({argument} != 0)")
    if target == "STRING":
        return Value(_text(source, argument))
    if target in ANY_REAL:
        return _to_real(source, target, argument)
    if target in ("DATE", "TOD") and source == "DT":
        return Value(f"{'day_of' if target == 'DATE' else 'time_of'}({argument})")
    if target in _TEXTS:
        # Numbers and durations convert in seconds, as in matiec.
        code = f"int({argument})" if source == "BOOL" else argument
        return Value(f"trunc({code} * 1000000000)")
    return _to_integer(source, target, argument)


def _text(source: str, argument: str) -> str:
    if source == "BOOL":
        return f"('TRUE' if {argument} else 'FALSE')"
    if source in ANY_INT:
        return f"str({argument})"
    if source in ANY_REAL:
        return f"real_to_string({argument})"
    if source in _TEXTS:
        return f"{_TEXTS[source]}({argument})"
    return f"bits_to_string({argument})"


def _to_real(source: str, target: str, argument: str) -> Value:
    if source == "STRING":
        code = f"string_to_real({argument})"
    elif source in _TEXTS:
        code = f"({argument} / 1000000000)"
    elif source in ANY_REAL:
        code = argument
    else:
        code = f"float({argument})"
    return Value(f"f32({code})" if target == "REAL" and source != "BOOL" else code)


def _to_integer(source: str, target: str, argument: str) -> Value:
    if source == "BOOL":
        return Value(f"int({argument})", (0, 1))
    if source == "STRING":
        return _unbounded(f"string_to_int({argument})")
    if source in ANY_REAL:
        rounds = "round" if target in ("SINT", "INT", "DINT", "LINT") else "to_unsigned"
        return _unbounded(f"{rounds}({argument})")
    if source in _TEXTS:
        return _unbounded(f"div({argument}, 1000000000)")
    return Value(argument, INT_RANGE[source])
