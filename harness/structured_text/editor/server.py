"""The language server: it keeps an editor informed about the mistakes of a program.

The event loop reads the messages of the editor. All work on programs is done by a single thread,
one job after the other, because the parser serves only one. Slow work runs in `background`.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Iterable
from concurrent.futures import Executor, ThreadPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

from lsprotocol import types
from pygls.lsp.server import LanguageServer
from pygls.uris import to_fs_path

from structured_text.editor.diagnostics import Note, note_of_error, note_of_unread
from structured_text.editor.extras import Extras
from structured_text.editor.programs import Program, Programs
from structured_text.editor.requests import Requests
from structured_text.editor.results import Results
from structured_text.editor.settings import Settings
from structured_text.errors import InputError, legible
from structured_text.language.unread import unread_bodies
from structured_text.projects.sources import SourceFiles

__all__ = ["Server"]

_T = TypeVar("_T")
#: The slow checks wait for this number of pauses.
_PAUSES = 4


class Server(LanguageServer):
    """The language server of a distribution.

    Args:
        extras: What the distribution adds.
        background: Runs slow checks. None: the thread of the other work runs them.
    """

    def __init__(self, extras: Extras, background: Executor | None = None) -> None:
        super().__init__(extras.name, extras.version)
        self.extras = extras
        self._worker = ThreadPoolExecutor(1)
        self._background = background or self._worker
        self._own_background = background is not None
        self.programs = Programs([], Settings(), extras.find)
        self.results = Results(self.programs.documents, extras.name)
        self._timer: asyncio.TimerHandle | None = None
        self._changes = 0
        self._said: tuple[str, ...] = ()
        self._tasks: set[asyncio.Task[None]] = set()
        self.command_name = f"{extras.name}.perform"
        self._requests = Requests(self)
        self.command(self.command_name)(self._command())
        self._on(types.INITIALIZE, self._initialize)
        self._on(types.TEXT_DOCUMENT_DID_OPEN, self._opened)
        self._on(types.TEXT_DOCUMENT_DID_CHANGE, self._changed)
        self._on(types.TEXT_DOCUMENT_DID_SAVE, self._saved)
        self._on(types.TEXT_DOCUMENT_DID_CLOSE, self._closed)
        self._on(types.WORKSPACE_DID_CHANGE_WATCHED_FILES, self._saved)

    def _on(self, method: str, handler: Callable[[Any], None]) -> None:
        """Call a function for each message; pygls marks a handler, and a method has no marks."""

        def called(given: Any) -> None:
            handler(given)

        self.feature(method)(called)

    def end(self) -> None:
        """End the threads and processes of the server."""
        self._worker.shutdown(cancel_futures=True)
        if self._own_background:
            self._background.shutdown(cancel_futures=True)

    async def do(self, work: Callable[..., _T], *arguments: Any) -> _T:
        """Run work on programs after all earlier work."""
        loop = asyncio.get_running_loop()
        return await loop.run_in_executor(self._worker, work, *arguments)

    # --- messages of the editor ---

    def _initialize(self, given: types.InitializeParams) -> None:
        folders = [one.uri for one in given.workspace_folders or ()]
        if not folders and given.root_uri:
            folders = [given.root_uri]
        paths = [Path(path) for uri in folders if (path := to_fs_path(uri))]
        try:
            settings = Settings.of(given.initialization_options)
        except InputError as error:
            settings = Settings()
            self._tell(f"{error}; all settings keep their defaults", types.MessageType.Error)
        if paths:
            settings = settings.within(paths[0])
        self.programs = Programs(paths, settings, self.extras.find)
        self.results = Results(self.programs.documents, self.extras.name)

    def _opened(self, given: types.DidOpenTextDocumentParams) -> None:
        self._take(given.text_document.uri)
        self._later(0)

    def _changed(self, given: types.DidChangeTextDocumentParams) -> None:
        self._take(given.text_document.uri)
        self._later(self.programs.settings.pause)

    def _saved(
        self, given: types.DidSaveTextDocumentParams | types.DidChangeWatchedFilesParams
    ) -> None:
        del given
        self._worker.submit(self.programs.forget)
        self._later(0)

    def _closed(self, given: types.DidCloseTextDocumentParams) -> None:
        path = to_fs_path(given.text_document.uri)
        if path:
            self._worker.submit(self.programs.documents.drop, Path(path))
        self._worker.submit(self.programs.forget)
        self._later(0)

    def _take(self, uri: str) -> None:
        """Take over the text of a document; only files of this machine are documents."""
        path = to_fs_path(uri)
        if path:
            text = self.workspace.get_text_document(uri).source
            self._worker.submit(self.programs.documents.put, Path(path), uri, text)

    def _command(self) -> Callable[..., Awaitable[None]]:
        """Return the function for the command of a lens."""

        async def called(action: str, file: str, line: int) -> None:
            await self._perform(action, Path(file), line)

        return called

    async def _perform(self, action: str, file: Path, line: int) -> None:
        """Carry out the command of a lens; its results replace the earlier ones."""
        program = await self.do(self.programs.of, file)
        try:
            sources = await self.do(program.sources)
            begun = Note(str(file), line, 0, f"{action} ...", "information", action)
            await self._publish(self.results.put, program, action, [begun])
            work = self.extras.perform
            loop = asyncio.get_running_loop()
            notes = await loop.run_in_executor(
                None, work, action, (str(file), line), program.given, sources, program.settings
            )
        except InputError as error:
            notes = [note_of_error(error, file)]
        await self._publish(self.results.put, program, action, notes)

    def _tell(self, text: str, kind: types.MessageType) -> None:
        self.window_show_message(types.ShowMessageParams(kind, legible(text)))

    # --- checks ---

    def _later(self, pause: int) -> None:
        """Check all programs with open documents after a pause [ms] without a change."""
        self._changes += 1
        if self._timer is not None:
            self._timer.cancel()
        loop = asyncio.get_running_loop()
        self._timer = loop.call_later(pause / 1000, self._begin, self._changes)

    def _begin(self, change: int) -> None:
        task = asyncio.get_running_loop().create_task(self._check(change))
        self._tasks.add(task)
        task.add_done_callback(self._ended)

    def _ended(self, task: asyncio.Task[None]) -> None:
        self._tasks.discard(task)
        if not task.cancelled() and (error := task.exception()) is not None:
            logging.getLogger(__name__).error("the check has failed", exc_info=error)
            self._tell(f"the check has failed: {error!r}", types.MessageType.Error)

    async def _check(self, change: int) -> None:
        programs = await self.do(self._open_programs)
        clean = []
        for program in programs:
            if change != self._changes:
                return
            sources = await self._publish(self._errors, program)
            if sources is not None:
                self._say(sources.notes)
                clean.append((program, sources))
        if not clean:
            return
        await asyncio.sleep(self.programs.settings.pause * _PAUSES / 1000)
        for program, sources in clean:
            if change != self._changes:
                return
            loop = asyncio.get_running_loop()
            notes = await loop.run_in_executor(
                self._background, self.extras.notes, sources, program.settings
            )
            if change == self._changes:
                await self._publish(self.results.put, program, "notes", notes)

    def _open_programs(self) -> list[Program]:
        """Return the programs of the open documents."""
        return list(dict.fromkeys(map(self.programs.of, self.programs.documents.paths)))

    def _errors(self, program: Program) -> SourceFiles | None:
        """Find the mistakes in a program; return its sources, if it has no mistake."""
        try:
            sources, errors = program.check()
        except InputError as error:
            self.results.put(program, "errors", [note_of_error(error, self._first(program))])
            self.results.forget(program, "notes")
            return None
        errors = self.extras.explained(errors, sources, program.settings)
        notes = [note_of_error(error, sources.own[0]) for error in errors]
        notes += map(note_of_unread, unread_bodies(sources.all))
        self.results.put(program, "errors", notes)
        if not errors:
            return sources
        self.results.forget(program, "notes")
        return None

    def _first(self, program: Program) -> Path:
        """Return a document of a program, for mistakes that belong to no file."""
        paths = self.programs.documents.paths
        return next((one for one in paths if self.programs.of(one) is program), program.given[0])

    async def _publish(self, work: Callable[..., _T], *arguments: Any) -> _T:
        """Do work that changes the results, and tell the editor what has changed."""

        def both() -> tuple[_T, list[tuple[Path, list[types.Diagnostic]]]]:
            return work(*arguments), list(self.results.changes())

        done, changes = await self.do(both)
        for file, found in changes:
            self.text_document_publish_diagnostics(
                types.PublishDiagnosticsParams(self.programs.documents.uri(file), found)
            )
        return done

    def _say(self, notes: Iterable[str]) -> None:
        """Write notes on a project into the log of the editor, if they are new."""
        said = tuple(notes)
        if said != self._said:
            self._said = said
            for note in said:
                text = legible(note)
                self.window_log_message(types.LogMessageParams(types.MessageType.Info, text))
