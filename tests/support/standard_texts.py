"""The standard functions of strings at their limits, and named arguments.

Values were calculated by hand from IEC 61131-3, 2.5.1.5.5 (table 29) and 2.5.1.3 (table 19).
"""

from __future__ import annotations

from standard_rows import Row, rows

# --- strings (table 29): positions count from 1, and a STRING has at most 126 characters ---

#: 126 characters, in which neighbours always differ.
FULL = "".join(chr(ord("0") + k % 75) for k in range(126))
_S, _FULL = "STRING 'abcdef'", f"STRING '{FULL}'"


def _texts() -> list[Row]:
    two, long = "STRING 'XY'", f"STRING '{FULL[:100]}'"
    return [
        *rows("LEN({0})", "INT", ("STRING ''", 0), (_S, 6), (_FULL, 126)),
        *rows(
            *("LEFT({0}, {1})", "STRING"),
            *((_S, "INT 0", ""), (_S, "INT 1", "a"), (_S, "INT 5", "abcde")),
            *((_S, "INT 6", "abcdef"), (_S, "INT 7", "abcdef"), (_FULL, "INT 126", FULL)),
            ("STRING ''", "INT 1", ""),
        ),
        *rows(
            *("RIGHT({0}, {1})", "STRING"),
            *((_S, "INT 0", ""), (_S, "INT 1", "f"), (_S, "INT 5", "bcdef")),
            *((_S, "INT 6", "abcdef"), (_S, "INT 7", "abcdef"), (_FULL, "INT 1", FULL[125])),
        ),
        *rows(
            *("MID({0}, {1}, {2})", "STRING"),
            *((_S, "INT 1", "INT 1", "a"), (_S, "INT 2", "INT 3", "cd")),
            *((_S, "INT 1", "INT 6", "f"), (_S, "INT 6", "INT 1", "abcdef")),
            (_S, "INT 0", "INT 2", ""),
        ),
        *rows(
            *("MID({0}, {1}, {2})", "STRING"),
            *((_S, "INT 3", "INT 5", "ef"), (_S, "INT 9", "INT 2", "bcdef")),
        ),
        *rows(
            *("CONCAT({0}, {1})", "STRING"),
            *((_S, two, "abcdefXY"), ("STRING ''", two, "XY")),
            *((long, long, FULL[:100] + FULL[:26]), (_FULL, two, FULL)),
            (two, _FULL, "XY" + FULL[:124]),
        ),
        *rows(
            *("CONCAT({0}, {1}, {2})", "STRING"),
            (two, _S, two, "XYabcdefXY"),
            (long, _S, long, FULL[:100] + "abcdef" + FULL[:20]),
        ),
        *rows(
            *("INSERT({0}, {1}, {2})", "STRING"),
            *((_S, two, "INT 0", "XYabcdef"), (_S, two, "INT 1", "aXYbcdef")),
            *((_S, two, "INT 5", "abcdeXYf"), (_S, two, "INT 6", "abcdefXY")),
            (_FULL, two, "INT 1", FULL[0] + "XY" + FULL[1:124]),
            *((_FULL, two, "INT 125", FULL[:125] + "X"), (_FULL, two, "INT 126", FULL)),
            (two, _FULL, "INT 1", "X" + FULL[:125]),
            (long, long, "INT 50", FULL[:50] + FULL[:76]),
        ),
        *rows(
            *("DELETE({0}, {1}, {2})", "STRING"),
            *((_S, "INT 1", "INT 1", "bcdef"), (_S, "INT 2", "INT 3", "abef")),
            *((_S, "INT 1", "INT 6", "abcde"), (_S, "INT 6", "INT 1", "")),
            *((_S, "INT 0", "INT 1", "abcdef"), (_FULL, "INT 125", "INT 2", FULL[0])),
        ),
        *rows("DELETE({0}, {1}, {2})", "STRING", (_S, "INT 9", "INT 3", "ab")),
        *rows(
            *("REPLACE({0}, {1}, {2}, {3})", "STRING"),
            (_S, two, "INT 2", "INT 5", "abcdXY"),
            *((_S, "STRING ''", "INT 2", "INT 2", "adef"), (_S, two, "INT 6", "INT 1", "XY")),
        ),
        # matiec inserts no more characters than it deletes.
        *rows(
            *("REPLACE({0}, {1}, {2}, {3})", "STRING"),
            *((_S, two, "INT 1", "INT 1", "XYbcdef"), (_S, two, "INT 0", "INT 3", "abXYcdef")),
            (_FULL, two, "INT 1", "INT 1", "XY" + FULL[1:125]),
            (long, long, "INT 10", "INT 91", FULL[:90] + FULL[:36]),
            alike=False,
        ),
        *rows(
            *("FIND({0}, {1})", "INT"),
            *((_S, "STRING 'a'", 1), (_S, "STRING 'f'", 6), (_S, "STRING 'cd'", 3)),
            *((_S, "STRING 'x'", 0), (_S, "STRING 'abcdefg'", 0)),
            *(("STRING 'abab'", "STRING 'ab'", 1), (_S, "STRING 'A'", 0)),
        ),
        # After a partial match, matiec skips the matched characters, and so can miss a later match.
        *rows("FIND({0}, {1})", "INT", ("STRING 'aab'", "STRING 'ab'", 2), alike=False),
        *rows(
            *("{0} < {1}", "BOOL"),
            *(("STRING 'a'", "STRING 'b'", True), ("STRING 'a'", "STRING 'aa'", True)),
            *(("STRING 'b'", "STRING 'aa'", False), ("STRING ''", "STRING 'a'", True)),
            ("STRING 'Z'", "STRING 'a'", True),
        ),
        *rows(
            *("{0} = {1}", "BOOL"),
            *(("STRING 'ab'", "STRING 'ab'", True), ("STRING 'ab'", "STRING 'aB'", False)),
        ),
        *rows("LEN(CONCAT({0}, {1}))", "INT", (long, long, 126)),
        *rows("LEN(INSERT({0}, {1}, {2}))", "INT", (long, long, "INT 3", 126)),
        *rows(
            "LEN(REPLACE({0}, {1}, {2}, {3}))",
            "INT",
            (long, long, "INT 1", "INT 3", 126),
            alike=False,
        ),
        *rows("MAX({0}, {1})", "STRING", ("STRING 'b'", "STRING 'ab'", "b")),
    ]


def _by_name() -> list[Row]:
    """Return rows with named arguments in another order (table 19)."""
    two = "STRING 'XY'"
    return [
        *rows("LEFT(L := {0}, IN := {1})", "STRING", ("INT 2", _S, "ab")),
        *rows("RIGHT(L := {0}, IN := {1})", "STRING", ("INT 2", _S, "ef")),
        *rows("MID(P := {0}, L := {1}, IN := {2})", "STRING", ("INT 3", "INT 2", _S, "cd")),
        *rows("DELETE(P := {0}, L := {1}, IN := {2})", "STRING", ("INT 3", "INT 1", _S, "abdef")),
        *rows("INSERT(P := {0}, IN2 := {1}, IN1 := {2})", "STRING", ("INT 1", two, _S, "aXYbcdef")),
        *rows(
            "REPLACE(P := {0}, L := {1}, IN2 := {2}, IN1 := {3})",
            "STRING",
            ("INT 4", "INT 2", two, _S, "abcXYf"),
        ),
        *rows("FIND(IN2 := {0}, IN1 := {1})", "INT", ("STRING 'cd'", _S, 3)),
        *rows("CONCAT(IN2 := {0}, IN1 := {1})", "STRING", (two, _S, "abcdefXY")),
        *rows("SUB(IN2 := {0}, IN1 := {1})", "INT", ("INT 2", "INT 5", 3)),
        *rows("DIV(IN2 := {0}, IN1 := {1})", "INT", ("INT 2", "INT 7", 3)),
        *rows("MOD(IN2 := {0}, IN1 := {1})", "INT", ("INT 4", "INT 7", 3)),
        *rows("EXPT(IN2 := {0}, IN1 := {1})", "LREAL", ("INT 3", "LREAL 2.0", 8.0)),
        *rows("SHL(N := {0}, IN := {1})", "WORD", ("INT 1", "WORD 4", 8)),
        *rows("SHR(N := {0}, IN := {1})", "WORD", ("INT 1", "WORD 4", 2)),
        *rows("ROL(N := {0}, IN := {1})", "BYTE", ("INT 1", "BYTE 16#81", 3)),
        *rows("ROR(N := {0}, IN := {1})", "BYTE", ("INT 1", "BYTE 16#81", 0xC0)),
        *rows("LIMIT(MX := {0}, IN := {1}, MN := {2})", "INT", ("INT 5", "INT 7", "INT 0", 5)),
        *rows("MUX(IN1 := {0}, IN0 := {1}, K := {2})", "INT", ("INT 20", "INT 10", "INT 0", 10)),
        *rows("GT(IN2 := {0}, IN1 := {1})", "BOOL", ("INT 1", "INT 2", True)),
        *rows("LT(IN2 := {0}, IN1 := {1})", "BOOL", ("INT 1", "INT 2", False)),
    ]


TEXTS = [*_texts(), *_by_name()]
