"""Forward kinematics of a differential drive: a new pose from what the wheels have rolled."""

import math

BASELINE = 0.160
"""Between the burger's wheels [m]."""

Pose = tuple[float, float, float]
"""x [m], y [m], theta [rad]."""


def moved(pose: Pose, left: float, right: float, baseline: float = BASELINE) -> Pose:
    """Return the pose after the wheels have rolled `left` and `right` [m], as if in a line."""
    x, y, theta = pose
    path, turn = (left + right) / 2.0, (right - left) / baseline
    return x + path * math.cos(theta), y + path * math.sin(theta), theta + turn


def moved_on_arc(pose: Pose, left: float, right: float, baseline: float = BASELINE) -> Pose:
    """Return the pose after the same on an arc of a circle, which it really is."""
    x, y, theta = pose
    path, turn = (left + right) / 2.0, (right - left) / baseline
    if abs(turn) < 1e-9:
        return moved(pose, left, right, baseline)
    radius = path / turn
    dx = radius * (math.sin(theta + turn) - math.sin(theta))
    dy = radius * (math.cos(theta) - math.cos(theta + turn))
    return x + dx, y + dy, theta + turn


def main() -> None:
    """Drive a quarter of a circle in one step, and in a hundred."""
    rolled = (0.2, 0.2 + BASELINE * math.pi / 2.0)
    steps = 100
    pose: Pose = (0.0, 0.0, 0.0)
    for _ in range(steps):
        pose = moved(pose, *(path / steps for path in rolled))
    rows = (("one step in a line", moved((0.0, 0.0, 0.0), *rolled)), ("a hundred", pose))
    for name, (x, y, theta) in (*rows, ("the arc", moved_on_arc((0.0, 0.0, 0.0), *rolled))):
        print(f"{name:20} x={x:.3f} y={y:.3f} theta={math.degrees(theta):.1f} deg")  # noqa: T201


if __name__ == "__main__":
    main()
