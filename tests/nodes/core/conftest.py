"""The node that the tests of arjuna_core's ROS code look at."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from tests.helpers.ros import RosBench


@pytest.fixture
def node(request: pytest.FixtureRequest, bench: RosBench) -> Any:
    """An active node of the module's class NODE."""
    return bench.activated(request.module.NODE)
