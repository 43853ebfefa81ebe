"""The robot that drives through a log, for the nodes that map."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.helpers.slam_robot import Robot


@pytest.fixture
def robot() -> Iterator[Robot]:
    pytest.importorskip("slam_toolbox", reason="no ROS here")
    from tests.helpers.ros import RosBench
    from tests.helpers.slam_robot import Robot

    bench = RosBench()
    yield Robot(bench)
    bench.close()
