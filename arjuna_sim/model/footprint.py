"""A robot's outline from above, as costmaps want it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from arjuna_sim.model.geometry.shapes import corners
from arjuna_sim.model.robot import RobotModel


def footprint(robot: RobotModel, frame: str) -> NDArray[np.float64]:
    """Return the convex outline of all that can touch something, every joint at zero.

    Args:
        robot: The robot; a driven wheel touches with its looks where it has no collision shape.

    Returns:
        `(N, 2) float64` [m], counter-clockwise; none where no shape has an area.
    """
    urdf = robot.urdf
    wheels = {urdf.joints[joint].child for joint in robot.wheel_joints}
    T_frame_root = urdf.T_root(frame).inverse()
    points = [np.zeros((0, 2))]
    for link in urdf.links.values():
        T_frame_link = T_frame_root @ urdf.T_root(link.name)
        for part in link.collisions or (link.visuals if link.name in wheels else ()):
            points.append((T_frame_link @ part.pose).apply(corners(part.shape))[:, :2])
    every = np.vstack(points)
    try:
        outline = every[ConvexHull(every).vertices]
    except (QhullError, ValueError):
        return np.zeros((0, 2))
    return np.round(_without_fine_corners(outline), 3)


def inscribed_radius(robot: RobotModel) -> float:
    """Return half the width of the narrowest gap that a robot passes ahead or sideways [m]."""
    outline = footprint(robot, robot.urdf.root)
    return float(np.ptp(outline, axis=0).min()) / 2.0 if len(outline) else 0.0


def _without_fine_corners(outline: NDArray[np.float64]) -> NDArray[np.float64]:
    """Take out corners, the finest first, that stand out less than counts."""
    while len(outline) > 3:
        before, after = np.roll(outline, 1, axis=0), np.roll(outline, -1, axis=0)
        along, offset = after - before, outline - before
        length = np.maximum(np.hypot(*along.T), 1e-9)
        height = np.abs(along[:, 0] * offset[:, 1] - along[:, 1] * offset[:, 0]) / length
        finest = int(height.argmin())
        # [m] A corner that stands out by less is left out.
        if height[finest] >= 0.003:
            break
        outline = np.delete(outline, finest, axis=0)
    return outline
