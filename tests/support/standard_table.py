"""Calls of every standard function at its limits, with the values that IEC 61131-3 gives.

Values were calculated by hand from IEC 61131-3, 2.5.1.5 (tables 22 to 31). Values of reals follow
IEEE 754:
each operation is rounded to the nearest single, ties to even. A STRING has at most 126 characters
here, as in matiec.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date, time, timedelta

from standard_rows import Row, call, ms, rows
from standard_texts import TEXTS

# --- shifts and rotations (table 25) ---

#: For each width: the bits 10..01, then five results: SHL by 1, SHL by the width less 1, SHR by 1,
#: ROL by 1 and ROR by 1.
_BITS = {
    ("BYTE", 8): (0x81, 0x02, 0x80, 0x40, 0x03, 0xC0),
    ("WORD", 16): (0x8001, 0x0002, 0x8000, 0x4000, 0x0003, 0xC000),
    ("DWORD", 32): (0x80000001, 2, 0x80000000, 0x40000000, 3, 0xC0000000),
    ("LWORD", 64): (1 << 63 | 1, 2, 1 << 63, 1 << 62, 3, 3 << 62),
}


def _shifts() -> Iterator[Row]:
    for (kind, width), (value, left, top, right, rolled, turned) in _BITS.items():
        counts = (0, 1, width - 1, width, width + 1)
        results = {
            "SHL": (value, left, top, 0, 0),
            "SHR": (value, right, 1, 0, 0),
            "ROL": (value, rolled, turned, value, rolled),
            "ROR": (value, turned, rolled, value, turned),
        }
        for name, row in results.items():
            for count, result in zip(counts, row, strict=True):
                arguments = (f"{kind} 16#{value:X}", f"INT {count}")
                # In C a shift by the width or more is undefined.
                yield Row(call(name, 2), arguments, kind, result, alike=count < width)
    for count in (63, 64, 65, 100, 32767):
        for name in ("SHL", "SHR"):
            yield Row(call(name, 2), ("WORD 16#FFFF", f"INT {count}"), "WORD", 0, alike=False)
    yield Row("SHL({0}, {1}) = {2}", ("BYTE 16#FF", "INT 4", "BYTE 16#F0"), "BOOL", True, False)
    yield Row("SHR(SHL({0}, {1}), {1})", ("WORD 16#FFFF", "INT 4"), "WORD", 0x0FFF, False)


# --- arithmetic (tables 23, 24) ---

_RANGES = {
    "SINT": (-128, 127),
    "INT": (-32768, 32767),
    "DINT": (-(1 << 31), (1 << 31) - 1),
    "LINT": (-(1 << 63), (1 << 63) - 1),
    "USINT": (0, 255),
    "UINT": (0, 65535),
    "UDINT": (0, (1 << 32) - 1),
    "ULINT": (0, (1 << 64) - 1),
}


def _integers() -> Iterator[Row]:
    """Return rows in which a result beyond the integer range wraps around."""
    for kind, (low, high) in _RANGES.items():
        top, bottom, one, two = f"{kind} {high}", f"{kind} {low}", f"{kind} 1", f"{kind} 2"
        for code, arguments, value in (
            ("ADD({0}, {1})", (top, one), low),
            ("{0} + {1}", (top, one), low),
            ("ADD({0}, {1}, {2})", (top, one, one), low + 1),
            ("ADD({0}, {1}, {2})", (top, one, bottom), 2 * low),
            ("SUB({0}, {1})", (bottom, one), high),
            ("{0} - {1}", (bottom, one), high),
            ("MUL({0}, {1})", (top, two), -2 if low else high - 1),
            ("{0} * {1}", (top, top), 1),
            ("MUL({0}, {1}, {2})", (top, top, two), 2),
            ("DIV({0}, {1})", (top, two), high // 2),
            ("{0} / {1}", (top, top), 1),
            ("MOD({0}, {1})", (top, two), 1),
            ("{0} MOD {1}", (one, two), 1),
            ("ABS({0})", (top,), high),
            ("MOVE({0})", (top,), high),
        ):
            if value == 2 * low:
                value = 0
            yield Row(code, arguments, kind, value)
        # The sum wraps around to its type before it is compared or divided.
        narrow = kind in ("SINT", "INT", "USINT", "UINT")
        yield Row("ADD({0}, {1}) < {1}", (top, one), "BOOL", True, alike=not narrow and low == 0)
        yield Row(
            "({0} + {1}) / {2}", (top, one, two), kind, _half(low), alike=low == 0 and not narrow
        )
        if low:
            minus = f"{kind} -1"
            yield Row("ABS({0})", (bottom,), kind, low, alike=False)
            yield Row("-{0}", (bottom,), kind, low, alike=False)
            yield Row("{0} / {1}", (bottom, minus), kind, low, alike=False)
            yield Row("DIV({0}, {1})", (top, minus), kind, -high)


def _half(value: int) -> int:
    return -(-value // 2)


_SIGNS = [
    *rows(
        "{0} / {1}",
        "INT",
        *(
            (f"INT {a}", f"INT {b}", q)
            for a, b, q in ((7, 2, 3), (-7, 2, -3), (7, -2, -3), (-7, -2, 3), (1, 2, 0), (-1, 2, 0))
        ),
    ),
    *rows(
        "DIV({0}, {1})",
        "DINT",
        *(
            (f"DINT {a}", f"DINT {b}", q)
            for a, b, q in ((7, 2, 3), (-7, 2, -3), (7, -2, -3), (-7, -2, 3), (0, -5, 0))
        ),
    ),
    *rows(
        "{0} MOD {1}",
        "INT",
        *(
            (f"INT {a}", f"INT {b}", r)
            for a, b, r in ((7, 3, 1), (-7, 3, -1), (7, -3, 1), (-7, -3, -1), (-6, 3, 0))
        ),
    ),
    *rows(
        "MOD({0}, {1})",
        "SINT",
        *((f"SINT {a}", f"SINT {b}", r) for a, b, r in ((7, 3, 1), (-7, 3, -1), (-128, -1, 0))),
    ),
    *rows("{0} MOD {1}", "UINT", ("UINT 65535", "UINT 10", 5), ("UINT 3", "UINT 10", 3)),
    *rows("ABS({0})", "INT", ("INT -5", 5), ("INT 0", 0), ("INT -32767", 32767)),
    *rows("ABS({0})", "REAL", ("REAL -2.5", 2.5), ("REAL 2.5", 2.5)),
    *rows("-{0}", "INT", ("INT 5", -5), ("INT -5", 5)),
    *rows("-{0}", "REAL", ("REAL 0.1", -0.10000000149011612)),
]

_REALS = [
    *rows("{0} + {1}", "REAL", ("REAL 0.1", "REAL 0.2", 0.30000001192092896)),
    *rows("ADD({0}, {1})", "REAL", ("REAL 0.1", "REAL 0.2", 0.30000001192092896)),
    *rows("{0} - {1}", "REAL", ("REAL 0.3", "REAL 0.1", 0.20000001788139343)),
    *rows("SUB({0}, {1})", "REAL", ("REAL 0.3", "REAL 0.1", 0.20000001788139343)),
    *rows("{0} * {1}", "REAL", ("REAL 0.1", "REAL 0.1", 0.010000000707805157)),
    *rows("MUL({0}, {1})", "REAL", ("REAL 0.1", "REAL 0.1", 0.010000000707805157)),
    *rows("{0} / {1}", "REAL", ("REAL 1.0", "REAL 3.0", 0.3333333432674408)),
    *rows("DIV({0}, {1})", "REAL", ("REAL 0.1", "REAL 0.3", 0.3333333134651184)),
    # Each step is rounded: 2**24 + 1 is 2**24.
    *rows("ADD({0}, {1}, {1})", "REAL", ("REAL 16777216.0", "REAL 1.0", 16777216.0)),
    *rows("{0} + {1} + {1}", "REAL", ("REAL 16777216.0", "REAL 1.0", 16777216.0)),
    *rows("({0} + {1}) - {0}", "REAL", ("REAL 16777216.0", "REAL 1.0", 0.0)),
    *rows("ADD({0}, {1}) - {0}", "REAL", ("REAL 16777216.0", "REAL 1.0", 0.0)),
    *rows("MUL({0}, {0}, {0})", "REAL", ("REAL 1.7", 4.913000106811523)),
    *rows("{0} * {0} * {0}", "REAL", ("REAL 1.7", 4.913000106811523)),
    *rows("MUL({0}, {0}, {0}, {0})", "REAL", ("REAL 3.3", 118.59208679199219)),
    # The value of a function has single precision before it is compared.
    *rows("ADD({0}, {1}) = {2}", "BOOL", ("REAL 0.1", "REAL 0.2", "REAL 0.3", True)),
    *rows(
        "MUL({0}, {1}) = {2}", "BOOL", ("REAL 0.1", "REAL 0.1", "REAL 0.010000000707805157", True)
    ),
    *rows("MUL({0}, {0}, {0}) = {1}", "BOOL", ("REAL 1.7", "REAL 4.913000106811523", True)),
    *rows("DIV({0}, {1}) = {2}", "BOOL", ("REAL 1.0", "REAL 3.0", "REAL 0.3333333432674408", True)),
    *rows(
        "SUB({0}, {1}) = {2}", "BOOL", ("REAL 0.3", "REAL 0.1", "REAL 0.20000001788139343", True)
    ),
    *rows("SQRT({0}) = {1}", "BOOL", ("REAL 2.0", "REAL 1.4142135381698608", True)),
    *rows("{0} + {1}", "LREAL", ("LREAL 0.1", "LREAL 0.2", 0.30000000000000004)),
    *rows("ADD({0}, {1}, {1})", "LREAL", ("LREAL 16777216.0", "LREAL 1.0", 16777218.0)),
    *rows("MUL({0}, {1})", "LREAL", ("LREAL 0.1", "LREAL 0.1", 0.010000000000000002)),
    *rows("DIV({0}, {1})", "LREAL", ("LREAL 1.0", "LREAL 3.0", 0.3333333333333333)),
    *rows("{0} - {1}", "LREAL", ("LREAL 0.3", "LREAL 0.1", 0.19999999999999998)),
    *rows("SQRT({0})", "REAL", ("REAL 2.0", 1.4142135381698608)),
    *rows("SQRT({0})", "LREAL", ("LREAL 2.0", 1.4142135623730951)),
    *rows("LN({0})", "REAL", ("REAL 2.0", 0.6931471824645996)),
    *rows("LOG({0})", "REAL", ("REAL 2.0", 0.3010300099849701), ("REAL 1000.0", 3.0)),
    *rows("EXP({0})", "REAL", ("REAL 1.0", 2.7182817459106445)),
    *rows("SIN({0})", "REAL", ("REAL 1.0", 0.8414709568023682)),
    *rows("COS({0})", "REAL", ("REAL 1.0", 0.5403022766113281)),
    *rows("TAN({0})", "REAL", ("REAL 1.0", 1.5574077367782593)),
    *rows("ASIN({0})", "REAL", ("REAL 0.5", 0.5235987901687622)),
    *rows("ACOS({0})", "REAL", ("REAL 0.5", 1.0471975803375244)),
    *rows("ATAN({0})", "REAL", ("REAL 1.0", 0.7853981852531433)),
    *rows("EXPT({0}, {1})", "REAL", ("REAL 0.1", "INT 2", 0.010000000707805157)),
    *rows("EXPT({0}, {1})", "LREAL", ("LREAL 2.0", "INT -1", 0.5), ("LREAL 2.0", "INT 0", 1.0)),
    *rows("{0} ** {1}", "REAL", ("REAL 2.0", "REAL 0.5", 1.4142135381698608)),
]

# --- durations (table 30) ---

_TIMES = [
    *rows("{0} + {1}", "TIME", ("TIME 1s", "TIME 500ms", ms(1500)), ("TIME -1s", "TIME 1s", ms(0))),
    *rows("ADD_TIME({0}, {1})", "TIME", ("TIME 59s", "TIME 1s", ms(60_000))),
    *rows("{0} - {1}", "TIME", ("TIME 1s", "TIME 1500ms", ms(-500))),
    *rows("SUB_TIME({0}, {1})", "TIME", ("TIME 1m", "TIME 1s", ms(59_000))),
    *rows("{0} * {1}", "TIME", ("TIME 250ms", "INT 5", ms(1250)), ("TIME 1s", "INT -3", ms(-3000))),
    *rows("MULTIME({0}, {1})", "TIME", ("TIME 1s", "INT 90", ms(90_000))),
    *rows("MULTIME({0}, {1})", "TIME", ("TIME 10s", "REAL 0.25", ms(2500))),
    *rows("{0} / {1}", "TIME", ("TIME 1s", "INT 4", ms(250)), ("TIME 7s", "INT -2", ms(-3500))),
    *rows("DIVTIME({0}, {1})", "TIME", ("TIME 1m", "INT 8", ms(7500))),
    *rows("DIVTIME({0}, {1})", "TIME", ("TIME 1s", "REAL 0.5", ms(2000))),
    # Products are exact to the nanosecond; quotients are truncated.
    *rows(
        *("{0} * {1} = {2}", "BOOL"),
        ("TIME 10s", "REAL 0.25", "TIME 2500ms", True),
        ("TIME -10s", "REAL 0.25", "TIME -2500ms", True),
        alike=False,
    ),
    *rows(
        *("DIVTIME({0}, {1}) = {2}", "BOOL"),
        *(("TIME 1s", "REAL 0.5", "TIME 2s", True), ("TIME -1s", "REAL 0.5", "TIME -2s", True)),
        alike=False,
    ),
    *rows("{0} / {1} * {1} > {0}", "BOOL", ("TIME -1ms", "INT 3", True), alike=False),
    *rows("{0} / {1} * {1} < {0}", "BOOL", ("TIME 1ms", "INT 3", True), alike=False),
    *rows("{0} < {1}", "BOOL", ("TIME -1s", "TIME 0s", True), ("TIME 1s", "TIME 1000ms", False)),
    *rows("{0} = {1}", "BOOL", ("TIME 1m", "TIME 60s", True), ("TIME 1s", "TIME 999ms", False)),
    *rows("TIME_TO_INT({0})", "INT", ("TIME 90s", 90), ("TIME 2s", 2)),
    *rows("TIME_TO_REAL({0})", "REAL", ("TIME 1500ms", 1.5)),
    *rows("INT_TO_TIME({0})", "TIME", ("INT 90", ms(90_000)), ("INT 0", ms(0))),
    *rows("REAL_TO_TIME({0})", "TIME", ("REAL 1.5", ms(1500))),
    *rows("DT_TO_DATE({0})", "DATE", ("DT 2024-02-29-23:59:59", date(2024, 2, 29))),
    *rows("DT_TO_TOD({0}) = {1}", "BOOL", ("DT 2024-02-29-23:59:59", "TOD 23:59:59", True)),
    *rows("DT_TO_DATE({0}) = {1}", "BOOL", ("DT 2024-02-29-23:59:59", "DATE 2024-02-29", True)),
    *rows("DT_TO_TOD({0})", "TOD", ("DT 2024-02-29-23:59:59", time(23, 59, 59))),
    *rows("{0} - {1}", "TIME", ("DATE 2024-03-01", "DATE 2024-02-28", timedelta(days=2))),
]

# --- conversions (table 22): to the nearest, ties to even (2.5.1.5.1) ---

_CONVERSIONS = [
    *(
        Row(f"{source}_TO_{kind}({{0}})", (f"{source} {value}",), kind, result)
        for source in ("REAL", "LREAL")
        for kind in ("SINT", "INT", "DINT", "LINT")
        for value, result in (
            *(("0.5", 0), ("1.5", 2), ("2.5", 2), ("-0.5", 0), ("-1.5", -2), ("-2.5", -2)),
            *(("2.4", 2), ("2.6", 3), ("-2.4", -2), ("-2.6", -3), ("0.0", 0), ("99.5", 100)),
        )
    ),
    *(
        Row(f"REAL_TO_{kind}({{0}})", (f"REAL {value}",), kind, result)
        for kind in ("USINT", "UINT", "UDINT", "ULINT", "BYTE", "WORD", "DWORD", "LWORD")
        for value, result in (("0.5", 0), ("1.5", 2), ("2.5", 2), ("2.6", 3), ("100.0", 100))
    ),
    *rows(
        "TRUNC({0})",
        "INT",
        *(
            (f"REAL {v}", r)
            for v, r in (("2.9", 2), ("-2.9", -2), ("0.5", 0), ("-0.5", 0), ("3.0", 3))
        ),
    ),
    *rows("TRUNC({0})", "DINT", ("LREAL 2147483646.9", 2147483646)),
    *rows("INT_TO_SINT({0})", "SINT", ("INT 127", 127), ("INT 128", -128), ("INT -129", 127)),
    *rows("INT_TO_USINT({0})", "USINT", ("INT 255", 255), ("INT 256", 0), ("INT -1", 255)),
    *rows("DINT_TO_INT({0})", "INT", ("DINT 32768", -32768), ("DINT -32769", 32767)),
    *rows("UDINT_TO_INT({0})", "INT", ("UDINT 65535", -1)),
    *rows("LINT_TO_DINT({0})", "DINT", ("LINT 2147483648", -2147483648)),
    *rows("WORD_TO_INT({0})", "INT", ("WORD 16#8000", -32768), ("WORD 16#7FFF", 32767)),
    *rows("WORD_TO_BYTE({0})", "BYTE", ("WORD 16#1234", 0x34)),
    *rows("DWORD_TO_WORD({0})", "WORD", ("DWORD 16#12345678", 0x5678)),
    *rows("BYTE_TO_SINT({0})", "SINT", ("BYTE 16#80", -128)),
    *rows("SINT_TO_WORD({0})", "WORD", ("SINT -1", 0xFFFF)),
    *rows("INT_TO_UDINT({0})", "UDINT", ("INT -1", 0xFFFFFFFF)),
    *rows("INT_TO_REAL({0})", "REAL", ("INT -32768", -32768.0)),
    *rows(
        "DINT_TO_REAL({0})", "REAL", ("DINT 16777217", 16777216.0), ("DINT 16777219", 16777220.0)
    ),
    *rows("DINT_TO_LREAL({0})", "LREAL", ("DINT 16777217", 16777217.0)),
    *rows("LREAL_TO_REAL({0})", "REAL", ("LREAL 0.1", 0.10000000149011612)),
    *rows("REAL_TO_LREAL({0})", "LREAL", ("REAL 0.1", 0.10000000149011612)),
    *rows("BOOL_TO_INT({0})", "INT", ("BOOL TRUE", 1), ("BOOL FALSE", 0)),
    *rows("BOOL_TO_REAL({0})", "REAL", ("BOOL TRUE", 1.0)),
    *rows("INT_TO_BOOL({0})", "BOOL", ("INT 0", False), ("INT -1", True), ("INT 256", True)),
    *rows("REAL_TO_BOOL({0})", "BOOL", ("REAL 0.0", False), ("REAL 1.0", True)),
    *rows("INT_TO_STRING({0})", "STRING", ("INT -32768", "-32768"), ("INT 0", "0")),
    *rows("BOOL_TO_STRING({0})", "STRING", ("BOOL FALSE", "FALSE"), ("BOOL TRUE", "TRUE")),
    *rows("WORD_TO_STRING({0})", "STRING", ("WORD 16#ABC", "16#abc"), ("WORD 0", "16#0")),
    *rows("STRING_TO_INT({0})", "INT", ("STRING '-32768'", -32768), ("STRING 'x'", 0)),
    *rows("STRING_TO_INT({0})", "INT", ("STRING '12x'", 12), ("STRING ''", 0)),
    *rows("STRING_TO_BOOL({0})", "BOOL", ("STRING '1'", True), ("STRING 'no'", False)),
    *rows("STRING_TO_REAL({0})", "REAL", ("STRING '-2.5'", -2.5), ("STRING '3'", 3.0)),
]

# --- bits, selection, comparison (tables 26 to 28) ---

_CHOICES = [
    *rows("AND({0}, {1}, {2})", "WORD", ("WORD 16#FF0F", "WORD 16#F0FF", "WORD 16#FFF0", 0xF000)),
    *rows("OR({0}, {1}, {2})", "BYTE", ("BYTE 1", "BYTE 2", "BYTE 16#80", 0x83)),
    *rows("XOR({0}, {1}, {2})", "BYTE", ("BYTE 1", "BYTE 3", "BYTE 7", 5)),
    *rows("NOT {0}", "BYTE", ("BYTE 16#0F", 0xF0)),
    *rows("NOT {0}", "LWORD", ("LWORD 0", (1 << 64) - 1)),
    *rows("NOT {0}", "BOOL", ("BOOL TRUE", False)),
    *rows("AND({0}, {1}, {2})", "BOOL", ("BOOL TRUE", "BOOL TRUE", "BOOL FALSE", False)),
    *rows("OR({0}, {1}, {2})", "BOOL", ("BOOL FALSE", "BOOL FALSE", "BOOL TRUE", True)),
    *rows("XOR({0}, {1}, {2})", "BOOL", ("BOOL TRUE", "BOOL TRUE", "BOOL TRUE", True)),
    *rows(
        "{0} XOR {1}", "BOOL", ("BOOL TRUE", "BOOL TRUE", False), ("BOOL TRUE", "BOOL FALSE", True)
    ),
    *rows(
        *("SEL({0}, {1}, {2})", "INT"),
        *(("BOOL FALSE", "INT 1", "INT 2", 1), ("BOOL TRUE", "INT 1", "INT 2", 2)),
    ),
    *rows("SEL(G := {0}, IN1 := {1}, IN0 := {2})", "INT", ("BOOL TRUE", "INT 1", "INT 2", 1)),
    *rows("SEL({0}, {1}, {2})", "STRING", ("BOOL TRUE", "STRING 'a'", "STRING 'b'", "b")),
    *rows(
        *("MAX({0}, {1}, {2})", "INT"),
        *(("INT -3", "INT -1", "INT -2", -1), ("INT 5", "INT 1", "INT 2", 5)),
    ),
    *rows(
        *("MIN({0}, {1}, {2})", "INT"),
        *(("INT -3", "INT -1", "INT -4", -4), ("INT 1", "INT 5", "INT 2", 1)),
    ),
    *rows("MAX({0}, {1})", "REAL", ("REAL -0.5", "REAL -0.25", -0.25)),
    *rows("MIN({0}, {1})", "TIME", ("TIME 1m", "TIME 59s", ms(59_000))),
    *rows("MAX({0}, {1})", "WORD", ("WORD 16#8000", "WORD 16#7FFF", 0x8000)),
    *rows(
        "LIMIT({0}, {1}, {2})",
        "INT",
        *(
            ("INT -5", f"INT {v}", "INT 5", r)
            for v, r in ((-6, -5), (-5, -5), (-4, -4), (4, 4), (5, 5), (6, 5))
        ),
    ),
    *rows("LIMIT({0}, {1}, {2})", "TIME", ("TIME 1s", "TIME 500ms", "TIME 2s", ms(1000))),
    # LIMIT is MIN(MAX(IN, MN), MX). If MN is above MX, its value is therefore MX.
    *rows("LIMIT({0}, {1}, {2})", "INT", ("INT 10", "INT 20", "INT 0", 0)),
    *rows(
        *("LIMIT({0}, {1}, {2})", "INT"),
        *(("INT 10", "INT 5", "INT 0", 0), ("INT 10", "INT 10", "INT 0", 0)),
        alike=False,
    ),
    *rows(
        "MUX({0}, {1}, {2}, {3})",
        "INT",
        *((f"INT {k}", "INT 10", "INT 20", "INT 30", r) for k, r in ((0, 10), (1, 20), (2, 30))),
    ),
    *rows(
        *("GT({0}, {1}, {2})", "BOOL"),
        *(("INT 3", "INT 2", "INT 1", True), ("INT 3", "INT 1", "INT 2", False)),
        ("INT 3", "INT 3", "INT 1", False),
    ),
    *rows(
        *("GE({0}, {1}, {2})", "BOOL"),
        *(("INT 3", "INT 3", "INT 1", True), ("INT 3", "INT 1", "INT 2", False)),
    ),
    *rows(
        *("EQ({0}, {1}, {2})", "BOOL"),
        *(("INT 3", "INT 3", "INT 3", True), ("INT 3", "INT 3", "INT 1", False)),
        ("INT 1", "INT 3", "INT 3", False),
    ),
    *rows(
        *("LE({0}, {1}, {2})", "BOOL"),
        *(("INT 1", "INT 1", "INT 2", True), ("INT 1", "INT 3", "INT 2", False)),
    ),
    *rows(
        *("LT({0}, {1}, {2})", "BOOL"),
        *(("INT 1", "INT 2", "INT 3", True), ("INT 1", "INT 2", "INT 2", False)),
    ),
    *rows("NE({0}, {1})", "BOOL", ("INT 1", "INT 1", False), ("INT 1", "INT 2", True)),
    *rows("{0} < {1}", "BOOL", ("WORD 16#7FFF", "WORD 16#8000", True), ("INT -1", "INT 0", True)),
    *rows(
        *("{0} > {1}", "BOOL"),
        *(("UDINT 4294967295", "UDINT 1", True), ("BOOL TRUE", "BOOL FALSE", True)),
    ),
    *rows("{0} <= {1}", "BOOL", ("INT 1", "INT 1", True), ("INT 2", "INT 1", False)),
    *rows("{0} >= {1}", "BOOL", ("INT 1", "INT 1", True), ("INT 1", "INT 2", False)),
    *rows("{0} <> {1}", "BOOL", ("INT 1", "INT 1", False), ("INT 1", "INT 2", True)),
]

TABLE = [*_shifts(), *_integers(), *_SIGNS, *_REALS, *_TIMES, *_CONVERSIONS, *_CHOICES, *TEXTS]
