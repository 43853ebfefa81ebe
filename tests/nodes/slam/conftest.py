"""The robots that drive through a log or a room, for the nodes of SLAM, and what those log."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

from tests.nodes.slam.nodes import Logged

if TYPE_CHECKING:
    from tests.helpers.amcl_room import Room
    from tests.helpers.ros import RosBench
    from tests.helpers.slam_robot import Robot


@pytest.fixture
def bench() -> Iterator[RosBench]:
    pytest.importorskip("slam_toolbox", reason="no ROS here")
    from tests.helpers.ros import RosBench

    bench = RosBench()
    yield bench
    bench.close()


@pytest.fixture
def robot(bench: RosBench) -> Robot:
    from tests.helpers.slam_robot import Robot

    return Robot(bench)


@pytest.fixture
def room(bench: RosBench) -> Room:
    from tests.helpers.amcl_room import Room

    return Room(bench)


@pytest.fixture
def logged(monkeypatch: pytest.MonkeyPatch) -> Logged:
    """Warnings and errors of the nodes under test."""
    from arjuna_slam.nodes.amcl import AmclNode
    from arjuna_slam.nodes.slam_toolbox import SlamToolboxNode

    found = Logged()
    for node in (SlamToolboxNode, AmclNode):
        monkeypatch.setattr(node, "get_logger", lambda _: found)
    return found
