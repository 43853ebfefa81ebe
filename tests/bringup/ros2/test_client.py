"""The node of the `ros2` command: what it waits for, and for how long."""

from __future__ import annotations

import pytest

from bringup.ros2 import client
from bringup.ros2.verbs.forward import LAUNCHED

pytestmark = pytest.mark.ros


@pytest.mark.parametrize(("launched", "patience"), [(True, 20.0), (False, None)])
def test_a_node_that_starts_beside_in_a_launch_file_is_waited_for(
    launched: bool, patience: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    given: list[float | None] = []

    def discover(session: object, found: object, duration: float | None) -> bool:
        given.append(duration)
        return True

    monkeypatch.setattr(client, "discover", discover)
    monkeypatch.setenv(LAUNCHED, "1")
    if not launched:
        monkeypatch.delenv(LAUNCHED)
    asking = object.__new__(client.Client)
    asking._limit = None
    assert asking.find_node("robot_state_publisher") == "/robot_state_publisher"
    assert given == [patience]
