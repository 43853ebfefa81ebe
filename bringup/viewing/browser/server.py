"""viser's server, kept to this machine."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from http import HTTPStatus
from ipaddress import ip_address
from typing import Any

import rich
import viser
from websockets.asyncio import server as websocket_server
from websockets.http11 import Response

from arjuna_core.errors import ArjunaError
from bringup.viewing.origins import OF_THIS_MACHINE

_POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; connect-src 'self' ws: wss:"
    " data: blob:; object-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'self'"
)
"""What the page may load and who may show it in a frame: itself alone."""


class ServerError(ArjunaError):
    """The viewer cannot be served where it was asked for."""


class _Server(viser.ViserServer):
    """A server that no browser can have published on the Internet."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse what viser would do: carry the robot's controls to a public address."""
        return None


def open_server(host: str, port: int) -> viser.ViserServer:
    """Serve a page.

    Raises:
        ServerError: The address is not this machine's.
    """
    try:
        with socket.create_server((host, 0)) as tried:
            address = tried.getsockname()[0]
    except OSError as error:
        problem = f"'{host}' is no address of this machine: {error.strerror}; valid: 127.0.0.1"
        raise ServerError(problem) from error
    rich.get_console().quiet = True  # viser prints boxes
    with _to_own_pages(address):
        return _Server(host=host, port=port, label="Arjuna", verbose=False)


@contextmanager
def _to_own_pages(address: str) -> Iterator[None]:
    """Let a server that begins on the loopback refuse the sockets of other sites' pages.

    A browser lets any page connect to this machine and says only whose page it is. viser does not
    ask, and hands on no option to: so what it serves with is given some while it begins.
    """
    serve, own = websocket_server.serve, ip_address(address).is_loopback
    options: dict[str, Any] = {"process_response": partial(_answered, own)}
    if own:
        options["origins"] = [None, OF_THIS_MACHINE]  # None: no browser
    websocket_server.serve = partial(serve, **options)  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websocket_server.serve = serve  # type: ignore[misc]


def _answered(own: bool, connection: Any, request: Any, response: Response) -> Response:
    """Return a response with the page's policy; refuse names that lead here from elsewhere.

    A site whose name is given this machine's address later has its pages here otherwise, as its own
    (DNS rebinding).
    """
    host = request.headers.get("Host", "")
    if own and not OF_THIS_MACHINE.fullmatch(f"http://{host}"):
        refused: Response = connection.respond(HTTPStatus.FORBIDDEN, "valid: 127.0.0.1, localhost")
        return refused
    response.headers["Content-Security-Policy"] = _POLICY
    return response
