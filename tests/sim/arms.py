"""An arm of three joints with a gripper, fixed to the world or on a cart, and what moves it."""

from __future__ import annotations

from pathlib import Path

import yaml

JOINTS = ("shoulder", "elbow", "wrist")
CONTROLLERS: dict[str, dict[str, object]] = {
    "arm_controller": {
        "type": "joint_trajectory_controller/JointTrajectoryController",
        "joints": list(JOINTS),
        "command_interfaces": ["position"],
        "constraints": {
            "goal_time": 0.5,
            "stopped_velocity_tolerance": 0.05,
            **{name: {"goal": 0.01} for name in JOINTS},
        },
    },
    "positions": {"type": "position_controllers/JointGroupPositionController", "joints": JOINTS},
    "speeds": {"type": "velocity_controllers/JointGroupVelocityController", "joints": JOINTS},
    "efforts": {"type": "effort_controllers/JointGroupEffortController", "joints": ["wrist"]},
    "gripper": {"type": "position_controllers/GripperActionController", "joint": "finger"},
    "broadcaster": {"type": "joint_state_broadcaster/JointStateBroadcaster"},
}
"""Controllers of the arm: the types and parameters of ros2_control."""


def _link(name: str, mass: float, length: float) -> str:
    i = mass * length**2 / 12.0
    return (
        f"<link name='{name}'><inertial><origin xyz='0 0 {length / 2}'/><mass value='{mass}'/>"
        f"<inertia ixx='{i}' iyy='{i}' izz='{i}' ixy='0' ixz='0' iyz='0'/></inertial>"
        f"<collision><origin xyz='0 0 {length / 2}'/><geometry>"
        f"<box size='0.03 0.03 {length}'/></geometry></collision></link>"
    )


def _joint(name: str, kind: str, parent: str, child: str, z: float, axis: str, more: str) -> str:
    return (
        f"<joint name='{name}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>"
        f"<origin xyz='0 0 {z}'/><axis xyz='{axis}'/>{more}</joint>"
    )


def write_arm(
    folder: Path, controllers: dict[str, dict[str, object]] | None = None, extra: str = ""
) -> Path:
    """Write the arm's URDF, and beside it the controllers where there are some."""
    turn = "<limit lower='-2.5' upper='2.5' effort='60' velocity='3'/>"
    slide = "<limit lower='0' upper='0.04' effort='10' velocity='0.1'/>"
    parts = [
        "<link name='world'/>",
        *(_link("base", 5.0, 0.2), _link("upper", 2.0, 0.3), _link("fore", 1.0, 0.3)),
        *(_link("hand", 0.5, 0.1), _link("left", 0.05, 0.05), _link("right", 0.05, 0.05)),
        "<joint name='foot' type='fixed'><parent link='world'/><child link='base'/></joint>",
        _joint("shoulder", "revolute", "base", "upper", 0.2, "0 0 1", turn),
        _joint(
            "elbow",
            "revolute",
            "upper",
            "fore",
            0.3,
            "0 1 0",
            turn + "<dynamics damping='0.5' friction='0.2'/>",
        ),
        _joint("wrist", "revolute", "fore", "hand", 0.3, "0 1 0", turn),
        _joint("finger", "prismatic", "hand", "left", 0.12, "0 1 0", slide),
        _joint(
            "follower",
            "prismatic",
            "hand",
            "right",
            0.12,
            "0 -1 0",
            slide + "<mimic joint='finger'/>",
        ),
    ]
    if controllers is not None:
        manager = {"update_rate": 50, **{n: {"type": c["type"]} for n, c in controllers.items()}}
        nodes = {"controller_manager": manager, **controllers}
        content = {
            name: {
                "ros__parameters": {
                    k: list(v) if isinstance(v, tuple) else v
                    for k, v in values.items()
                    if name == "controller_manager" or k != "type"
                }
            }
            for name, values in nodes.items()
        }
        (folder / "controllers.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
        joints = "".join(
            f"<joint name='{name}'><command_interface name='position'/>"
            "<state_interface name='position'><param name='initial_value'>"
            f"{0.25 if name == 'elbow' else 0.0}</param></state_interface></joint>"
            for name in (*JOINTS, "finger")
        )
        extra += (
            "<ros2_control name='arm_system' type='system'><hardware>"
            f"<plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>{joints}</ros2_control>"
            "<gazebo><plugin filename='gz_ros2_control-system' name='c'>"
            "<parameters>controllers.yaml</parameters></plugin></gazebo>"
        )
    path = folder / "arm.urdf"
    path.write_text(f"<robot name='arm'>{''.join(parts)}{extra}</robot>")
    return path
