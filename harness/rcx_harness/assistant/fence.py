"""The fence around the process of a call: no network, no other programs, no files elsewhere.

Python reports each opened file, socket and program to an audit hook, and the hook refuses what is
outside of the fence. The hook cannot be removed. It stops mistakes and ordinary code. It is not a
jail for hostile machine code, which the tools never run by themselves.
"""

from __future__ import annotations

import errno
import json
import os
import sys
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

__all__ = ["VARIABLE", "Fence"]

#: The environment variable with the fence for the processes of the user's tests.
VARIABLE = "RCX_FENCE"

_OUTSIDE = "it is outside of the folders of rcx mcp"
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
_LISTED = {"os.listdir", "os.scandir", "os.chdir"}
#: Events that change a file, with the positions of the paths in their arguments.
_CHANGED = {
    "os.chmod": (0,),
    "os.chown": (0,),
    "os.link": (0, 1),
    "os.mkdir": (0,),
    "os.remove": (0,),
    "os.rename": (0, 1),
    "os.rmdir": (0,),
    "os.symlink": (1,),
    "os.truncate": (0,),
    "os.utime": (0,),
}
_PROGRAMS = {"os.exec", "os.posix_spawn", "os.spawn", "os.startfile", "os.system", "pty.spawn"}
_RESOLVED = {"socket.getaddrinfo", "socket.gethostbyaddr", "socket.gethostbyname"}
_SENT = {"socket.bind", "socket.connect", "socket.sendmsg", "socket.sendto"}
_THIS_COMPUTER = ("127.0.0.1", "localhost")


@dataclass(frozen=True)
class Fence:
    """List what the process of a call may use.

    Attributes:
        readable: Folders and files that it may read.
        writable: Folders and files that it may read and write.
        python: Whether it may start this Python; the runs of the user's tests need it.
        local: Whether it may connect to this computer; the copies of a test process need it.
    """

    readable: tuple[str, ...]
    writable: tuple[str, ...]
    python: bool = False
    local: bool = False

    @classmethod
    def around(cls, readable: Iterable[object], writable: Iterable[object], **more: bool) -> Fence:
        """Return the fence for paths. The readable paths may contain links."""
        return cls(_resolved(readable), tuple(map(str, writable)), **more)

    @classmethod
    def loaded(cls, text: str) -> Fence:
        """Return the fence from the text of `saved`."""
        table = json.loads(text)
        return cls(**{**table, **{key: tuple(table[key]) for key in ("readable", "writable")}})

    def saved(self) -> str:
        """Return the fence as text, for another process."""
        return json.dumps(asdict(self))

    def stand(self) -> None:
        """Put up the fence around this process, until its end."""
        sys.addaudithook(self.check)

    def check(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Raise PermissionError if an event of Python's audit is outside of the fence."""
        if event == "open":
            path, mode, flags = arguments
            writes = bool(set(mode or "") & set("wax+")) or bool((flags or 0) & _WRITING)
            self._path(path, writes=writes)
        elif event in _LISTED:
            self._path(arguments[0], writes=False)
        elif event in _CHANGED:
            for number in _CHANGED[event]:
                self._path(arguments[number], writes=True)
        elif event == "subprocess.Popen":
            if not (self.python and os.fspath(arguments[0]) == sys.executable):
                raise _refused("a program cannot be started inside of rcx mcp")
        elif event in _PROGRAMS:
            raise _refused("a program cannot be started inside of rcx mcp")
        elif event in _RESOLVED:
            self._host(arguments[0])
        elif event in _SENT:
            address = arguments[1] if len(arguments) > 1 else None
            self._host(address[0] if isinstance(address, tuple) and address else address)

    def _path(self, path: object, *, writes: bool) -> None:
        if path is None or isinstance(path, int):  # the current folder, or an open file
            return
        place = os.path.realpath(os.fsdecode(path))  # type: ignore[arg-type]
        if _within(place, self.writable) or (not writes and _within(place, self.readable)):
            return
        raise PermissionError(errno.EACCES, _OUTSIDE, os.fsdecode(path))  # type: ignore[arg-type]

    def _host(self, host: object) -> None:
        if host is None or (self.local and host in _THIS_COMPUTER):
            return
        raise _refused("the network cannot be used inside of rcx mcp")


def _refused(text: str) -> PermissionError:
    return PermissionError(errno.EACCES, text)


def _within(place: str, roots: Iterable[str]) -> bool:
    return any(place == root or place.startswith(root.rstrip(os.sep) + os.sep) for root in roots)


def _resolved(paths: Iterable[object]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(os.path.realpath(str(path)) for path in paths if path))


def _stand_in_tests(environment: Callable[[str], str | None]) -> None:
    """Put up the fence of the environment, when the Python of the user's tests starts."""
    if text := environment(VARIABLE):
        Fence.loaded(text).stand()


_stand_in_tests(os.environ.get)
