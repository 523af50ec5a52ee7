"""The toolkit runs in a process that cannot import the packages above it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

_SUPPORT = Path(__file__).parents[1] / "support"
_EVERY_MODULE = """
import sys
from importlib import import_module
from pkgutil import walk_packages
sys.path.insert(0, sys.argv[1])
from toolkit_alone import toolkit_alone
toolkit_alone()
import structured_text
names = [one.name for one in walk_packages(structured_text.__path__, "structured_text.")]
for name in names:
    import_module(name)
try:
    import rcx_harness
except ModuleNotFoundError:
    print(len(names))
"""


@pytest.mark.exhaustive
def test_every_module_is_imported_where_the_harness_cannot_be() -> None:
    """Every module of the toolkit can be imported without rcx_harness.

    Source: docs/explanation/architecture.md, the packages.
    """
    command = [sys.executable, "-c", _EVERY_MODULE, str(_SUPPORT)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert int(done.stdout) > 100


def test_no_test_of_the_toolkit_imports_what_stands_above_it() -> None:
    """Tests of the toolkit do not import rcx_harness.

    `make test-toolkit` runs these tests alone.

    Source: CONTRIBUTING.md, tests.
    """
    found = [
        file.name
        for file in Path(__file__).parent.rglob("*.py")
        for line in file.read_text(encoding="utf-8").splitlines()
        if line.strip().startswith(("from rcx_", "import rcx_")) and file != Path(__file__)
    ]
    assert found == []
