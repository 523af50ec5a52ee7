"""The process of a call: it puts up limits and fence, runs the tool, and prints the answer."""

from __future__ import annotations

import json
import os
import sys
import sysconfig
import traceback
from pathlib import Path
from threading import Lock
from typing import Any, TextIO

from rcx_harness.assistant.call import OUT, Call, Command, Progress, plain
from rcx_harness.assistant.fence import VARIABLE, Fence
from rcx_harness.assistant.fence import __file__ as fence_file
from rcx_harness.assistant.folders import Folders
from rcx_harness.assistant.limits import MOST_FILE_BYTES
from rcx_harness.assistant.tools import TOOLS
from rcx_harness.cell.sources import default_lib
from rcx_harness.spec import folder
from structured_text.errors import InputError, legible, refused
from structured_text.language.cache import folder as cache_folder
from structured_text.output.system import limit_process

__all__ = ["answered", "serve_call"]

#: The module that puts up the fence in each Python of the user's tests.
_SITE = """import importlib.util
import sys

spec = importlib.util.spec_from_file_location("rcx_fence", {file!r})
sys.modules["rcx_fence"] = importlib.util.module_from_spec(spec)
spec.loader.exec_module(sys.modules["rcx_fence"])
"""

#: Processor time beyond the real time of a call, after which the process ends by itself [s].
_SPARE_S = 30
#: Files of the system that Python's own modules read.
_SYSTEM = ("/dev/null", "/dev/urandom", "/proc/cpuinfo", "/proc/meminfo", "/sys/fs/cgroup")
#: The folders with modules of Python.
_MODULES = ("stdlib", "platstdlib", "purelib", "platlib")


def answered(call: Call) -> dict[str, Any]:
    """Return the answer to a call as data: `data`, `text` and `whole`, or `error`."""
    try:
        answer = TOOLS[call.tool].run(call)
    except InputError as error:
        return {"error": legible(str(error))}
    except RecursionError:
        return {"error": "expressions, statements or types are nested too deeply; divide them"}
    except MemoryError:
        return {"error": "the call needs more memory than its limit allows; give it less work"}
    except OSError as error:
        return {"error": legible(str(refused(error)))}
    except Exception as error:  # the assistant must get an answer, and the server lives on
        return {"error": legible(_own_error(error))}
    data, text = _relative(plain(answer.data), call), _relative(answer.text, call)
    return {"data": data, "text": text, "whole": answer.whole}


def _own_error(error: Exception) -> str:
    """Return the message for an error that is a fault of the package itself."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    what = "".join(traceback.format_exception_only(error)).strip()
    place = f"{Path(last.filename).name}:{last.lineno}"
    return f"this is an error of rcx itself: {what} ({place}); please report it"


def serve_call(command: Command) -> int:
    """Read a call from standard input, and print its answer as the last line of JSON.

    Lines before the answer report progress. `command` runs a command of `rcx`.
    """
    request = json.loads(sys.stdin.readline())
    # Nothing else in this process may write to the stream of the answer.
    out = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    roots = tuple(Path(root) for root in request["folders"])
    here, temporary = Path(request["here"]), Path(request["temporary"])
    os.chdir(here)
    call = Call(
        request["tool"],
        request["given"],
        Folders(roots),
        here,
        temporary,
        command,
        _reporting(out),
    )
    fence = _fence(call)
    limits = request["limits"]
    limit_process(
        memory=int(limits["megabytes"]) << 20,
        file=MOST_FILE_BYTES,
        seconds=int(limits["seconds"]) + _SPARE_S,
    )
    if fence.python:
        _fence_tests(fence, call)
    fence.stand()
    print(json.dumps(answered(call), ensure_ascii=True), file=out, flush=True)
    return 0


def _reporting(out: TextIO) -> Progress:
    lock = Lock()  # a timer of a command reports from another thread

    def report(text: str, done: float | None, total: float | None) -> None:
        with lock:
            print(json.dumps({"progress": [legible(text), done, total]}), file=out, flush=True)

    return report


def _fence(call: Call) -> Fence:
    """Return the fence of a call: the user's folders, Python itself, and the library.

    `out` is not resolved. If it is a link, its target stays outside.
    """
    python = [*sys.path, *map(sysconfig.get_paths().get, _MODULES), f"{sys.prefix}/pyvenv.cfg"]
    package = [default_lib().parent, folder(), Path(__file__).parents[2]]
    readable = [*call.folders.roots, *python, *package, *_SYSTEM]
    tests = call.tool == "mutants"
    cache = cache_folder()
    writable = ["/dev/null", call.temporary, call.here / OUT.parts[0], *([cache] if cache else [])]
    return Fence.around(readable, writable, python=tests, local=tests)


def _fence_tests(fence: Fence, call: Call) -> None:
    """Put the fence around the user's tests, from the start of their Python on.

    Python imports `sitecustomize` before the folder of the tests is in its path. The tests are the
    user's code, so they may write in the user's folders.
    """
    writable = (*fence.writable, *map(str, call.folders.roots))
    os.environ[VARIABLE] = Fence(fence.readable, writable, local=True).saved()
    folder = call.temporary / "site"
    folder.mkdir()
    text = _SITE.format(file=fence_file)
    (folder / "sitecustomize.py").write_text(text, encoding="utf-8")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(folder), os.environ.get("PYTHONPATH", "")])


def _relative(value: Any, call: Call) -> Any:
    """Return data or text without the paths of this computer in front of names of files."""
    if isinstance(value, dict):
        return {_relative(key, call): _relative(item, call) for key, item in value.items()}
    if isinstance(value, list):
        return [_relative(item, call) for item in value]
    if not isinstance(value, str):
        return value
    for root in (call.here, call.temporary):
        value = value.replace(f"{root}{os.sep}", "")
    return value.replace(f"{default_lib()}{os.sep}", "plc/lib/")
