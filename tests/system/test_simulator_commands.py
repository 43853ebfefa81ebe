"""`python -m bringup entity` and `world` against a simulator in a process of its own."""

from __future__ import annotations

import re

import pytest

from bringup import cli
from bringup.cli import parse
from bringup.client.simulator import SimulatorClient, SimulatorError
from tests.helpers.processes import Lines

pytestmark = [pytest.mark.ros, pytest.mark.system]


@pytest.fixture(autouse=True)
def _own_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "92")


def test_commands_change_the_running_simulation(capfd: pytest.CaptureFixture[str]) -> None:
    def says(*words: str, code: int = 0) -> str:
        assert cli.run(parse(list(words))) == code
        captured = capfd.readouterr()
        return captured.out if code == 0 else captured.err

    with Lines("-m", "bringup", "sim", "--log-level", "info") as bringup:
        bringup.wait_for("Managed nodes are active")
        says("entity", "spawn", "crate", "box:0.4,0.4,1", "--at", "1", "1")
        assert "'crate' is taken" in says("entity", "spawn", "crate", "sphere:0.1", code=2)
        says("entity", "move", "crate", "1.5", "-1")
        says("entity", "spawn", "bob", "person", "--path", "3,-1 3,3", "--speed", "2", "--once")
        listed = says("entity", "list", "--filter", "crate|bob")
        assert re.search(r"crate +x +1\.500 +y +-1\.000", listed)
        assert "paused" in says("world", "pause")
        says("world", "step", "200")  # bob goes round the red box
        assert re.search(r"bob +x +3\.000 +y +3\.000", says("entity", "list"))
        says("entity", "delete", "crate")
        assert "crate" not in says("entity", "list")
        says("world", "reset", "--scope", "spawned")
        assert "bob" not in says("entity", "list")
        assert "stopped" in says("world", "load", "worlds/empty.world")
        assert "playing" in says("world", "play")
        says("world", "quit")
        assert bringup.read_to_end() == 0
        assert bringup.matching("sim quit, and so do all")


def test_without_a_simulator_a_clear_error_comes_in_time() -> None:
    client = SimulatorClient(timeout=0.2)
    try:
        with pytest.raises(
            SimulatorError, match=r"nobody serves 'delete_entity' within 0\.2 s; start a simulator"
        ):
            client.delete("crate")
    finally:
        client.close()
