"""`ros2 lifecycle set`: what scripts tell a node that came up by itself."""

from __future__ import annotations

import argparse
from typing import Any

import pytest

from arjuna_core.files.shipped import shipped_file
from arjuna_slam.nodes.map_server import MapServerNode
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs import lifecycle
from tests.helpers.ros import RosBench
from tests.nodes.bringup.ros2.test_control import BenchClient
from tests.nodes.sim.running import start


class _Client(BenchClient):
    """Finds every node that is named."""

    def find_node(self, name: str, hidden: bool) -> str:
        return name

    def discover(self, is_met: Any) -> bool:
        return True

    def call(self, kind: Any, name: str, request: Any, timeout: float = 1.0) -> Any:
        return super().call(kind, name, request, timeout)


def test_a_node_that_is_up_takes_being_brought_up(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(lifecycle, "Client", lambda arguments: _Client(bench))
    path = str(shipped_file("maps/arjuna_room.yaml"))
    start(bench, MapServerNode(bench.process, {"yaml_filename": path}))
    given = {"node_name": "/map_server", "include_hidden_nodes": False}

    def told(transition: str) -> str:
        lifecycle.set_(argparse.Namespace(**given, transition=transition))
        return capsys.readouterr().out

    for up in ("configure", "activate", "1", "3"):
        assert told(up) == "Transitioning successful\n"
    for refused in ("cleanup", "5", "fly"):
        with pytest.raises(Ros2Error, match=r"Unknown transition requested.*\n- deactivate \[4\]"):
            told(refused)
    assert told("deactivate") == "Transitioning successful\n"
