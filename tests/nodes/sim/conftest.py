"""Fixtures of the simulator's nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.helpers.ros import RosBench


@pytest.fixture
def bench() -> Iterator[RosBench]:
    """A process, and a client's node in it."""
    from tests.helpers.ros import RosBench

    bench = RosBench()
    yield bench
    bench.close()
