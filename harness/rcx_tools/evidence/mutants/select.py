"""Selection and order of the tests that judge the mutants of a file."""

from __future__ import annotations

import ast
import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, zip_longest
from pathlib import Path

from rcx_tools.evidence.mutants.suite import spread

__all__ = [
    "Judges",
    "TestStates",
    "alike",
    "cheapest",
    "folder_of",
    "named_tests",
    "naming_tests",
    "nearest",
]

#: Greatest number of tests from a file that the head of the POU does not name. Fault runs are long,
#: so only one of them is taken.
_OF_OTHERS, _OF_FAULTS = 8, 1
#: Number of additional tests with words of the changed line in their names.
_ALIKE = 8


class TestStates:
    """Hashes of test files, to decide whether saved outcomes are still valid.

    Args:
        root: The repository.
    """

    __test__ = False

    def __init__(self, root: Path) -> None:
        self._root = root
        self._hashes: dict[str, str] = {}

    def of(self, file: str) -> str:
        """Return a hash of a test file, of its support modules, and of its tables."""
        if file not in self._hashes:
            digest = hashlib.sha256()
            tables = (self._root / file).parent.rglob("*.toml")
            for one in sorted([*self._with_support(self._root / file), *tables]):
                digest.update(one.read_bytes())
            self._hashes[file] = digest.hexdigest()[:16]
        return self._hashes[file]

    def _with_support(self, file: Path) -> set[Path]:
        support = {one.stem: one for one in (self._root / "tests" / "support").glob("*.py")}
        found, waiting = {file}, [file]
        while waiting:
            text = waiting.pop().read_text(encoding="utf-8")
            for name in re.findall(r"^\s*(?:from|import) (\w+)", text, re.MULTILINE):
                if name in support and support[name] not in found:
                    found.add(support[name])
                    waiting.append(support[name])
        return found


@dataclass
class Judges:
    """The selection of tests for the mutants of a POU. All these tests have run the POU.

    In test files that the head of the source names, and in test files that name the POU, all tests
    are selected. In every other test file, some evenly spread tests are selected.

    Args:
        states: Hashes of the test files.
        ran: Upper-case names of the POUs that each test has run, in the order of the tests.
        seconds: Processor time of each test.
        named_only: Whether to take only tests that the head of the file names.
        exhaustive: Tests that `make test` leaves out. These tests come last.
    """

    states: TestStates
    ran: Mapping[str, frozenset[str]]
    seconds: Mapping[str, float]
    named_only: bool = False
    exhaustive: frozenset[str] = frozenset()
    _kills: dict[str, Counter[str]] = field(default_factory=dict)
    _chosen: dict[str, tuple[str, ...]] = field(default_factory=dict)

    def of(self, pou: str, named: Sequence[str]) -> tuple[str, ...]:
        """Return the tests for a POU. `named` are the files that the head of its source names."""
        key = pou.upper()
        if key not in self._chosen:
            self._chosen[key] = tuple(self._select(key, named))
        return self._chosen[key]

    def _select(self, key: str, named: Sequence[str]) -> list[str]:
        by_file: dict[str, list[str]] = {}
        for node, pous in self.ran.items():
            if key in pous:
                by_file.setdefault(node.partition("::")[0], []).append(node)
        chosen: list[str] = []
        for file, nodes in by_file.items():
            most = _OF_FAULTS if "/faults/" in file else _OF_OTHERS
            if file in named:
                chosen += nodes
            elif not self.named_only:
                chosen += _own_first(nodes, key, most)
        return chosen

    def ordered(self, pou: str, nodes: Iterable[str], named: Sequence[str]) -> list[str]:
        """Return the tests in an order in which they probably find a mutant early."""
        key = pou.upper()
        kills = self._kills.get(key, Counter())

        def rank(node: str) -> tuple[bool, float, bool, bool, float]:
            seconds = self.seconds.get(node, 1.0) + 0.005
            other_file = node.partition("::")[0] not in named
            last = node in self.exhaustive
            return last, -kills[node] / seconds, not _is_own(node, key), other_file, seconds

        return sorted(nodes, key=rank)

    def killed(self, pou: str, node: str) -> None:
        """Record that a test has killed a mutant of a POU."""
        self._kills.setdefault(pou.upper(), Counter())[node] += 1

    def state_of(self, file: str) -> str:
        """Return a hash of a test file and of the files that it uses."""
        return self.states.of(file)

    def state(self, nodes: Iterable[str]) -> str:
        """Return a hash of tests: of their identifiers and of the texts of their files."""
        names = sorted(nodes)
        digest = hashlib.sha256("\n".join(names).encode())
        for file in sorted({name.partition("::")[0] for name in names}):
            digest.update(self.states.of(file).encode())
        return digest.hexdigest()[:16]


def _own_first(nodes: Sequence[str], key: str, most: int) -> list[str]:
    """Return at most `most` tests. Tests with the POU among their parameters come first."""
    own = [node for node in nodes if _is_own(node, key)][:most]
    others = [node for node in nodes if node not in own]
    return [*own, *spread(others, most - len(own))]


def _is_own(node: str, key: str) -> bool:
    """Return whether the POU is among the parameters of a test."""
    marks = (f"[{key}-", f"-{key}]", f"[{key}]")
    return any(mark in node.upper() for mark in marks)


def alike(changed: str, nodes: Iterable[str]) -> list[str]:
    """Return the tests whose names contain the most words of a changed line and its function."""
    words = _words(changed)
    shared = Counter({node: len(words & _words(node.partition("::")[2])) for node in nodes})
    return [node for node, count in shared.most_common(_ALIKE) if count]


def nearest(
    nodes: Iterable[str],
    ran: Mapping[str, frozenset[str]],
    seconds: Mapping[str, float],
    most_s: float,
) -> list[str]:
    """Return the tests that run the fewest other functions, within a limit of the total time."""
    return _in_time(
        sorted(nodes, key=lambda node: (len(ran[node]), seconds[node])), seconds, most_s
    )


def cheapest(nodes: Iterable[str], seconds: Mapping[str, float], most_s: float) -> list[str]:
    """Return quick tests within a limit of the total time.

    The quickest case of each test function comes first, then the second quickest case of each
    function, and so on.
    """
    functions: dict[str, list[str]] = {}
    for node in sorted(nodes, key=seconds.__getitem__):
        functions.setdefault(node.partition("[")[0], []).append(node)
    in_turn = [node for row in zip_longest(*functions.values()) for node in row if node]
    return _in_time(in_turn, seconds, most_s)


def _in_time(nodes: Sequence[str], seconds: Mapping[str, float], most_s: float) -> list[str]:
    took = accumulate(seconds[node] for node in nodes)
    return [node for node, so_far in zip(nodes, took, strict=True) if so_far <= most_s]


def _words(text: str) -> set[str]:
    return set(re.findall(r"[a-z]{4,}", text.lower()))


def named_tests(file: Path) -> tuple[str, ...]:
    """Return the test files that the head of a file of the library names."""
    head = file.read_text(encoding="utf-8").partition("*)")[0]
    return tuple(re.findall(r"tests/[\w/]+\.py", head))


def naming_tests(root: Path) -> dict[str, tuple[str, ...]]:
    """Return for each POU the test files whose docstring names the POU."""
    found: dict[str, tuple[str, ...]] = {}
    for file in sorted((root / "tests").rglob("test_*.py")):
        told = ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or ""
        for name in sorted(set(re.findall(r"\bF[BC]_\w+", told))):
            found[name] = (*found.get(name, ()), file.relative_to(root).as_posix())
    return found


def folder_of(file: str) -> str:
    """Return the folder of a file in the report.

    For plc/lib/area/FB_ReadArea.st it is `area`, for harness/rcx_harness/robot/machine.py `robot`.
    """
    parts = file.split("/")
    return parts[min(2, len(parts) - 1)]
