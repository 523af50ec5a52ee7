"""Ctrl-C during the start of `--link enip` or `rcx serve` prints one line and leaves no process."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from serve_process import own_addresses

pytestmark = pytest.mark.skipif(
    not sys.platform.startswith("linux"),
    reason="it needs process groups, and loopback addresses besides 127.0.0.1",
)

#: Code that each Python process of the command runs first. If the process runs the module WHO, it
#: sends Ctrl-C to the command's process group when it imports the module WHERE. If WHERE is `-`, it
#: does so when it imports WHO. If WHERE is `.`, it does so before the first line of WHO. A child of
#: the command continues after its pipe is closed.
_HOOK = """
import os, select, signal, sys
who, where = os.environ["WHO"], os.environ["WHERE"]
group = int(os.environ.setdefault("GROUP", str(os.getpid())))
def press():
    sys.meta_path[:] = [one for one in sys.meta_path if type(one).__name__ != "Finder"]
    os.killpg(group, signal.SIGINT)
    if os.getppid() == group:
        select.select([0], [], [])
class Finder:
    begun = False
    def find_spec(self, name, path=None, target=None):
        if name == who and not self.begun:
            self.begun = True
            if where == "-":
                press()
            elif where == ".":
                sys.setprofile(said)
        elif name == where and self.begun:
            press()
def said(frame, event, _):
    if event == "call" and frame.f_code.co_name in ("_tell", "tell"):
        sys.setprofile(None)
        press()
sys.meta_path.insert(0, Finder())
"""
_STATION = ("rcx_harness.serve.station_process", ("-", "rcx_harness.serve.station", "."))
_ADAPTER = ("rcx_harness.enip.target.adapter_process", ("-", "rcx_harness.enip.target.device", "."))
# a forked process has already imported all modules
_CYCLIC = ("rcx_harness.enip.cyclic.process", ("-", "."))


def _interrupted(tmp_path: Path, who: str, where: str, *arguments: str) -> tuple[int, str]:
    """Run the command, and return its exit code and the standard error of all its processes.

    The line "compiling ...", which appears on a slow computer, is removed.
    """
    (tmp_path / "sitecustomize.py").write_text(_HOOK)
    done = subprocess.run(
        [sys.executable, "-m", "rcx_harness", *arguments],
        stdin=subprocess.DEVNULL,
        capture_output=True,  # wait until all these processes have ended
        text=True,
        check=False,
        timeout=60,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path), "WHO": who, "WHERE": where},
    )
    return done.returncode, done.stderr.removeprefix("compiling ...\n")


_CASES = [(who, where) for who, places in (_STATION, _ADAPTER, _CYCLIC) for where in places]


@pytest.mark.exhaustive(but=["rcx_harness.enip.target.adapter_process-.-True"])
@pytest.mark.parametrize(
    ("who", "where", "realtime"),
    [(*case, True) for case in _CASES[3:]] + [(*case, False) for case in _CASES[3:6]],
)
def test_ctrl_c_while_a_network_starts_prints_one_line(
    repository: Path, tmp_path: Path, who: str, where: str, realtime: bool
) -> None:
    program = str(repository / "tests" / "cell" / "programs" / "RawArea.st")
    (tmp_path / "lib").mkdir()
    given = ["run", program, "--lib", str(tmp_path / "lib"), "--engine", "builtin"]
    given += ["--link", "enip", "--for", "50ms", *["--realtime"] * realtime]
    assert _interrupted(tmp_path, who, where, *given) == (130, "rcx: interrupted\n")


@pytest.mark.exhaustive(but=["rcx_harness.enip.cyclic.process--"])
@pytest.mark.parametrize(("who", "where"), _CASES)
def test_ctrl_c_while_a_server_starts_ends_it_with_0(tmp_path: Path, who: str, where: str) -> None:
    (address,) = own_addresses(1)
    assert _interrupted(tmp_path, who, where, "serve", "--address", address) == (0, "")
