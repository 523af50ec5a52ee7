"""Make this Python process and its children look like Windows to the packages of the wheel.

Python imports this module at its start if its folder is on PYTHONPATH (`windows.py` beside the
folder puts it there). The modules of the packages then see the following differences:

`sys.platform` is win32. Names and modules that Windows lacks are missing, and names that only
Windows has are stand-ins. `select` takes sockets only. A socket cannot be bound to a group address,
and an event loop cannot wait for a signal. A file that is open or loaded cannot be removed or
replaced. A text file without an encoding is an error. Processes start by spawn. The standard
library itself does not change.
"""

from __future__ import annotations

import asyncio
import builtins
import ipaddress
import json
import mmap
import multiprocessing
import os
import select
import signal
import socket
import sys
import warnings
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any


class _Seen(ModuleType):
    """A standard module that lacks the names that Windows lacks. Some names are stand-ins."""

    def __init__(self, real: ModuleType, hidden: Sequence[str], instead: Mapping[str, Any]) -> None:
        super().__init__(real.__name__)
        self.__dict__.update(instead)
        self.__dict__["_real"], self.__dict__["_hidden"] = real, frozenset(hidden)

    def __getattr__(self, name: str) -> Any:
        if name in self._hidden:
            raise AttributeError(f"Windows has no {self.__name__}.{name}")
        return getattr(self._real, name)

    def __setattr__(self, name: str, value: Any) -> None:
        setattr(self._real, name, value)


class _Socket(socket.socket):
    def bind(self, address: Any) -> None:
        host = ipaddress.ip_address(address[0] or "0.0.0.0")
        if host.is_multicast or host.packed[-1] == 0xFF:
            raise OSError("Windows binds a socket only to an address of its own")
        super().bind(address)


def _select(*some: Any) -> Any:
    if not any(some[:3]):
        raise OSError("on Windows, select needs at least one socket")
    for one in [one for each in some[:3] for one in each]:
        number = one if isinstance(one, int) else one.fileno()
        if not os.readlink(f"/proc/self/fd/{number}").startswith("socket:"):
            raise OSError("on Windows, select accepts only sockets")
    return select.select(*some)


def _dll(name: str) -> Any:
    known = {"winmm": SimpleNamespace(timeBeginPeriod=lambda milliseconds: 0)}
    return known[name]


class _Tagged(mmap.mmap):
    """Shared memory with a name, which disappears when its creator closes it."""

    made = ""

    def __new__(cls, _: int, length: int, tagname: str) -> _Tagged:
        shm = import_module("_posixshmem")
        new = True
        try:
            file = shm.shm_open(f"/{tagname}", os.O_RDWR | os.O_CREAT | os.O_EXCL, mode=0o600)
            os.ftruncate(file, length)
        except FileExistsError:
            new = False
            file = shm.shm_open(f"/{tagname}", os.O_RDWR, mode=0o600)
        made = super().__new__(cls, file, length)
        os.close(file)
        made.made = f"/{tagname}" if new else ""
        return made

    def close(self) -> None:
        super().close()
        if self.made:
            import_module("_posixshmem").shm_unlink(self.made)
            self.made = ""


#: Packages for which Python looks like Windows.
_PACKAGES = ("rcx_harness", "structured_text")

_STAND_INS: dict[str, dict[str, Any]] = {
    "sys": {"platform": "win32"},
    "ctypes": {"WinDLL": _dll},
    "_ctypes": {"FreeLibrary": getattr(import_module("_ctypes"), "dlclose", None)},
    "signal": {"SIGBREAK": signal.SIGUSR1},
    "subprocess": {"CREATE_NEW_PROCESS_GROUP": 0},
    "mmap": {"mmap": _Tagged},
    "select": {"select": _select},
    "socket": {"socket": _Socket},
}


def _install(lacks: Mapping[str, Sequence[str]], absent: Sequence[str]) -> None:
    seen: dict[str, _Seen] = {}
    real = builtins.__import__

    def found(
        name: str,
        globals: Mapping[str, Any] | None = None,
        locals: Mapping[str, Any] | None = None,
        fromlist: Sequence[str] | None = (),
        level: int = 0,
    ) -> ModuleType:
        package = str((globals or {}).get("__package__")).partition(".")[0]
        if package in _PACKAGES and name in absent:
            raise ModuleNotFoundError(f"Windows has no module {name}", name=name)
        module = real(name, globals, locals, fromlist, level)
        if package not in _PACKAGES or module.__name__ not in lacks:
            return module
        own = module.__name__
        if own not in seen:
            seen[own] = _Seen(module, lacks[own], _STAND_INS.get(own, {}))
        return seen[own]

    builtins.__import__ = found


def _guard_files(event: str, arguments: tuple[Any, ...]) -> None:
    if event == "os.remove":
        _check_closed(arguments[0])
    elif event == "os.rename":  # os.replace raises this event, too
        _check_closed(arguments[0])
        _check_closed(arguments[1])


def _check_closed(path: Any) -> None:
    if not isinstance(path, (str, bytes, os.PathLike)):
        return
    place = os.path.realpath(os.fsdecode(path))
    for one in os.listdir("/proc/self/fd"):
        try:
            used = os.readlink(f"/proc/self/fd/{one}")
        except OSError:
            continue
        if used == place:
            raise PermissionError(13, "Windows does not remove an open file", place)
    if place in Path("/proc/self/maps").read_text(encoding="utf-8"):
        raise PermissionError(13, "Windows does not remove a loaded file", place)


def _no_signals(*_: Any) -> None:
    raise NotImplementedError


if "RCX_AS_WINDOWS" in os.environ:
    _told = json.loads(Path(os.environ["RCX_AS_WINDOWS"]).read_text(encoding="utf-8"))
    _loop: Any = asyncio.SelectorEventLoop
    _loop.add_signal_handler = _no_signals
    multiprocessing.set_start_method("spawn")
    warnings.filterwarnings("error", category=EncodingWarning, module=rf"({'|'.join(_PACKAGES)})\b")
    sys.addaudithook(_guard_files)
    _install(_told["lacks"], _told["absent"])
