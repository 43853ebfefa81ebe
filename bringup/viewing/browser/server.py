"""viser's server, kept to this machine."""

from __future__ import annotations

import re
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from ipaddress import ip_address

import rich
import viser
from websockets.asyncio import server as websocket_server

from arjuna_core.errors import ArjunaError

_OF_THIS_MACHINE = re.compile(r"https?://(localhost|127\.\d+\.\d+\.\d+|\[::1\])(:\d+)?")


class ServerError(ArjunaError):
    """The viewer cannot be served where it was asked for."""


class _Server(viser.ViserServer):
    """A server that no browser can have published on the Internet."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Refuse what viser would do: carry the robot's controls to a public address."""
        return None


def open_server(host: str, port: int) -> viser.ViserServer:
    """Serve a page.

    Args:
        host: The address; the loopback's, unless others shall reach it.
        port: The port; the next that is free, where it is taken.

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
    ask, and hands on no option to: so what it serves with is given one while it begins.
    """
    serve = websocket_server.serve
    if ip_address(address).is_loopback:
        origins = [None, _OF_THIS_MACHINE]  # None: no browser
        websocket_server.serve = partial(serve, origins=origins)  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        websocket_server.serve = serve  # type: ignore[misc]
