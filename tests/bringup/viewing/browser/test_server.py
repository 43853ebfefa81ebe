"""Claims: the viewer's page is served to this machine, and to its own pages alone."""

from __future__ import annotations

from http.client import HTTPConnection, HTTPResponse

import pytest

pytest.importorskip("viser", reason="no viewer here")

import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect
from websockets.typing import Origin

from bringup.cli import parse
from bringup.viewing.browser.server import ServerError, open_server


def open_from(server: viser.ViserServer, origin: str | None) -> None:
    here = None if origin is None else Origin(origin)
    connect(f"ws://127.0.0.1:{server.get_port()}", origin=here, proxy=None).close()


@pytest.mark.parametrize(
    "origin",
    ["https://example.com", "http://localhost.example.com", "http://127.0.0.1.example.com", "null"],
)
def test_a_page_of_another_site_cannot_connect(server: viser.ViserServer, origin: str) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        open_from(server, origin)


@pytest.mark.parametrize("origin", [None, "http://localhost:8080", "http://127.0.0.1:8081"])
def test_a_page_of_this_machine_can(server: viser.ViserServer, origin: str | None) -> None:
    open_from(server, origin)


def fetched(server: viser.ViserServer, host: str) -> HTTPResponse:
    connection = HTTPConnection("127.0.0.1", server.get_port(), timeout=10.0)
    connection.request("GET", "/", headers={"Host": host})
    return connection.getresponse()


@pytest.mark.parametrize("host", ["127.0.0.1", "localhost:8080", "[::1]:8080"])
def test_the_page_has_a_policy(server: viser.ViserServer, host: str) -> None:
    response = fetched(server, host)
    assert response.status == 200
    policy = response.headers["Content-Security-Policy"]
    assert "frame-ancestors 'self'" in policy
    assert "object-src 'none'" in policy


@pytest.mark.parametrize("host", ["robot.example.com", "127.0.0.1.example.com", "localhost@x", ""])
def test_a_name_that_leads_here_from_elsewhere_is_refused(
    server: viser.ViserServer, host: str
) -> None:
    response = fetched(server, host)
    assert response.status == 403
    assert b"valid: 127.0.0.1, localhost" in response.read()


def test_no_browser_can_publish_the_robot(server: viser.ViserServer) -> None:
    assert server.request_share_url() is None


def test_another_machines_address_is_refused() -> None:
    with pytest.raises(ServerError, match=r"'192\.0\.2\.1' is no address of this machine"):
        open_server("192.0.2.1", 0)


def test_viewers_are_served_on_loopback_unless_another_address_is_given() -> None:
    assert parse(["view"]).host == "127.0.0.1"
