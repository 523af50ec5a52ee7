"""A PLC's Modbus TCP server (pymodbus); the test reads and writes its registers.

The server holds a lock during each request, as OpenPLC's runtime locks its buffers. A request
therefore reads or writes all of its registers between two scans.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.server import ModbusTcpServer
from pymodbus.simulator import DataType, SimData, SimDevice

_LIMIT_S = 60.0
_READ, _WRITE = 3, 16


class ModbusPlc:
    """Holding registers 0 to 199 and 1024 to 1223 on a free port of the loopback interface.

    Attributes:
        port: Its TCP port; the same after `stop` and `start`.
        holds: Maps the number of a register to its value. Missing registers are 0.
        refuses: The exception code with which the server refuses every request, or None.
        deaf: Whether the server leaves requests without an answer.
        requests: Function code, first register and number of each request, in their order.
    """

    def __init__(self, unit: int = 1) -> None:
        self.port = 0
        self.holds: dict[int, int] = {}
        self.refuses: ExcCodes | None = None
        self.deaf = False
        self.requests: list[tuple[int, int, int]] = []
        self._unit = unit
        self._exchanged = threading.Condition()
        self._exchanges = 0
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        self.start()

    def start(self) -> None:
        """Start the server. After a stop it uses the same port again."""
        self._run(self._start())

    def stop(self) -> None:
        """Close every connection and stop listening. The registers do not change."""
        self._run(self._server.shutdown())  # type: ignore[no-untyped-call]

    @contextmanager
    def between_scans(self) -> Iterator[dict[int, int]]:
        """Give access to the registers while no request is served."""
        with self._exchanged:
            yield self.holds

    def wait_exchanges(self, number: int = 1) -> None:
        """Wait until a client has read and then written the registers this many times more."""
        with self._exchanged:
            goal = self._exchanges + number
            done = self._exchanged.wait_for(lambda: self._exchanges >= goal, _LIMIT_S)
        assert done, "no client has read and written the registers"

    def close(self) -> None:
        """End the PLC's server."""
        self.stop()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_LIMIT_S)
        self._loop.close()

    def __enter__(self) -> ModbusPlc:
        """Return the listening PLC."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the PLC's server."""
        self.close()

    def _run(self, what: Any) -> None:
        asyncio.run_coroutine_threadsafe(what, self._loop).result(_LIMIT_S)

    async def _start(self) -> None:
        data = [
            SimData(first, count=200, values=0, datatype=DataType.REGISTERS) for first in (0, 1024)
        ]
        device = SimDevice(self._unit, simdata=data, action=self._serve)
        self._server = ModbusTcpServer(device, address=("127.0.0.1", self.port))
        await self._server.serve_forever(background=True)
        listener: Any = self._server.transport
        self.port = listener.sockets[0].getsockname()[1]

    async def _serve(
        self,
        function: int,
        start: int,
        address: int,
        count: int,
        registers: list[int],
        values: list[int] | list[bool] | None,
    ) -> ExcCodes | None:
        with self._exchanged:
            self.requests.append((function, address, count))
            if self.refuses is not None:
                return self.refuses
            at = address - start
            if values is not None:
                self.holds.update(enumerate(map(int, values), address))
                self._exchanges += 1
                self._exchanged.notify_all()
            else:
                for k in range(count):
                    registers[at + k] = self.holds.get(address + k, 0)
        while self.deaf:
            await asyncio.sleep(0.001)
        return None
