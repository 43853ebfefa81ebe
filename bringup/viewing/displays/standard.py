"""The displays of a viewer that no file configures."""

from __future__ import annotations

from dataclasses import replace

from bringup.viewing.displays.base import DisplaySpec as Spec

_PLAN, _LOCAL_PLAN = (20, 160, 60), (30, 110, 240)

STANDARD = (
    Spec("RobotModel", "Robot"),
    Spec("Map", "Map"),
    Spec("LaserScan", "Laser scan", "scan", anywhere=True),
    Spec(
        *("Map", "Global costmap", "global_costmap/costmap", False),
        {"color_scheme": "costmap", "alpha": 0.45, "height": 0.01},
    ),
    Spec(
        *("Map", "Local costmap", "local_costmap/costmap", True),
        {"color_scheme": "costmap", "alpha": 0.65, "height": 0.02},
    ),
    Spec("Polygon", "Footprint", "local_costmap/published_footprint"),
    Spec("ParticleCloud", "Particles"),
    Spec("PoseWithCovariance", "AMCL's pose", "amcl_pose"),
    Spec("PoseWithCovariance", "SLAM's pose", "pose"),
    Spec("Path", "Global path", "plan", True, {"color": _PLAN}),
    Spec("Path", "Local path", "local_plan", True, {"color": _LOCAL_PLAN}),
    Spec("MarkerArray", "Trajectories weighed (MPPI)", "trajectories", False),
    Spec("MarkerArray", "Trajectories weighed (DWB)", "marker", False),
    Spec("Pose", "Goal", "goal_pose"),
    Spec("People", "People and boxes", shown=False),
    Spec("TF", "TF", shown=False),
    Spec("Image", "Camera", "camera/image_raw", False, anywhere=True),
    Spec("Speed", "Plot of speed", "odom", False),
    Spec("LocalizationQuality", "Plot of localization quality", shown=False),
    Spec("DistanceToGoal", "Plot of distance to the goal", shown=False),
    Spec("BehaviorTree", "Behavior tree", shown=False),
)


def usual(kind: str, topic: str) -> Spec:
    """Return a display of a topic: with the settings of the one above whose topic it ends like."""
    alike = [one for one in STANDARD if one.kind == kind and topic.endswith(one.topic or topic)]
    spec = max(alike, key=lambda one: len(one.topic), default=Spec(kind, kind))
    return replace(spec, topic=topic)
