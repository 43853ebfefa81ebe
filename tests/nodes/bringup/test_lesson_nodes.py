"""The lessons' programs in a closed loop with an ideal robot: they arrive, and stop in time."""

from __future__ import annotations

import importlib.util
import math
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from sensor_msgs.msg import LaserScan

from arjuna_core.files.shipped import shipped_file

TICK = 0.02
GOALS = [(1.0, 0.0), (0.6, 0.6), (-0.5, 0.8), (-1.0, 0.01), (-1.0, -0.01), (0.2, -0.7)]


def _module(path: str, monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    file = shipped_file(path)
    monkeypatch.syspath_prepend(str(file.parent))
    spec = importlib.util.spec_from_file_location(Path(path).stem, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, spec.name, module)
    spec.loader.exec_module(module)
    return module


def _drive(kind: type[Any], goal: tuple[float, float], seconds: float) -> tuple[float, float]:
    """Return how far from the goal an ideal robot ends, and how much it has turned [m, rad]."""
    mover: Any = object.__new__(kind)  # its node is not needed
    x = y = theta = turned = 0.0
    for _ in range(round(seconds / TICK)):
        dx, dy = goal[0] - x, goal[1] - y
        mover.rho = math.hypot(dx, dy)
        if mover.rho <= mover.tolerance:
            break
        heading = math.atan2(math.sin(theta), math.cos(theta))  # as odometry says it
        twist = mover.command(math.atan2(dy, dx) - heading)
        x += twist.linear.x * math.cos(theta) * TICK
        y += twist.linear.x * math.sin(theta) * TICK
        theta += twist.angular.z * TICK
        turned += abs(twist.angular.z) * TICK
    return mover.rho, turned


@pytest.mark.parametrize("goal", GOALS)
def test_the_direct_goal_mover_arrives_without_detours(
    goal: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    kind = _module("guides/turtlebot3/direct_pose.py", monkeypatch).DirectPose
    rho, turned = _drive(kind, goal, 60.0)
    assert rho <= kind.tolerance == 0.02
    assert turned < 1.2 * math.pi


def test_the_simple_goal_mover_arrives_on_the_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    kind = _module("guides/turtlebot3/simple_pose.py", monkeypatch).SimplePose
    assert _drive(kind, (0.6, 0.6), 60.0)[0] <= 0.2
    assert _drive(kind, (0.2, -0.7), 60.0)[1] > 1.5 * math.pi  # the long way round


def test_kinematics_of_many_steps_are_those_of_the_arc(monkeypatch: pytest.MonkeyPatch) -> None:
    kinematics = _module("guides/turtlebot3/kinematics.py", monkeypatch)
    arc = kinematics.moved_on_arc((0.1, 0.2, 0.3), 0.3, 0.5)
    pose = (0.1, 0.2, 0.3)
    for _ in range(1000):
        pose = kinematics.moved(pose, 0.3 / 1000, 0.5 / 1000)
    assert pose == pytest.approx(arc, abs=1e-3)
    assert kinematics.moved_on_arc((0.0, 0.0, 0.0), 0.4, 0.4) == pytest.approx((0.4, 0.0, 0.0))


def test_the_emergency_stop_slows_down_and_holds(monkeypatch: pytest.MonkeyPatch) -> None:
    stop = _module("docs/tutorial/nodes/obstacle_avoider.py", monkeypatch)
    near, speeds = 2.0, []
    for _ in range(1000):
        speeds.append(stop.limited(0.3, near))
        near -= speeds[-1] * TICK
    assert near == pytest.approx(0.35, abs=0.005)
    assert speeds[0] == 0.3
    assert stop.limited(0.3, 0.70) == 0.3 > stop.limited(0.3, 0.5) > stop.limited(0.3, 0.36)
    assert stop.limited(0.3, 0.2) == 0.0
    assert stop.limited(-0.3, 0.2) == -0.3


@pytest.mark.parametrize("angle_min", [-math.pi, 0.0])
def test_the_emergency_stop_looks_ahead(angle_min: float, monkeypatch: pytest.MonkeyPatch) -> None:
    stop = _module("docs/tutorial/nodes/obstacle_avoider.py", monkeypatch)
    scan = LaserScan(angle_min=angle_min, angle_increment=math.radians(1.0))
    scan.range_min, scan.range_max = 0.1, 10.0
    bearings = [angle_min + i * scan.angle_increment for i in range(360)]
    scan.ranges = [1.0 if math.cos(b) > math.cos(0.1) else 0.3 for b in bearings]
    assert stop.nearest_ahead(scan) == pytest.approx(0.3)  # within the arc, beside the way
    scan.ranges = [1.0 if math.cos(b) > math.cos(0.6) else 0.3 for b in bearings]
    assert stop.nearest_ahead(scan) == pytest.approx(1.0)
    scan.ranges = [math.inf] * 360
    assert stop.nearest_ahead(scan) == math.inf
