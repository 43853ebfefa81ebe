"""The sockets of Foxglove's protocol: clients, what they send in order, and what waits for them."""

from __future__ import annotations

import asyncio
import json
import logging
import queue
import socket
import struct
import threading
from collections.abc import Callable, Iterator, Sequence
from http import HTTPStatus
from ipaddress import ip_address
from typing import Any

from websockets.asyncio.server import ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from arjuna_core.errors import ArjunaError
from bringup.viewing.origins import OF_FOXGLOVE, OF_THIS_MACHINE

SUBPROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")
"""Of Foxglove's app since 2025, and of what came before and is derived from that."""
WARNING, ERROR = 1, 2
"""The levels of a status."""
_BACKLOG = 10_000_000  # [bytes] beyond which the protocol's own bridge drops messages for a client
_LARGEST = 2**26  # [bytes] of a client's message


class BridgeError(ArjunaError):
    """The bridge cannot be served where it was asked for."""


class Client:
    """A connected client; what it is sent waits for it, and nobody waits for that.

    Attributes:
        clock: The simulated time that it was sent last [ns], None where it gets none.
    """

    def __init__(self, connection: ServerConnection, loop: asyncio.AbstractEventLoop) -> None:
        self.clock: int | None = None
        self._connection, self._loop = connection, loop
        self._queue: asyncio.Queue[str | bytes] = asyncio.Queue()
        self._given = self._sent = 0

    def send(self, data: str | bytes, droppable: bool = False) -> None:
        """Send a frame; what is droppable is left out where too much waits already."""
        if droppable and self._given - self._sent > _BACKLOG:
            return
        self._given += len(data)
        self._loop.call_soon_threadsafe(self._queue.put_nowait, data)

    def send_message(self, op: str, **fields: Any) -> None:
        """Send one of the protocol's messages in JSON."""
        self.send(json.dumps({"op": op, **fields}))

    def send_status(self, level: int, text: str) -> None:
        """Send what the app lists among its problems."""
        self.send_message("status", level=level, message=text)

    def send_binary(self, code: int, form: str, *fields: Any, data: bytes = b"") -> None:
        """Send one of the protocol's binary messages: its code, fields of a form, and data."""
        self.send(struct.pack(f"<B{form}", code, *fields) + data, droppable=code == 1)

    async def write(self) -> None:
        """Send what waits, until the connection ends."""
        while True:
            data = await self._queue.get()
            await self._connection.send(data)
            self._sent += len(data)


class Server:
    """Accepts clients in a thread of its own.

    Args:
        subprotocols: One of them is spoken; none: clients name none.
        refused: Takes the origin of a page that may not connect, in that thread.

    Raises:
        BridgeError: The address is taken, or not this machine's.
    """

    def __init__(
        self,
        host: str,
        port: int,
        subprotocols: Sequence[str] = SUBPROTOCOLS,
        refused: Callable[[str], None] = lambda origin: None,
    ) -> None:
        self._subprotocols = [Subprotocol(name) for name in subprotocols] or None
        self._refused = refused
        self._received: queue.SimpleQueue[tuple[Client, str | bytes | bool]] = queue.SimpleQueue()
        self._loop = asyncio.new_event_loop()
        try:
            self._server = self._loop.run_until_complete(self._serve(host, port))
        except (OSError, OverflowError) as error:  # the latter of a port that is none
            self._loop.close()
            reason = getattr(error, "strerror", None) or error
            raise BridgeError(f"'{host}' port {port} cannot be served: {reason}") from error
        self.port: int = next(iter(self._server.sockets)).getsockname()[1]
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    async def _serve(self, host: str, port: int) -> Any:
        log = logging.getLogger(__name__)
        log.setLevel(logging.CRITICAL)  # what is no client, as a browser's page, is no fault here
        address = socket.getaddrinfo(host, port)[0][4][0]
        own = ip_address(address).is_loopback
        return await serve(
            *(self._talk, host, port),
            origins=[None, OF_THIS_MACHINE, OF_FOXGLOVE] if own else None,  # None: no browser
            subprotocols=self._subprotocols,
            compression=None,
            max_size=_LARGEST,
            logger=log,
            process_response=self._note_refused,
        )

    def _note_refused(self, _: ServerConnection, request: Request, response: Response) -> None:
        if response.status_code == HTTPStatus.FORBIDDEN:
            self._refused(request.headers.get("Origin", ""))

    async def _talk(self, connection: ServerConnection) -> None:
        client = Client(connection, self._loop)
        self._received.put((client, True))
        writer = asyncio.create_task(client.write())
        try:
            async for message in connection:
                self._received.put((client, message))
        except ConnectionClosed:
            pass
        finally:
            writer.cancel()
            self._received.put((client, False))

    def take(self) -> Iterator[tuple[Client, str | bytes | bool]]:
        """Yield what came since the last call: True where a client comes, False where it goes."""
        while not self._received.empty():
            yield self._received.get()

    def close(self) -> None:
        """Disconnect the clients."""
        asyncio.run_coroutine_threadsafe(self._stop(), self._loop).result(timeout=20.0)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _stop(self) -> None:
        self._server.close()
        await self._server.wait_closed()
