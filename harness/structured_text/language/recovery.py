"""The parser loop with error recovery: it continues behind each mistake.

The LALR parser stops at the first token that it does not expect. Recovery then takes these steps.
If only a semicolon is missing, it is inserted. Otherwise the parser's stack is unwound to the last
state in which the grammar accepts the token ERROR, that is the beginning of a statement or
declaration. ERROR stands for the broken part. Tokens are skipped up to its end, which is a
semicolon, the end of the group around it, or the next declaration of the file. A second failure at
the same token skips that token, so the loop always ends.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from lark import Lark, Token
from lark.exceptions import UnexpectedToken

from structured_text.errors import InputError
from structured_text.language.foreign import LABELS
from structured_text.language.lexer import KEYWORDS, PUNCTUATION
from structured_text.language.scalars import ELEMENTARY
from structured_text.output.limits import MOST_MISTAKES

__all__ = ["AT_END", "read_tokens"]

#: Last words of the hint about a group of statements that has no END up to the end of the file.
AT_END = "the end of the file"

_SPELLING = {name: f"'{text}'" for text, name in PUNCTUATION.items()}
_INSTRUCTION_LIST = frozenset(
    ["LD", "LDN", "ST", "STN", "ANDN", "ORN", "XORN", "CAL", "CALC", "RET", "RETC"]
)
#: Words that open a group of statements or declarations, with the word that closes it.
_OPENERS = {
    word: f"END_{word}" for word in ("IF", "CASE", "FOR", "WHILE", "REPEAT", "STRUCT", "UNION")
}
_CLOSERS = frozenset(_OPENERS.values())
#: Words that end the group of statements or declarations in which a mistake is.
_GROUP_ENDS = _CLOSERS | frozenset(
    (
        *("ELSE", "ELSIF", "UNTIL", "END_VAR", "END_TYPE", "END_ACTION", "ACTION"),
        *(
            "END_CLASS",
            "METHOD",
            "END_METHOD",
            "PROPERTY",
            "END_PROPERTY",
            "GET",
            "END_GET",
            "SET",
            "END_SET",
        ),
    )
)
#: Reserved words that begin no group. If such a word is unexpected, the user meant it as a name.
_RESERVED = frozenset(
    word
    for word in KEYWORDS
    if not word.startswith(("END_", "VAR")) and word not in (*_OPENERS, *_GROUP_ENDS)
)
_NOTHING_BEFORE = frozenset(("END_VAR", "THEN", "ELSE", "DO", "OF", "REPEAT", "COLON"))
#: Words that begin a declaration of a file, and words that end it.
_DECLARATIONS = (
    "INTERFACE",
    "CLASS",
    "NAMESPACE",
    "TYPE",
    "FUNCTION",
    "FUNCTION_BLOCK",
    "PROGRAM",
    "CONFIGURATION",
)
_DECLARATION_ENDS = frozenset(f"END_{word}" for word in _DECLARATIONS)
#: Words that begin a section of variables, words that begin a statement, and words that end a part
#: of a POU.
_SECTIONS = frozenset(word for word in KEYWORDS if word.startswith("VAR"))
_STATEMENTS = frozenset(("IF", "CASE", "FOR", "WHILE", "REPEAT", "EXIT", "RETURN"))
_PART_ENDS = ("END_METHOD", "END_ACTION", "END_PROPERTY", "END_GET", "END_SET")
#: Declarations with an END that a source of several POUs must have.
_WITH_END = ("FUNCTION_BLOCK", "FUNCTION", "PROGRAM", "TYPE")
_MEMBERS = ("METHOD", "PROPERTY")
#: Words that end a condition or the head of a statement.
_HEAD_ENDS = ("THEN", "DO", "OF")
#: Words of a FOR in other languages, each with the correct token and the text to write.
_OF_FOR = {"STEP": "BY", "UNTIL": "TO"}
#: Tokens that can follow a name in a statement, but not in a declaration.
_OF_STATEMENTS = ("ASSIGN", "LPAR", "DOT", "LSQB", "CARET")
_POU_ENDS = ("END_PROGRAM", "END_FUNCTION_BLOCK", "END_FUNCTION")


def read_tokens(lark: Lark, found: list[Token], file: Path) -> tuple[list[Any], list[InputError]]:
    """Parse tokens.

    Returns:
        The declarations, as far as they could be read, and every mistake.
    """
    return _Run(lark, found, file).run()


class _Run:
    """The state of the parser in one file."""

    def __init__(self, lark: Lark, found: list[Token], file: Path) -> None:
        self._parser = lark.parse_interactive("")
        self._state = self._parser.parser_state
        self._found, self._file = found, file
        self._errors: list[InputError] = []
        last = found[-1] if found else Token("$END", "", 0, 1, 1)
        self._end = Token.new_borrow_pos("$END", "", last)

    def run(self) -> tuple[list[Any], list[InputError]]:
        """Parse all tokens; see `read_tokens`."""
        feed = self._state.feed_token
        found, at, failed = self._found, 0, -1
        while True:
            try:
                while at < len(found):
                    feed(found[at])
                    at += 1
                self._end_pou()
                declarations: list[Any] = self._state.feed_token(self._end, True)
                return declarations, self._errors
            except UnexpectedToken as error:
                error.interactive_parser = self._parser
                if at == failed:
                    at += 1
                    if at > len(found):
                        return [], self._errors
                    continue
                behind = self._inserted(at)
                if behind < 0:
                    behind = self._closed(at)
                if behind >= 0:
                    at = behind
                    continue
                failed = at
                self._errors.append(self._mistake(error, at))
                if len(self._errors) >= MOST_MISTAKES:
                    self._errors.append(self._too_many(at))
                    return [], self._errors
                at = self._recovered(at)

    def _end_pou(self) -> None:
        """Insert the END of the last POU if it is missing.

        Tools that show each POU separately write no END.
        """
        if "$END" in self._acceptable():
            return
        accepted = self._parser.accepts()  # type: ignore[no-untyped-call]
        for word in _POU_ENDS:
            if word in accepted:
                self._state.feed_token(Token.new_borrow_pos(word, "", self._end))
                return

    def _inserted(self, at: int) -> int:
        """Report = in place of :=, or a missing THEN, DO or OF, and continue as if it were right.

        Returns:
            The index of the token that comes next; -1 if the mistake is of another kind.
        """
        if not 0 < at < len(self._found):
            return -1
        token, before = self._found[at], self._found[at - 1]
        accepted = self._parser.accepts()  # type: ignore[no-untyped-call]
        if token == "=" and "ASSIGN" in accepted:
            self._errors.append(self._error("= compares, and does not assign", token, "write :="))
            self._state.feed_token(Token.new_borrow_pos("ASSIGN", ":=", token))
            return at + 1
        if token.type == "SENDTO" and "GE" in accepted:
            return self._replaced("=> is not a comparison", token, "GE", ">=", at)
        meant = _OF_FOR.get(token.upper(), "")
        if meant and meant in accepted:
            return self._replaced(f"a FOR has no {token}", token, meant, meant, at)
        repaired = self._repaired(token, before, accepted, at)
        if repaired >= 0:
            return repaired
        word = next((word for word in _HEAD_ENDS if word in accepted), "")
        if not word or (token.line == before.line and not self._begins(at)):
            return -1
        hint = f"write it after {str(before)!r}"
        self._errors.append(self._error(f"{word} is missing", before, hint, after=True))
        self._state.feed_token(Token.new_borrow_pos(word, word, token))
        return at

    def _replaced(self, message: str, token: Token, kind: str, text: str, at: int) -> int:
        """Report a wrong token, and continue with the correct token in its place."""
        self._errors.append(self._error(message, token, f"write {text}"))
        self._state.feed_token(Token.new_borrow_pos(kind, text, token))
        return at + 1

    def _begins(self, at: int) -> bool:
        """Return whether a statement begins at a token: a name and :=, or a label."""
        follows = self._found[at + 1].type if at + 1 < len(self._found) else ""
        return follows in ("ASSIGN", "COLON")

    def _repaired(self, token: Token, before: Token, accepted: set[str], at: int) -> int:
        """Report a mistake that has one evident repair, and continue behind it.

        Returns:
            The index of the token that comes next; -1 if the mistake is of another kind.
        """
        feed = self._state.feed_token
        follows = self._found[at + 1].type if at + 1 < len(self._found) else ""
        named = token.type == "IDENT" and follows in ("ASSIGN", "SENDTO")
        if named and {"COMMA", "RPAR"} <= accepted:
            hint = f"write it after {str(before)!r}"
            self._errors.append(self._error("a ',' is missing", before, hint, after=True))
            feed(Token.new_borrow_pos("COMMA", ",", token))
            return at
        if token.type == "RPAR" and "SEMICOLON" in accepted:
            self._errors.append(self._error("there is no ( for this )", token, "remove it"))
            return at + 1
        if token.type == "ELSE" and "END_IF" in accepted and self._opened():
            text = f"the IF of line {self._opened()[-1].line} has a second ELSE"
            hint = "write ELSIF and a condition in place of the first one, or remove it"
            self._errors.append(self._error(text, token, hint))
            feed(Token.new_borrow_pos("END_IF", "END_IF", token))
            feed(self._semicolon(token))
            for word in ("IF", "TRUE", "THEN"):
                feed(Token.new_borrow_pos(word, word, token))
            return at + 1
        if token.type == "END_REPEAT" and "UNTIL" in accepted:
            hint = "write UNTIL and a condition before it"
            self._errors.append(self._error("REPEAT has no UNTIL", token, hint))
            feed(Token.new_borrow_pos("UNTIL", "UNTIL", token))
            feed(Token.new_borrow_pos("TRUE", "TRUE", token))
            return at
        if "END_REPEAT" in accepted and "UNTIL" not in accepted and self._opened():
            return self._end_of_repeat(token, before, at)
        if "COLON" in accepted and before.type == "IDENT" and at > 1:
            return self._in_section(token, before, at)
        return -1

    def _end_of_repeat(self, token: Token, before: Token, at: int) -> int:
        """Report a REPEAT without END_REPEAT behind its condition, and continue behind it."""
        if token.type in _CLOSERS or self._ends_pou(token, at):
            return -1
        if token.line == before.line and before.type != "SEMICOLON":
            return -1
        until = next(one for one in self._found[at - 1 :: -1] if one.type == "UNTIL")
        hint = f"write END_REPEAT after the condition of line {until.line}"
        text = "the REPEAT of this line has no END_REPEAT"
        self._errors.append(self._error(text, self._opened()[-1], hint))
        self._state.feed_token(Token.new_borrow_pos("END_REPEAT", "END_REPEAT", token))
        if "SEMICOLON" in self._parser.accepts():  # type: ignore[no-untyped-call]
            self._state.feed_token(self._semicolon(token))
        return at

    def _in_section(self, token: Token, before: Token, at: int) -> int:
        """Repair a section of variables: it has no END_VAR, or a type stands before its name."""
        opener = next((one for one in self._found[at - 1 :: -1] if one.type in _SECTIONS), None)
        first = self._found[at - 2].type
        if opener is None or not (first == "SEMICOLON" or first in _SECTIONS):
            return -1
        states, values = self._state.state_stack, self._state.value_stack
        if token.type == "IDENT" and token.line == before.line:
            hint = f"write {token} : {before}"
            self._errors.append(self._error("the name stands before its type", before, hint))
            states.pop()
            values.pop()
            for one in (token, Token.new_borrow_pos("COLON", ":", token)):
                self._state.feed_token(one)
            self._state.feed_token(before)
            return at + 1
        if token.type not in _OF_STATEMENTS:
            return -1
        hint = f"write END_VAR before the {before} of line {before.line}"
        text = f"the {opener} section has no END_VAR"
        self._errors.append(self._error(text, opener, hint))
        states.pop()
        values.pop()
        self._state.feed_token(Token.new_borrow_pos("END_VAR", "END_VAR", before))
        return at - 1

    # --- groups without an end ---

    def _closed(self, at: int) -> int:
        """Report and close the groups that should end before a token.

        Returns:
            The index of the token that comes next; -1 if there is no such group.
        """
        token = self._found[at] if at < len(self._found) else self._end
        behind = -1
        while (opener := self._unclosed(token, at)) is not None:
            word = "END_VAR" if opener.type in _SECTIONS else _OPENERS[opener.type]
            if word == "END_REPEAT" and "UNTIL" in self._parser.accepts():  # type: ignore[no-untyped-call]
                for kind in ("UNTIL", "TRUE"):
                    self._state.feed_token(Token.new_borrow_pos(kind, kind, token))
            if word not in self._parser.accepts():  # type: ignore[no-untyped-call]
                break
            wrong = self._is_wrong(token)
            error = self._wrong_end if wrong else self._no_end
            self._errors.append(error(opener, word, token, at))
            self._state.feed_token(Token.new_borrow_pos(word, word, token))
            behind = at
            if wrong:
                return at + 1
            if word != "END_VAR" and "SEMICOLON" in self._parser.accepts():  # type: ignore[no-untyped-call]
                self._state.feed_token(self._semicolon(token))
        return behind if behind >= 0 else self._ended_pou(token, at)

    def _ended_pou(self, token: Token, at: int) -> int:
        """Report and end a POU or TYPE with the wrong END, or without an END before the next one.

        Returns:
            The index of the token that comes next; -1 if the mistake is of another kind.
        """
        begins = token.type in _DECLARATIONS and (
            at == 0 or at >= len(self._found) or self._found[at - 1].line != token.line
        )
        begins = begins or token.type in _MEMBERS
        if not begins and token.type not in _DECLARATION_ENDS:
            return -1
        accepted = self._parser.accepts()  # type: ignore[no-untyped-call]
        within = token.type in ("METHOD", "PROPERTY") or token.type in _DECLARATION_ENDS
        kinds = (*_MEMBERS, *_WITH_END) if within else _WITH_END
        word = next((one for one in kinds if f"END_{one}" in accepted), "")
        first = next((one for one in self._found[at - 1 :: -1] if one.type == word), None)
        if not word or first is None:
            return -1
        if begins or word in _MEMBERS:
            text = f"the {word} of this line has no END_{word}"
            hint = f"write END_{word} before the {token} of line {token.line}"
            self._errors.append(self._error(text, first, hint))
        else:
            text = f"{token} does not end the {word} of line {first.line}"
            self._errors.append(self._error(text, token, f"write END_{word}"))
        self._state.feed_token(Token.new_borrow_pos(f"END_{word}", "", token))
        return at if begins or word in _MEMBERS else at + 1

    def _opened(self) -> list[Token]:
        """Return the words of the open groups of statements, the innermost last."""
        values = self._state.value_stack
        return [one for one in values if isinstance(one, Token) and one.type in _OPENERS]

    def _unclosed(self, token: Token, at: int) -> Token | None:
        """Return the innermost open group if this token shows that its END is missing."""
        accepted = self._parser.accepts()  # type: ignore[no-untyped-call]
        if "END_VAR" in accepted:
            starts = token.type in _STATEMENTS or token.type in _SECTIONS
            if not (starts or self._ends_pou(token, at)):
                return None
            return next((one for one in self._found[at - 1 :: -1] if one.type in _SECTIONS), None)
        opened = self._opened()
        if not opened:
            return None
        if token.type in _CLOSERS:
            return opened[-1] if token.type != _OPENERS[opened[-1].type] else None
        return opened[-1] if self._ends_pou(token, at) else None

    def _is_wrong(self, token: Token) -> bool:
        """Return whether a token ends a group that is not open, such as END_IF without IF."""
        ends = [_OPENERS[one.type] for one in self._opened()]
        return token.type in _CLOSERS and token.type not in ends

    def _wrong_end(self, opener: Token, word: str, token: Token, at: int) -> InputError:
        text = f"{token} does not end the {opener} of line {opener.line}"
        return self._error(text, token, f"write {word}")

    def _ends_pou(self, token: Token, at: int) -> bool:
        """Return whether a token ends a POU or a member of a POU, or begins the next POU."""
        if token.type in _WITH_END and at < len(self._found):
            return at > 0 and self._found[at - 1].line != token.line
        return token.type in _DECLARATION_ENDS or token.type in ("$END", *_PART_ENDS)

    def _no_end(self, opener: Token, word: str, token: Token, at: int) -> InputError:
        """Return the error for a group without an end, at the word that opens it."""
        if opener.type == "IF" and (second := self._else_if(opener, at)) is not None:
            text = f"ELSE IF opens a second IF, so the IF of line {opener.line} has no END_IF"
            return self._error(text, second, "write ELSIF")
        what = "section" if word == "END_VAR" else "of this line"
        before = AT_END
        if token.type != "$END":
            before = f"the {token} of line {token.line}"
        name = f"{opener} {what}"
        return self._error(f"the {name} has no {word}", opener, f"write {word} before {before}")

    def _else_if(self, opener: Token, at: int) -> Token | None:
        """Return the ELSE of an IF if another IF follows it on the same line."""
        depth = 0
        begin = next((k for k, one in enumerate(self._found) if one is opener), at)
        for one, follower in zip(self._found[begin:at], self._found[begin + 1 : at], strict=False):
            if one.type == "IF":
                depth += 1
            elif one.type == "END_IF":
                depth -= 1
            elif one.type == "ELSE" and depth == 1 and follower.type == "IF":
                return one if one.line == follower.line else None
        return None

    # --- recovery ---

    def _recovered(self, at: int) -> int:
        """Bring the parser to a state where it can continue; return the next token's index."""
        token = self._found[at] if at < len(self._found) else self._end
        if self._ends_here(token, self._found[at - 1] if at else token):
            self._state.feed_token(self._semicolon(token))
            return at
        depth = self._back()
        self._state.feed_token(Token.new_borrow_pos("ERROR", "", token))
        in_group = "SEMICOLON" in self._acceptable() and len(self._state.state_stack) > 3
        return self._skip(at, depth) if in_group else self._next_declaration(at)

    @staticmethod
    def _ended(token: Token, before: Token) -> bool:
        """Return whether a statement is complete: it has a semicolon, or needs none."""
        return "SEMICOLON" in (token.type, before.type) or before.type in _NOTHING_BEFORE

    def _ends_here(self, token: Token, before: Token) -> bool:
        """Return whether only a semicolon is missing before this token."""
        if "SEMICOLON" not in self._parser.accepts():  # type: ignore[no-untyped-call]
            return False
        if _is_declaration(token, before) or before.type == "RETURN":
            return False
        if token.type == "COLON" or before.upper() in (*_INSTRUCTION_LIST, "JMP", "GOTO"):
            # The words are a label, a jump or an instruction, and no semicolon is missing.
            return False
        return not self._ended(token, before)

    def _acceptable(self) -> set[str]:
        states = self._state.parse_conf.states
        return set(states[self._state.state_stack[-1]])

    def _takes_error(self) -> bool:
        """Return whether the parser accepts the token ERROR in its present state.

        The parser table alone is not sufficient: it lists ERROR even if a later reduction would
        fail.
        """
        if "ERROR" not in self._acceptable():
            return False
        return "ERROR" in self._parser.accepts()  # type: ignore[no-untyped-call]

    def _back(self) -> int:
        """Unwind the stack to a state that accepts ERROR; return the number of open groups."""
        depth = 0
        states, values = self._state.state_stack, self._state.value_stack
        while not self._takes_error():
            states.pop()
            value = values.pop()
            depth += isinstance(value, Token) and value.type in _OPENERS
        return depth

    def _skip(self, at: int, depth: int) -> int:
        """Skip tokens up to the end of a statement or declaration; return the next index."""
        found = self._found
        while at < len(found):
            token = found[at]
            if token.type in _OPENERS:
                depth += 1
            elif token.type in _CLOSERS and depth:
                depth -= 1
                if not depth:
                    at += 1
                    break
            elif token.type in _DECLARATION_ENDS or (
                not depth and token.type in (*_GROUP_ENDS, "SEMICOLON")
            ):
                break
            at += 1
        follows = found[at] if at < len(found) else self._end
        self._state.feed_token(self._semicolon(follows))
        return at + 1 if follows.type == "SEMICOLON" else at

    def _next_declaration(self, at: int) -> int:
        """Skip tokens up to the next declaration of the file; return its index."""
        while at < len(self._found):
            token = self._found[at]
            first = at == 0 or self._found[at - 1].line != token.line
            if token.type in _DECLARATIONS and first:
                return at
            at += 1
        return at

    @staticmethod
    def _semicolon(near: Token) -> Token:
        return Token.new_borrow_pos("SEMICOLON", ";", near)

    # --- messages ---

    def _too_many(self, at: int) -> InputError:
        token = self._found[at] if at < len(self._found) else self._end
        text = f"{MOST_MISTAKES} mistakes in this file up to here; the rest was not read"
        return self._error(text, token, "check that this is Structured Text")

    def _mistake(self, error: UnexpectedToken, at: int) -> InputError:
        token = self._found[at] if at < len(self._found) else self._end
        before = self._found[at - 1] if at else token
        expected = set(error.accepts or error.expected)
        if before.upper() in _INSTRUCTION_LIST and token.type != "ASSIGN":
            hint = "write Structured Text"
            return self._error("Instruction List is not supported", before, hint)
        if token.type == "COLON" and before.type in ("IDENT", "LABEL") and "LPAR" in expected:
            return self._error(LABELS, before, "use IF, or a loop with EXIT")
        if before.type == "RETURN" and token.type != "END_IF" and token.line == before.line:
            hint = "assign the value to the name of the function before"
            return self._error("RETURN takes no value", before, hint)
        if _is_declaration(token, before):
            hint = f"write {token} : {before.upper()} there"
            return self._error("variables are declared between VAR and END_VAR", before, hint)
        if token.type in _RESERVED and "IDENT" in expected:
            message = f"{token} is a reserved word and cannot be used here"
            return self._error(message, token, _expectation(expected))
        needed = expected == {"SEMICOLON"} or not before.type.startswith("END_")
        if "SEMICOLON" in expected and needed and not self._ended(token, before):
            hint = f"write it after {str(before)!r}"
            return self._error("a ';' is missing", before, hint, after=True)
        if token.type == "$END":
            return self._error("the file ends too early", before, _expectation(expected))
        return self._error(f"{str(token)!r} is not expected here", token, _expectation(expected))

    def _error(
        self, message: str, token: Token, hint: str = "", *, after: bool = False
    ) -> InputError:
        column = (token.column or 1) + (len(token) if after else 0)
        return InputError(message, file=self._file, line=token.line, column=column, hint=hint)


def _is_declaration(token: Token, before: Token) -> bool:
    """Return whether a declaration as in C stands among statements."""
    return (
        token.type == "IDENT"
        and before.type in ("IDENT", "LABEL")
        and before.line == token.line
        and before.upper() in ELEMENTARY
    )


def _expectation(expected: set[str]) -> str:
    """Return a hint with the expected tokens, if they are few enough to help."""
    words = {"IDENT": "a name", "LABEL": "a label", "INTEGER": "a number", "DIRECT": "an address"}
    if "LPAR" in expected and "INTEGER" in expected:
        return "an expression is expected"
    named = [name for name in expected if name not in ("ERROR", "LATCH", "PART")]
    shown = sorted(_SPELLING.get(name) or words.get(name) or name for name in named)
    return f"expected {' or '.join(shown)}" if len(shown) <= 6 else ""
