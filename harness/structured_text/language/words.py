"""Keywords of object orientation and references that are also valid as names.

Older programs use words such as METHOD, THIS or GET as names. They are keywords only if the words
around them permit no other reading.
"""

from __future__ import annotations

import re

__all__ = ["ACCESSORS", "ACCESS_WORDS", "EXCEPTIONS", "OBJECT_WORDS", "Context", "is_soft"]

#: Words that can stand before the name of a method, property, block or interface.
ACCESS_WORDS = frozenset(
    ["PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "FINAL", "ABSTRACT", "OVERRIDE"]
)
#: Words of CODESYS for exceptions, with the kinds of their tokens.
EXCEPTIONS = {"__TRY": "TRY", "__CATCH": "CATCH", "__FINALLY": "FINALLY", "__ENDTRY": "END_TRY"}
ACCESSORS = ("GET", "SET", "END_GET", "END_SET")

_TO = re.compile(r"\s+TO\b", re.IGNORECASE)
_NAME = re.compile(r"\s+(?!(?:AND|OR|XOR|MOD|THEN|DO|OF|TO|BY)\b)[A-Z_\x80-\uffff]", re.IGNORECASE)
_MEMBER = re.compile(r"\s*[.^]|\s*[;,)]")
_END = re.compile(r"(?!\s*[:,)])")
#: Matches, for each word, the text that follows it if the word is a keyword.
_FOLLOWS = {
    **dict.fromkeys(("POINTER", "REFERENCE"), _TO),
    **dict.fromkeys(("METHOD", "PROPERTY", "INTERFACE", "CLASS", "NAMESPACE", "USING"), _NAME),
    **dict.fromkeys(("EXTENDS", "IMPLEMENTS"), _NAME),
    "REF_TO": _NAME,
    **dict.fromkeys(("THIS", "SUPER"), _MEMBER),
    **dict.fromkeys(("END_METHOD", "END_PROPERTY", "END_INTERFACE", "END_NAMESPACE"), _END),
    "END_CLASS": _END,
}
OBJECT_WORDS = frozenset(_FOLLOWS)
_HEADS = ("METHOD", "PROPERTY", "FUNCTION_BLOCK", "INTERFACE", "FUNCTION", "CLASS")
#: Words that may stand before the access word of a section of variables, as in `VAR CONSTANT
#: PUBLIC`.
_OF_SECTIONS = frozenset(
    (
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_STAT", "VAR_TEMP", "VAR_GLOBAL"),
        *("CONSTANT", "RETAIN", "NON_RETAIN", "PERSISTENT"),
    )
)
#: Matches the text behind an access word, unless the text shows that the word is the name of a
#: variable.
_NOT_USED = re.compile(r"(?!\s*(?:[:.,\[;^=<>+*-]|\((?!\*)|/(?![/*])|AT\b))", re.IGNORECASE)
#: Matches a name on the same line behind an access word. Without such a name, the access word is
#: the name itself: `Final` in `METHOD Final`.
_NAME_FOLLOWS = re.compile(
    r"[ \t]+(?!(?:VAR\w*|END_METHOD|EXTENDS|IMPLEMENTS)\b)[A-Z_\x80-\uffff]\w*", re.IGNORECASE
)

#: Qualifiers behind VAR or another section word. Elsewhere these words are names.
_QUALIFIERS = ("CONSTANT", "RETAIN", "NON_RETAIN", "PERSISTENT")
#: Matches text that may follow a name, but not one of these keywords.
_AS_NAME = re.compile(r"\s*(?::|\.(?!\.)|,|\[|\((?!\*)|=>)")


def is_soft(word: str, previous: str, text: str, behind: int) -> bool:
    """Return whether a keyword is used as a name here.

    `previous` is the kind of the token before it, and `behind` the offset behind the word.
    """
    if word in _QUALIFIERS:
        behind_section = previous.startswith("VAR") or previous in (*_QUALIFIERS, "WORD")
        return not behind_section or _AS_NAME.match(text, behind) is not None
    begins = previous in ("", "SEMICOLON", "ERROR") or previous.startswith("END_")
    if word in ("CONFIGURATION", "ACTION"):
        return not begins or _AS_NAME.match(text, behind) is not None
    if word == "UNION":
        return previous != "COLON" or _AS_NAME.match(text, behind) is not None
    if word == "CONTINUE":
        begins = begins or previous in ("THEN", "ELSE", "DO", "REPEAT", "COLON", "OF")
        return not begins or _AS_NAME.match(text, behind) is not None
    if word in ("END_CONFIGURATION", "END_ACTION", "END_UNION"):
        return _AS_NAME.match(text, behind) is not None
    return False


class Context:
    """Follows the words of a source, so that the lexer can recognise keywords."""

    def __init__(self) -> None:
        self._before = ""
        self._in_property = self._in_accessor = False

    def kind(self, word: str, previous: str, text: str, behind: int) -> str:
        """Return the token kind of a word, or an empty string if it is not such a keyword.

        `previous` is the kind of the token before it, and `behind` the offset behind the word.
        """
        before, self._before = self._before, word
        if word in ACCESS_WORDS:
            is_access = _NAME_FOLLOWS if before in _HEADS else _NOT_USED
            opened = previous in ("GET", "SET") and self._in_accessor
            placed = before in _HEADS or before in _OF_SECTIONS or opened
            if placed and previous != "DOT" and is_access.match(text, behind):
                self._before = before
                return "WORD"
            return ""
        if self._in_property and word in ACCESSORS and before != "PROPERTY" and previous != "DOT":
            return self._accessor(word)
        if word not in _FOLLOWS or previous == "DOT" or before in _HEADS:
            return ""
        if not _FOLLOWS[word].match(text, behind):
            return ""
        if word == "PROPERTY":
            self._in_property, self._in_accessor = True, False
        elif word == "END_PROPERTY":
            self._in_property = False
        return word

    def _accessor(self, word: str) -> str:
        """Return the word if it is a keyword here, else an empty string.

        GET and SET are keywords if no accessor is open. END_GET and END_SET are keywords if one is
        open.
        """
        opens = not word.startswith("END_")
        if opens == self._in_accessor:
            return ""
        self._in_accessor = opens
        return word
