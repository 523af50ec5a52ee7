"""The PLC's side of the bridge: its holding registers over Modbus TCP."""

from __future__ import annotations

import logging
import socket
from collections.abc import Sequence

from pymodbus.client import ModbusTcpClient
from pymodbus.exceptions import ModbusException
from pymodbus.pdu import ExceptionResponse, ModbusPDU

from rcx_harness.bridge.core import Registers

__all__ = ["PlcError", "PlcLink"]

_EXCEPTIONS = {
    1: "illegal function",
    2: "illegal data address",
    3: "illegal data value",
    4: "device failure",
    6: "device busy",
    10: "gateway path unavailable",
    11: "gateway target device failed to respond",
}
_NO_SUCH_REGISTER = 2

# The log of the library is switched off, because this module reports errors itself.
logging.getLogger("pymodbus").setLevel(logging.CRITICAL + 1)


class PlcError(Exception):
    """The error if the PLC cannot be reached, does not answer, or refuses a request."""


class PlcLink:
    """The PLC's registers over Modbus TCP; the client can reconnect after any failure.

    Args:
        unit: Modbus unit identifier, 0 to 255.
        timeout_s: Longest wait for an answer, in seconds.
        connect_s: Longest wait for a connection, in seconds.
    """

    def __init__(
        self,
        host: str,
        port: int,
        registers: Registers,
        *,
        unit: int = 1,
        timeout_s: float = 0.1,
        connect_s: float = 2.0,
    ) -> None:
        self.name = f"{host}:{port}"
        self._address = (host, port)
        self._registers = registers
        self._unit = unit
        self._timeout_s = timeout_s
        self._connect_s = connect_s
        # The client must not repeat requests: a late answer is a loss.
        self._client = ModbusTcpClient(host, port=port, timeout=timeout_s, retries=0)

    @property
    def connected(self) -> bool:
        """Return whether there is a TCP connection."""
        return self._client.connected

    def connect(self) -> None:
        """Connect to the PLC if there is no TCP connection."""
        if self.connected:
            return
        try:
            made = socket.create_connection(self._address, self._connect_s)
        # A bad port or host name also raises one of these errors.
        except (OSError, OverflowError, UnicodeError) as error:
            raise PlcError(f"no Modbus TCP connection to {self.name}: {error}") from None
        # Requests are small segments. Nagle's algorithm would delay them by 40 ms.
        made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client.socket = made

    def read(self) -> tuple[int, ...]:
        """Read the area to the robot and the heartbeat that follows it, as words."""
        first = self._registers.read
        words: list[int] = []
        for start, count in self._registers.parts(first):
            what = f"reading of holding registers {start} to {start + count - 1}"
            answer = self._ask("read_holding_registers", what, start, count=count)
            if len(answer.registers) != count:
                raise self._failure(f"{what}: {len(answer.registers)} registers were received")
            words += answer.registers
        return tuple(words)

    def write(self, words: Sequence[int]) -> None:
        """Write the area from the robot, and the life word that follows it.

        The life word is written last, so that the area is complete once it arrives.
        """
        first = self._registers.write
        for start, count in self._registers.parts(first):
            what = f"writing of holding registers {start} to {start + count - 1}"
            part = list(words[start - first : start - first + count])
            self._ask("write_registers", what, start, part)

    def close(self) -> None:
        """Close the connection; later calls do nothing."""
        self._client.close()  # type: ignore[no-untyped-call]

    def _ask(self, request: str, what: str, *args: object, **more: object) -> ModbusPDU:
        if not self.connected:
            raise PlcError(f"no Modbus TCP connection to {self.name}")
        try:
            answer: ModbusPDU = getattr(self._client, request)(*args, device_id=self._unit, **more)
        except (ModbusException, OSError) as error:
            raise self._failure(f"{what}: {_cause(error, self._timeout_s)}") from None
        if isinstance(answer, ExceptionResponse):
            code = answer.exception_code
            text = f"{what} was refused: Modbus exception {code}"
            if code in _EXCEPTIONS:
                text += f", {_EXCEPTIONS[code]}"
            if code == _NO_SUCH_REGISTER:
                text += "; check that the PLC has these registers"
            raise PlcError(f"{self.name}: {text}")
        return answer

    def _failure(self, text: str) -> PlcError:
        """Close the connection and return the error.

        A late answer could otherwise be taken for the answer to the next request.
        """
        self.close()
        return PlcError(f"{self.name}: {text}")


def _cause(error: Exception, timeout_s: float) -> str:
    if "No response" in str(error):
        return f"no answer within {timeout_s * 1e3:g} ms"
    if isinstance(error, OSError):
        return str(error)
    return "the connection was closed, or the answer is not Modbus"
