"""MuJoCo's own viewer beside the simulator: it shows what is, and changes nothing."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from arjuna_core.twist import Velocity
from arjuna_sim.model.robot import SOLO
from arjuna_sim.nodes.sim import SimNode
from arjuna_sim.physics import viewer
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import spawn, start_sim


class Window:
    """Stands in for MuJoCo's window, in which somebody pulls at everything."""

    opened: list[Window]

    def __init__(self, model: Any, data: Any) -> None:
        self.model, self.data = model, data
        self.opt = SimpleNamespace(geomgroup=np.ones(6))
        self.cam = SimpleNamespace(distance=0.5, elevation=0.0)
        self.running, self.positions = True, list[float]()
        Window.opened.append(self)

    def sync(self) -> None:
        """Take a picture, and turn gravity round."""
        self.positions.append(float(self.data.qpos[0]))
        self.model.opt.gravity[:] = (0.0, 0.0, 99.0)
        self.data.qvel[:] = 5.0

    def is_running(self) -> bool:
        """Return whether nobody has closed it."""
        return self.running

    def close(self) -> None:
        """Close it."""
        self.running = False


@pytest.fixture(autouse=True)
def _window(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Window, "opened", [], raising=False)
    monkeypatch.setattr(viewer, "_screen_error", lambda: "")
    monkeypatch.setattr(viewer, "_launch", Window)


def drive(sim: SimNode, seconds: float) -> bytes:
    """Drive in real time as the host does, on a made-up clock; return where the robot went."""
    wall, points = sim.simulator.time, []
    for _ in range(round(seconds / 0.02)):
        wall += 0.02
        sim.realtime_due(wall)
        sim.simulator.robots[SOLO].drive(Velocity(0.3, yaw_rate=0.2))
        sim.tick()
        points.append(sim.simulator.robots[SOLO].truth().pose.array())
    return np.array(points).tobytes()


def test_the_viewer_follows_and_the_physics_does_not_notice(bench: RosBench) -> None:
    watched = drive(start_sim(bench, viewer=True), 1.0)
    (window,) = Window.opened
    assert 25 <= len(window.positions) <= 31
    assert window.positions[-1] == pytest.approx(np.frombuffer(watched)[-6], abs=0.02)
    other = RosBench(transport="dds")
    try:
        assert drive(start_sim(other), 1.0) == watched
    finally:
        other.close()


def test_a_window_reopens_with_another_model_and_stays_closed_by_hand(bench: RosBench) -> None:
    sim = start_sim(bench, viewer=True)
    drive(sim, 0.2)
    spawn(bench, "crate")
    drive(sim, 0.2)
    first, second = Window.opened
    assert (first.running, second.running) == (False, True)
    second.running = False
    pictures = len(second.positions)
    drive(sim, 0.2)
    assert (len(Window.opened), len(second.positions)) == (2, pictures)


def test_the_window_closes_with_the_simulator_and_never_opens_in_lock_step(bench: RosBench) -> None:
    sim = start_sim(bench, viewer=True)
    sim.tick()
    assert Window.opened == []
    drive(sim, 0.1)
    sim.trigger_deactivate()
    assert not Window.opened[0].running


def test_without_a_screen_the_error_names_the_browser(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(viewer, "_screen_error", lambda: "nothing is plugged in")
    with pytest.raises(viewer.ViewerError, match=r"nothing is plugged in; '.* view' shows"):
        viewer.Viewer()
