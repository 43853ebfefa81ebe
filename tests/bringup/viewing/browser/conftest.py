"""Fixture: the viewer's server."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    import viser


@pytest.fixture(scope="module")
def server() -> Iterator[viser.ViserServer]:
    """Serve a page on this machine alone."""
    from bringup.viewing.browser.server import open_server

    opened = open_server("127.0.0.1", 0)
    yield opened
    opened.stop()
