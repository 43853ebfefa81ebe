"""viser's server, kept to this machine."""

from __future__ import annotations

import socket

import rich
import viser

from arjuna_core.errors import ArjunaError


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
        with socket.create_server((host, 0)):
            pass
    except OSError as error:
        problem = f"'{host}' is no address of this machine: {error.strerror}; valid: 127.0.0.1"
        raise ServerError(problem) from error
    rich.get_console().quiet = True  # viser prints boxes
    return _Server(host=host, port=port, label="Arjuna", verbose=False)
