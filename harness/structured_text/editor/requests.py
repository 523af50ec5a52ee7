"""The requests of an editor about a document, answered from the index of names."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, Protocol, TypeVar

from lsprotocol import types
from pygls.exceptions import JsonRpcException
from pygls.uris import to_fs_path

from structured_text.editor.extras import Extras
from structured_text.editor.features.completion import completion, resolved
from structured_text.editor.features.definition import (
    definition,
    implementations,
    type_definition,
)
from structured_text.editor.features.folding import folding
from structured_text.editor.features.hints import hints
from structured_text.editor.features.hover import hover
from structured_text.editor.features.outline import outline
from structured_text.editor.features.references import highlights, references
from structured_text.editor.features.rename import prepare, rename
from structured_text.editor.features.signature import TRIGGERS, signature
from structured_text.editor.features.tokens import LEGEND, tokens
from structured_text.editor.format.formatter import formatted
from structured_text.editor.index import Index
from structured_text.editor.names import Definition, spec_name
from structured_text.editor.programs import Program, Programs
from structured_text.errors import InputError
from structured_text.output.paths import real
from structured_text.projects.diagrams.sfc.model import has_chart
from structured_text.projects.formats import is_project

__all__ = ["Requests"]

_T = TypeVar("_T")
#: The error code of the protocol for a request that cannot be fulfilled, with a message for users.
_REQUEST_FAILED = -32803


class _Server(Protocol):
    """The part of the server that answers requests."""

    extras: Extras
    programs: Programs
    command_name: str

    def feature(self, name: str, options: Any = None) -> Callable[[Any], Any]:
        """Register a function for a request."""

    def do(self, work: Callable[..., _T], *arguments: Any) -> Awaitable[_T]:
        """Run work on programs after all earlier work."""


class Requests:
    """Registers the requests at a server."""

    def __init__(self, server: _Server) -> None:
        self._server = server
        self._completed: Program | None = None
        on = self._on
        on(types.TEXT_DOCUMENT_HOVER, self._hover)
        on(
            types.TEXT_DOCUMENT_COMPLETION,
            self._completion,
            types.CompletionOptions([".", "#", "%"], resolve_provider=True),
        )
        on(types.COMPLETION_ITEM_RESOLVE, self._resolved)
        on(
            types.TEXT_DOCUMENT_SIGNATURE_HELP,
            self._signature,
            types.SignatureHelpOptions(list(TRIGGERS)),
        )
        on(types.TEXT_DOCUMENT_DEFINITION, self._places(definition))
        on(types.TEXT_DOCUMENT_TYPE_DEFINITION, self._places(type_definition))
        on(types.TEXT_DOCUMENT_IMPLEMENTATION, self._places(implementations))
        on(types.TEXT_DOCUMENT_REFERENCES, self._references)
        on(types.TEXT_DOCUMENT_DOCUMENT_HIGHLIGHT, self._places(highlights))
        on(types.TEXT_DOCUMENT_PREPARE_RENAME, self._places(prepare))
        on(types.TEXT_DOCUMENT_RENAME, self._rename, types.RenameOptions(prepare_provider=True))
        on(types.TEXT_DOCUMENT_DOCUMENT_SYMBOL, self._whole(outline))
        on(types.TEXT_DOCUMENT_FOLDING_RANGE, self._whole(folding))
        on(types.TEXT_DOCUMENT_SEMANTIC_TOKENS_FULL, self._whole(tokens), LEGEND)
        on(types.TEXT_DOCUMENT_INLAY_HINT, self._hints)
        on(
            types.TEXT_DOCUMENT_CODE_ACTION,
            self._fixes,
            types.CodeActionOptions([types.CodeActionKind.QuickFix]),
        )
        on(types.TEXT_DOCUMENT_FORMATTING, self._formatted)
        on(types.TEXT_DOCUMENT_CODE_LENS, self._lenses, types.CodeLensOptions())

    def _on(self, method: str, work: Callable[[Any], Any], options: Any = None) -> None:
        """Answer a request by work on programs; bad input is an answer with its message."""

        async def called(given: Any) -> Any:
            try:
                return await self._server.do(work, given)
            except InputError as error:
                raise JsonRpcException(str(error), _REQUEST_FAILED) from None

        self._server.feature(method, options)(called)

    def _indexed(self, given: Any, *, current: bool = True) -> tuple[Index, Path, str] | None:
        """Return the index for a document, its path in the index, and its text."""
        path = to_fs_path(given.text_document.uri)
        if not path:
            return None
        program = self._server.programs.of(Path(path))
        index = program.index(current=current)
        if index is None:
            return None
        self._completed = program
        text = self._server.programs.documents.text(Path(path))
        return index, program.named(Path(path)), text

    # --- requests ---

    def _places(self, feature: Callable[..., _T]) -> Callable[[Any], _T | None]:
        """Return the answer to a request about a position."""

        def answer(given: Any) -> _T | None:
            found = self._indexed(given)
            return None if found is None else feature(*found, given.position)

        return answer

    def _whole(self, feature: Callable[..., _T]) -> Callable[[Any], _T | None]:
        """Return the answer to a request about a document."""

        def answer(given: Any) -> _T | None:
            found = self._indexed(given, current=False)
            return None if found is None else feature(*found)

        return answer

    def _hover(self, given: types.HoverParams) -> types.Hover | None:
        found = self._indexed(given)
        if found is None:
            return None
        extras = self._server.extras
        return hover(*found, given.position, lambda name: extras.hover(*_named(name)))

    def _completion(self, given: types.CompletionParams) -> list[types.CompletionItem] | None:
        found = self._indexed(given, current=False)
        return None if found is None else completion(*found, given.position)

    def _resolved(self, given: types.CompletionItem) -> types.CompletionItem:
        index = self._completed.index(current=False) if self._completed is not None else None
        return given if index is None else resolved(index, given)

    def _hints(self, given: types.InlayHintParams) -> list[types.InlayHint] | None:
        found = self._indexed(given)
        return None if found is None else hints(*found, given.range)

    def _signature(self, given: types.SignatureHelpParams) -> types.SignatureHelp | None:
        found = self._indexed(given, current=False)
        return None if found is None else signature(*found, given.position)

    def _fixes(self, given: types.CodeActionParams) -> list[types.CodeAction] | None:
        path = to_fs_path(given.text_document.uri)
        if not path:
            return None
        text = self._server.programs.documents.text(Path(path))
        fixes = self._server.extras.fixes(Path(path), text, given.context.diagnostics)
        return [
            types.CodeAction(
                one.title,
                types.CodeActionKind.QuickFix,
                [one.diagnostic],
                edit=types.WorkspaceEdit({given.text_document.uri: one.edits}),
            )
            for one in fixes
        ]

    def _formatted(self, given: types.DocumentFormattingParams) -> list[types.TextEdit] | None:
        """Return the edit that lays out the text; raise InputError on a mistake in the text.

        Projects of tools, and files with a Sequential Function Chart, are not formatted.
        """
        path = to_fs_path(given.text_document.uri)
        if not path:
            return None
        text = self._server.programs.documents.text(Path(path))
        if is_project(Path(path)) or has_chart(text):
            return None
        new = formatted(text, Path(path))
        whole = types.Range(types.Position(0, 0), types.Position(text.count("\n") + 1, 0))
        return [] if new == text else [types.TextEdit(whole, new)]

    def _lenses(self, given: types.CodeLensParams) -> list[types.CodeLens] | None:
        path = to_fs_path(given.text_document.uri)
        if not path:
            return None
        program = self._server.programs.of(Path(path))
        sources = program.sources()
        wanted = real(path)
        return [
            types.CodeLens(
                types.Range(place := types.Position(one.line - 1, 0), place),
                types.Command(
                    one.title, self._server.command_name, arguments=[one.action, *one.arguments]
                ),
            )
            for file in sources.own
            if real(file) == wanted
            for one in self._server.extras.lenses(Path(path), program.read(file), sources)
        ]

    def _references(self, given: types.ReferenceParams) -> list[types.Location] | None:
        found = self._indexed(given)
        if found is None:
            return None
        return references(*found, given.position, declared=given.context.include_declaration)

    def _rename(self, given: types.RenameParams) -> types.WorkspaceEdit | None:
        found = self._indexed(given)
        if found is None:
            return None
        assert self._completed is not None
        _, library = self._completed.sources().users
        return rename(*found, given.position, given.new_name, library)


def _named(definition: Definition) -> tuple[str, str, str]:
    """Return the owner and the name of a declared name, and its type if it is a variable."""
    node = definition.node
    kind = spec_name(node.spec) if definition.kind == "variable" else ""
    return definition.owner, definition.name, kind
