"""The tests of a user's project: the lines that each test executes, and the state of the files."""

from __future__ import annotations

import hashlib
import os
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from structured_text.mutants.mutant import Mutant
from structured_text.output.paths import real

__all__ = ["Tests"]

#: Kinds of files that tests may depend on, and folders that are not searched for such files.
_KINDS = {".py", ".st", ".toml", ".ini", ".cfg", ".json", ".jsonl", ".csv", ".yaml", ".yml", ".txt"}
_FOREIGN = ("__pycache__", "node_modules", "out", "build", "dist", "site-packages")


@dataclass
class Tests:
    """The tests of a project for its mutants, with hashes of the files that the tests depend on.

    Args:
        folder: The project; paths of mutated files are relative to it.
        root: The folder to which identifiers of tests are relative.
        ran: The lines of the statements that each test has executed, by file.
        seconds: Processor time of each test.
        listed: The lines of all statements of a file.
        left_out: Files that do not count as files of the tests: the mutated files, and the files of
            results.
    """

    folder: Path
    root: Path
    ran: Mapping[str, Mapping[str, Collection[int]]]
    seconds: Mapping[str, float]
    listed: Mapping[str, Collection[int]]
    left_out: Collection[Path]
    __test__ = False
    _states: dict[str, str] = field(default_factory=dict)
    _kills: dict[str, Counter[str]] = field(default_factory=dict)

    def of(self, mutant: Mutant) -> tuple[str, ...]:
        """Return the tests that execute the changed statement.

        For a changed declaration, return the tests that execute any statement of the sources. For a
        statement that is not counted, return the tests that execute any statement of its file.
        """
        file = str(self.folder / mutant.file)
        if not mutant.reach:
            nodes = [node for node, files in self.ran.items() if any(files.values())]
        elif mutant.reach in self.listed.get(file, ()):
            nodes = [
                node for node, files in self.ran.items() if mutant.reach in files.get(file, ())
            ]
        else:
            nodes = [node for node, files in self.ran.items() if files.get(file)]
        return tuple(nodes)

    def ordered(self, mutant: Mutant, nodes: Sequence[str]) -> list[str]:
        """Return the tests in an order in which a failure is expected as soon as possible.

        A test that has killed mutants of the same POU in little time comes first, then the fast
        tests.
        """
        kills = self._kills.get(mutant.pou, Counter())

        def rank(node: str) -> tuple[float, float]:
            seconds = self.seconds.get(node, 1.0) + 0.005
            return -kills[node] / seconds, seconds

        return sorted(nodes, key=rank)

    def killed(self, pou: str, node: str) -> None:
        """Record that a test has found a mutant of a POU."""
        self._kills.setdefault(pou, Counter())[node] += 1

    def state_of(self, file: str) -> str:
        """Return a hash of a test file, and of all files in the project that tests may use."""
        if file not in self._states:
            digest = hashlib.sha256(self._common().encode())
            path = self.root / file
            digest.update(path.read_bytes() if path.is_file() else b"")
            self._states[file] = digest.hexdigest()[:16]
        return self._states[file]

    def state(self, nodes: Iterable[str]) -> str:
        """Return a hash of tests: their identifiers, and the files that they use."""
        names = sorted(nodes)
        digest = hashlib.sha256("\n".join(names).encode())
        for file in sorted({name.partition("::")[0] for name in names}):
            digest.update(self.state_of(file).encode())
        return digest.hexdigest()[:16]

    def _common(self) -> str:
        """Return a hash of the files that all tests may use.

        Test files and mutated files are not among them.
        """
        if "" not in self._states:
            tests = {self.root / node.partition("::")[0] for node in self.ran}
            digest = hashlib.sha256()
            for file in sorted(self._files()):
                if file not in tests and real(file) not in self.left_out:
                    digest.update(file.relative_to(self.folder).as_posix().encode() + b"\0")
                    digest.update(hashlib.sha256(file.read_bytes()).digest())
            self._states[""] = digest.hexdigest()
        return self._states[""]

    def _files(self) -> Iterator[Path]:
        for folder, inner, names in os.walk(self.folder):
            inner[:] = [
                name
                for name in inner
                if not name.startswith(".")
                and name not in _FOREIGN
                and not os.path.exists(os.path.join(folder, name, "pyvenv.cfg"))
            ]
            for name in names:
                if not name.startswith(".") and Path(name).suffix.lower() in _KINDS:
                    yield Path(folder, name)
