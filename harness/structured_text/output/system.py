"""What Windows, macOS and Linux do differently: here with its counterparts, and nowhere else.

No other module names what one of them lacks; docs/reference/platforms.md says what is missing
where.
"""

from __future__ import annotations

import _thread
import ctypes
import errno
import gc
import mmap
import os
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any, Final, Literal, NoReturn

from structured_text.errors import COMMAND

if sys.platform == "win32":
    from _ctypes import FreeLibrary
else:
    from _ctypes import dlclose

__all__ = [
    "APART",
    "COPIES",
    "DLL",
    "GUARDED",
    "MOST_PROCESSES",
    "WHOLE",
    "DirectInput",
    "PipedCopy",
    "RelayedInput",
    "SharedMemory",
    "StandardInput",
    "addresses",
    "ask_for_priority",
    "be_apart",
    "cache_root",
    "copied",
    "copy_ended",
    "end_apart",
    "end_as_by_ctrl_c",
    "fine_timers",
    "group_address",
    "interrupt_main_thread",
    "interrupts_later",
    "loaded",
    "nobody_reads",
    "processors",
    "settings_root",
    "told_to_end",
    "unload",
    "without_waiting",
]

_PRIORITY = 1
_STANDARD_ERROR = 2
_SHOWN = 15
#: So often is looked whether a copy has ended [s].
_LOOK_S = 0.005
_CHUNK = 65536
_FINEST_MS = 1
#: Where memory that processes share has its names.
_SHARED = "/dev/shm" if os.path.isdir("/dev/shm") else os.environ.get("TMPDIR", "/var/tmp")
#: Real time after which a copy counts as hanging: so much [s], and so often its processor time.
_HANGS_S, _BUSY = 600, 8
_TOO_LONG = ("SIGXCPU", "SIGALRM", "SIGKILL")

APART: dict[str, Any]
"""For a process that Ctrl-C does not reach: its parent decides when it ends."""

DLL: Final = ".dll" if sys.platform == "win32" else ".so"
"""How the name of a shared object ends."""

WHOLE: Final = ("-static-libgcc", "-static-libstdc++") if sys.platform == "win32" else ()
"""For gcc and clang: a shared object that is loaded wherever the compiler's own are not found."""

GUARDED: Final = sys.platform != "win32"
"""Can a process notice the end of its parent, and end what it has started?"""

COPIES: Final = sys.platform != "win32"
"""Can a process make copies of itself?"""
MOST_PROCESSES: Final = 60 if sys.platform == "win32" else sys.maxsize
"""So many processes can be waited for at once."""

_ENDS = [signal.SIGINT, signal.SIGTERM]

if sys.platform == "win32":
    APART = {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP}
    _ENDS.append(signal.SIGBREAK)
else:
    APART = {"start_new_session": True}


def cache_root() -> Path:
    """The folder in which programs keep what they can make anew.

    Raises:
        RuntimeError: the user has no home.
    """
    if named := os.environ.get("XDG_CACHE_HOME"):
        return Path(named)
    if sys.platform == "win32":
        local = os.environ.get("LOCALAPPDATA")
        return Path(local) if local else Path.home() / "AppData" / "Local"
    return Path.home() / ("Library/Caches" if sys.platform == "darwin" else ".cache")


def end_as_by_ctrl_c() -> list[int]:
    """From now on SIGTERM, SIGHUP and Ctrl-Break end this process as Ctrl-C does: in order.

    So what is temporary is removed. One of them that is ignored stays so (nohup).

    Returns:
        The number of the one that has come, later; further ones change nothing.
    """
    came: list[int] = []

    def end(number: int, frame: object) -> None:
        came.append(number)
        for one in numbers:
            signal.signal(one, signal.SIG_IGN)
        raise KeyboardInterrupt

    both: list[signal.Signals] = [signal.SIGTERM]
    if sys.platform == "win32":
        both.append(signal.SIGBREAK)
    else:
        both.append(signal.SIGHUP)
    numbers = [one for one in both if signal.getsignal(one) is signal.SIG_DFL]
    for number in numbers:
        signal.signal(number, end)

    def leave() -> None:
        """End a copy of this process at once: it has begun nothing that it has to remove."""
        for number in numbers:
            if signal.getsignal(number) is end:
                signal.signal(number, signal.SIG_DFL)

    if sys.platform != "win32":
        os.register_at_fork(after_in_child=leave)
    return came


def settings_root() -> Path:
    """The folder in which programs keep what the user has chosen, or what is his alone.

    Raises:
        RuntimeError: the user has no home.
    """
    if named := os.environ.get("XDG_CONFIG_HOME"):
        return Path(named)
    if sys.platform == "win32":
        roaming = os.environ.get("APPDATA")
        return Path(roaming) if roaming else Path.home() / "AppData" / "Roaming"
    mac = Path("Library", "Application Support")
    return Path.home() / (mac if sys.platform == "darwin" else ".config")


@contextmanager
def told_to_end(tell: Callable[[], object]) -> Iterator[None]:
    """Meanwhile Ctrl-C, Ctrl-Break, SIGTERM and SIGHUP call this function, in the main thread."""
    numbers = [*_ENDS]
    if sys.platform != "win32" and signal.getsignal(signal.SIGHUP) is not signal.SIG_IGN:  # nohup
        numbers.append(signal.SIGHUP)
    before = [(number, signal.signal(number, lambda *_: tell())) for number in numbers]
    try:
        yield
    finally:
        for number, handler in before:
            signal.signal(number, handler)


@contextmanager
def interrupts_later() -> Iterator[None]:
    """Meanwhile Ctrl-C waits; a process that is started here does not hear it before `be_apart`."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def be_apart() -> None:
    """From now on Ctrl-C does not reach this process, and `end_apart` ends what it starts, too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        os.setsid()
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        signal.signal(signal.SIGINT, signal.default_int_handler)


def interrupt_main_thread() -> None:
    """Raise KeyboardInterrupt in the main thread, also while it waits.

    A real signal ends the wait for a lock; `_thread.interrupt_main` alone does not.
    """
    main = threading.main_thread().ident
    if sys.platform != "win32" and main is not None:
        signal.pthread_kill(main, signal.SIGINT)
    else:
        _thread.interrupt_main()


def end_apart(pid: int, *, has_ended: bool = False, number: int | None = None) -> None:
    """End a process that may be apart; with what it has started, but for Windows.

    Args:
        pid: Its number.
        has_ended: It is gone: only what it has started is left.
        number: Send this signal instead of the one that ends it by force; to its group alone.
    """
    if sys.platform == "win32":
        if not has_ended:
            with suppress(OSError):
                os.kill(pid, signal.SIGTERM)
        return
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(pid, signal.SIGKILL if number is None else number)
    if not has_ended and number is None:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


def processors() -> int:
    """How many processors this process may use, at least 1."""
    if sys.platform == "linux":
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def fine_timers() -> None:
    """Let this process sleep by the millisecond; Windows wakes it every 15.6 ms otherwise."""
    if sys.platform == "win32":
        ctypes.WinDLL("winmm").timeBeginPeriod(_FINEST_MS)


def ask_for_priority(policy: Literal["first", "in turn"]) -> None:
    """Ask for real time, for the threads to come too; where it is not allowed we do without.

    Linux alone is asked.

    Args:
        policy: Go on until it waits, or in turn with others of its priority.
    """
    if sys.platform == "linux":
        number = os.SCHED_FIFO if policy == "first" else os.SCHED_RR
        with suppress(OSError):
            os.sched_setscheduler(0, number, os.sched_param(_PRIORITY))


def copied(work: Callable[[], object], seconds: float) -> int:
    """Do something in a copy of this process, which prints nothing; its process number.

    Args:
        work: What to do; it ends with exit code 0, or 1 where this raises.
        seconds: Processor time that it may take; and so much real time that a busy machine does.
    """
    if sys.platform == "win32":
        raise NotImplementedError
    import resource

    if pid := os.fork():
        return pid
    code = 1
    try:
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nothing, stream)
        limit = int(seconds) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(_HANGS_S + _BUSY * limit)
        work()
        code = 0
    finally:
        os._exit(code)


def copy_ended(pid: int = -1) -> tuple[int, int | str, float]:
    """Wait until a copy has ended, any one by default.

    Returns:
        Its process number, its exit code or what ended it (`time` where it took too long), and
        its processor time [s].
    """
    if sys.platform == "win32":
        raise NotImplementedError
    found, status, usage = os.wait4(pid, 0)
    how: int | str = os.waitstatus_to_exitcode(status)
    if isinstance(how, int) and how < 0:
        name = signal.Signals(-how).name
        how = "time" if name in _TOO_LONG else name
    return found, how, usage.ru_utime + usage.ru_stime


class PipedCopy:
    """A copy of this process that does something else, held as a `subprocess.Popen` with pipes.

    It starts in half the time of a new Python, and shares with this process the memory that
    neither writes to. Ctrl-C does not reach it, and it has no open file of this process but
    standard error. This process has one thread, and none of its objects is to be collected as
    garbage in the copy: they could close files of the copy's own.

    Args:
        work: What it does; it ends with exit code 0, with that of a SystemExit, or with 1 and a
            traceback where this raises.
        name: What it is, for who looks at the processes of Linux, which shows its last 15 bytes.

    Attributes:
        pid: Its number.
        returncode: Its exit code, negative for a signal; None as long as it was not seen to end.
        stdin: Its standard input, to be written to.
        stdout: Its standard output, to be read.
    """

    pid: int
    returncode: int | None
    stdin: IO[str]
    stdout: IO[str]

    def __init__(self, work: Callable[[], object], name: str) -> None:
        if sys.platform == "win32":
            raise NotImplementedError
        theirs, orders = os.pipe()
        reports, said = os.pipe()
        gc.collect()
        gc.freeze()
        sys.stdout.flush()
        self.returncode = None
        self.pid = os.fork()
        if not self.pid:
            os.dup2(theirs, 0)
            os.dup2(said, 1)
            _be_another(work, name)
        os.close(theirs)
        os.close(said)
        self.stdin = open(orders, "w", encoding="utf-8")  # noqa: SIM115
        self.stdout = open(reports, encoding="utf-8")  # noqa: SIM115

    def poll(self) -> int | None:
        """Its exit code, None as long as it runs."""
        if sys.platform == "win32":
            raise NotImplementedError
        if self.returncode is None:
            found, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if found else None
        return self.returncode

    def wait(self, timeout: float | None = None) -> int:
        """Its exit code, once it has ended.

        Raises:
            subprocess.TimeoutExpired: it has not, within this time [s].
        """
        end = None if timeout is None else time.monotonic() + timeout
        while (code := self.poll()) is None:
            if end is not None and time.monotonic() >= end:
                assert timeout is not None
                raise subprocess.TimeoutExpired("", timeout)
            time.sleep(_LOOK_S)
        return code

    def kill(self) -> None:
        """End it by force."""
        if sys.platform != "win32" and self.poll() is None:
            os.kill(self.pid, signal.SIGKILL)


def _be_another(work: Callable[[], object], name: str) -> NoReturn:
    """What a copy does from its first moment to its last."""
    code = 1
    try:
        if sys.platform != "win32":
            os.setsid()
        for number in map(int, os.listdir("/dev/fd")):
            if number > _STANDARD_ERROR:
                with suppress(OSError):  # that of the list itself
                    os.close(number)
        if sys.platform == "linux":
            Path("/proc/self/comm").write_bytes(name.encode()[-_SHOWN:].lstrip(b"."))
        work()
        sys.stdout.flush()
        code = 0
    except SystemExit as ended:
        if ended.code is None or isinstance(ended.code, int):
            code = ended.code or 0
        else:
            print(ended.code, file=sys.stderr)
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        os._exit(code)


def without_waiting(path: str, flags: int) -> int:
    """Open a file as `open(opener=...)` wants it; a pipe that has come meanwhile does not wait."""
    return os.open(path, flags | getattr(os, "O_NONBLOCK", 0))


def nobody_reads(error: OSError) -> bool:
    """Has the reader of a pipe that was written to gone?"""
    if sys.platform == "win32":
        return error.errno in (errno.EPIPE, errno.EINVAL)
    return error.errno == errno.EPIPE


class DirectInput:
    """Standard input, to be waited for by `select` beside sockets."""

    def fileno(self) -> int:
        """What `select` takes."""
        return 0

    def read(self) -> bytes:
        """What has come; empty at its end."""
        return os.read(0, _CHUNK)


class RelayedInput:
    """The same where `select` takes sockets alone: a thread passes on what comes.

    So something may arrive a moment after what was sent later on another way.
    """

    def __init__(self) -> None:
        self._socket, into = socket.socketpair()
        threading.Thread(target=self._relay, args=(into,), daemon=True).start()

    def fileno(self) -> int:
        """What `select` takes."""
        return self._socket.fileno()

    def read(self) -> bytes:
        """What has come; empty at its end."""
        return self._socket.recv(_CHUNK)

    def _relay(self, into: socket.socket) -> None:
        with into:
            while some := os.read(0, _CHUNK):
                into.sendall(some)


StandardInput = RelayedInput if sys.platform == "win32" else DirectInput
"""The one for this system."""


class SharedMemory:
    """Memory of several processes, which find it by its name.

    That of `multiprocessing` brings a process of its own that watches over it, and imports that
    take 3 MiB in each process.

    Args:
        name: That of memory which another process has made; empty for new memory, all zero.
        size: Bytes of new memory.

    Attributes:
        name: By which other processes find it.
        buf: It.

    Raises:
        FileNotFoundError: there is none of that name; Windows gives new memory then.
    """

    def __init__(self, name: str = "", size: int = 0) -> None:
        if sys.platform == "win32":
            self.name = name or f"{COMMAND}-{os.urandom(8).hex()}-{size}"
            self._map = mmap.mmap(-1, int(self.name.rpartition("-")[2]), tagname=self.name)
            self.buf = memoryview(self._map)
            return
        new = not name
        self.name = name or f"{_SHARED}/{COMMAND}-{os.urandom(8).hex()}"
        file = os.open(self.name, os.O_RDWR | (os.O_CREAT | os.O_EXCL if new else 0), 0o600)
        try:
            if new:
                os.ftruncate(file, size)
            self._map = mmap.mmap(file, size)
        except BaseException:
            if new:
                self.unlink()
            raise
        finally:
            os.close(file)
        self.buf = memoryview(self._map)

    def close(self) -> None:
        """Let go of the memory; more than once does no harm."""
        self.buf.release()
        self._map.close()

    def unlink(self) -> None:
        """Remove the name: nothing is left behind when all who have it open have ended."""
        if sys.platform != "win32":  # there it goes with them by itself
            os.unlink(self.name)


def group_address(group: str) -> str:
    """What a socket binds to that hears a multicast group."""
    return "0.0.0.0" if sys.platform == "win32" else group


def addresses() -> Iterator[tuple[str, str, bytes]]:
    """IPv4 address, netmask and hardware address of each interface; only Linux tells."""
    if sys.platform != "linux":
        return
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        for _, name in socket.if_nameindex():
            with suppress(OSError):  # without an IPv4 address, or gone
                own, mask = (_ask(any_socket, name, one)[4:8] for one in (0x8915, 0x891B))
                hardware = _ask(any_socket, name, 0x8927)[2:8]
                yield socket.inet_ntoa(own), socket.inet_ntoa(mask), hardware


def _ask(any_socket: socket.socket, name: str, question: int) -> bytes:
    """A `struct sockaddr` about an interface by ioctl: family, then port or hardware address."""
    if sys.platform != "linux":
        return b""
    import fcntl

    request = struct.pack("256s", name.encode()[:15])
    return fcntl.ioctl(any_socket.fileno(), question, request)[16:32]


def loaded(file: str) -> None:
    """Remove the file of a library that has just been loaded, unless it must stay meanwhile."""
    if sys.platform != "win32":
        os.unlink(file)


def unload(handle: int, file: str) -> None:
    """Unload a library, and remove its file where that was not possible before."""
    if sys.platform == "win32":
        FreeLibrary(handle)
        with suppress(OSError):
            os.unlink(file)
    else:
        dlclose(handle)
