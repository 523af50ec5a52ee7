"""The debugger works with the client that tests VS Code's own adapters."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

_PACKAGE = "@vscode/debugadapter-testsupport"
_LONGEST = 120


def _missing() -> str:
    if shutil.which("node") is None:
        return "node is not installed"
    asked = ["node", "-e", f"require.resolve('{_PACKAGE}')"]
    here = Path(__file__).parent
    found = subprocess.run(asked, cwd=here, capture_output=True, timeout=_LONGEST, check=False)
    hint = f"npm install {_PACKAGE} in a folder, and NODE_PATH=that/node_modules"
    return "" if found.returncode == 0 else f"{_PACKAGE} is not installed: {hint}"


def test_the_client_of_vs_code_debugs_forwards_and_backwards(lamps: Path) -> None:
    """The debug client of VS Code's own adapters can debug forwards and backwards.

    Line 54 has no statement, so the stop is in line 55. There 2 * 3 = 6, and Lamp was DARK. The run
    has 100 scans of 10 ms.
    """
    if reason := _missing():
        pytest.skip(reason)
    command = [sys.executable, "-m", "rcx_harness", "debug", "--port", "0"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stderr is not None
        said = process.stderr.readline() + process.stderr.readline()
        found = re.search(r'127\.0\.0\.1:(\d+).*"token": "([^"]+)"', said, re.DOTALL)
        assert found is not None, said
        script = Path(__file__).with_name("client.cjs")
        client = ["node", str(script), found[1], found[2], str(lamps)]
        ended = subprocess.run(client, capture_output=True, text=True, timeout=_LONGEST)
    finally:
        process.terminate()
        process.wait(_LONGEST)
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout) == {"stack": ["Main (Lamps)"], "lamp": "DARK", "next": 57,
                                        "back": 55, "in": 57,
                                        "scopes": ["Variables", "Areas", "Telegrams", "Run"],
                                        "set": "12", "start": 55, "first": "3",
                                        "end": "100"}  # fmt: skip
