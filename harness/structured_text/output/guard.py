"""The guard of a child process: it runs one program, and ends it when the parent ends.

`structured_text.output.programs` starts this script, except on Windows. It imports almost nothing.
It leads its own session. Its argument is the number of its end of a socket. When the parent has
ended, no process holds the other end any more. Then the guard ends all processes of the session.
"""

from __future__ import annotations

import os
import select
import signal
import sys
from contextlib import suppress
from typing import NoReturn

assert sys.platform != "win32"

#: Time for the program to write its data after SIGTERM, before it is killed [s].
_GRACE_S = 2.0
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGPIPE)


def _main(parent: int, command: list[str]) -> NoReturn:
    try:
        _run(parent, command)
    finally:  # also after an error in the guard
        os.killpg(0, signal.SIGKILL)
        os._exit(1)  # not reached


def _run(parent: int, command: list[str]) -> None:
    """Run the program until the parent ends, then terminate it."""
    os.set_inheritable(parent, False)
    for number in _SIGNALS:  # the program handles these signals, not its guard
        signal.signal(number, signal.SIG_IGN)
    ended, waking = os.pipe()
    os.set_blocking(waking, False)
    signal.set_wakeup_fd(waking, warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    try:
        pid = os.posix_spawnp(
            command[0], command, os.environ, setsigmask=[], setsigdef=list(_SIGNALS)
        )
    except OSError as error:
        _say(parent, str(error.errno))
        os._exit(1)
    _say(parent, "0")
    while True:
        ready = select.select([parent, ended], [], [])[0]
        _leave_with(pid)
        if parent in ready and not _says_anything(parent):
            break
        if ended in ready:
            os.read(ended, 512)
    os.killpg(0, signal.SIGTERM)
    select.select([ended], [], [], _GRACE_S)


def _say(parent: int, word: str) -> None:
    with suppress(OSError):  # the parent may have ended
        os.write(parent, word.encode())


def _says_anything(parent: int) -> bool:
    try:
        return bool(os.read(parent, 1))
    except OSError:
        return False


def _leave_with(pid: int) -> None:
    """Exit with the code or signal of the program, if it has ended."""
    found, status = os.waitpid(pid, os.WNOHANG)
    if not found:
        return
    code = os.waitstatus_to_exitcode(status)
    if code >= 0:
        os._exit(code)
    import resource

    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # the guard itself must not write a core file
    if -code != signal.SIGKILL:
        signal.signal(-code, signal.SIG_DFL)
    os.kill(os.getpid(), -code)
    os._exit(1)  # the signal does not end a process


if __name__ == "__main__":
    _main(int(sys.argv[1]), sys.argv[2:])
