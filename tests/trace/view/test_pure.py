"""The scripts of the page that need no browser work in node.js."""

from __future__ import annotations

import re
import shutil
import subprocess
from importlib.resources import files
from pathlib import Path

import pytest

from rcx_harness.trace.view.page import SCRIPTS, View

_NODE = shutil.which("node")


@pytest.mark.skipif(_NODE is None, reason="node is not installed")
def test_the_scripts_that_need_no_browser_work(tmp_path: Path) -> None:
    """Scripts that need no browser pass their own tests in node.js.

    The scripts are modules of a folder. The page contains them one after the other.
    """
    folder = files("rcx_harness.trace.view").joinpath("page")
    (tmp_path / "package.json").write_text('{"type": "module"}', encoding="utf-8")
    for name in SCRIPTS:
        (tmp_path / name).write_bytes(folder.joinpath(name).read_bytes())
    shutil.copy(Path(__file__).with_name("pure.mjs"), tmp_path)
    assert _NODE is not None
    command = [_NODE, "--test", "--test-reporter=tap", "pure.mjs"]
    done = subprocess.run(
        command, cwd=tmp_path, capture_output=True, text=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    written = Path(__file__).with_name("pure.mjs").read_text(encoding="utf-8")
    assert f"# pass {len(re.findall('^test', written, re.MULTILINE))}\n" in done.stdout


@pytest.mark.skipif(_NODE is None, reason="node is not installed")
def test_the_scripts_form_one_module(tmp_path: Path) -> None:
    """The page contains all scripts in one module, so two of them must not declare one name."""
    page = View({}).page("a run")
    script = page.partition('<script type="module">')[2].partition("</script>")[0]
    (tmp_path / "page.mjs").write_text(script, encoding="utf-8")
    assert _NODE is not None
    command = [_NODE, "--check", str(tmp_path / "page.mjs")]
    done = subprocess.run(command, capture_output=True, text=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr


def test_a_script_uses_only_earlier_scripts() -> None:
    """A script uses only scripts that come before it in the page."""
    folder = files("rcx_harness.trace.view").joinpath("page")
    before: list[str] = []
    for name in SCRIPTS:
        text = folder.joinpath(name).read_text(encoding="utf-8")
        taken = re.findall(r'^import .* from "\./(.*)";$', text, re.MULTILINE)
        assert set(taken) <= set(before), name
        assert len(re.findall(r"^import ", text, re.MULTILINE)) == len(taken), name
        before.append(name)
