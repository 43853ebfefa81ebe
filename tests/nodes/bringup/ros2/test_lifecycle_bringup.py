"""`ros2 run nav2_util lifecycle_bringup`: nodes are configured and activated."""

from __future__ import annotations

import pytest

from arjuna_slam.nodes.map_server import MapServerNode
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs import lifecycle_bringup
from tests.helpers.ros import RosBench
from tests.nodes.bringup.ros2.test_control import BenchClient


def test_nodes_are_brought_up(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lifecycle_bringup, "Client", lambda **given: BenchClient(bench))
    bench.process.add(MapServerNode(bench.process, {}))
    lifecycle_bringup.main(["map_server", "/map_server"])
    assert capsys.readouterr().out.splitlines() == ["/map_server is active"] * 2
    with pytest.raises(Ros2Error, match="no node is named"):
        lifecycle_bringup.main([])


def test_a_node_that_cannot_be_configured_is_named(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lifecycle_bringup, "Client", lambda **given: BenchClient(bench))
    bench.process.add(MapServerNode(bench.process, {"yaml_filename": "/no/map.yaml"}))
    with pytest.raises(Ros2Error, match="/map_server is unconfigured; its log says why"):
        lifecycle_bringup.main(["map_server"])
