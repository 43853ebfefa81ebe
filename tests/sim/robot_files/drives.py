"""Tags by which a robot file names its driven wheels."""

from __future__ import annotations

from tests.sim.robot_files.options import RobotFile
from tests.sim.robot_files.tags import plugin, transmission


def drive_tag(robot: RobotFile) -> str:
    """Return what names the wheels that drive, or nothing."""
    joints = [(name, f"{name}_wheel_joint") for name, _, _ in robot.wheels()]
    size = f"<wheel_separation>{robot.track}</wheel_separation>"
    round_ = f"<wheel_diameter>{2 * robot.radius}</wheel_diameter>"
    sides = "".join(
        f"<{side}_joint>{joint}</{side}_joint>"
        for name, joint in joints
        for side in ("left", "right")
        if side in name and not (robot.steers and name.startswith("front"))
    )
    steering = "".join(
        f"<{side}_steering_joint>front_{side}_steer_joint</{side}_steering_joint>"
        for side in ("left", "right")
    )
    if robot.layout == "ackermann" and robot.drive in ("classic", "gz", "bare gz"):
        return plugin("gz-sim-ackermann-steering-system", sides + steering + size)
    if robot.drive == "ros2_control" or (robot.steers and robot.drive == "classic"):
        return _ros2_control(robot)
    if robot.steers or robot.drive == "none":
        return ""
    if robot.drive == "transmission":
        return "".join(transmission(joint) for _, joint in joints)
    if robot.drive == "ROS 1" and robot.layout == "skid":
        return _skid_steer(robot)
    if robot.drive in ("gz", "bare gz"):
        radius = f"<wheel_radius>{robot.radius}</wheel_radius>"
        bare = robot.drive == "bare gz" and robot.solid != "none"
        return plugin("gz-sim-diff-drive-system", sides + ("" if bare else size + radius))
    return plugin("libgazebo_ros_diff_drive.so", sides + size + round_)


def _skid_steer(robot: RobotFile) -> str:
    named = "".join(
        f"<{side}{end}Joint>{end.lower()}_{side}_wheel_joint</{side}{end}Joint>"
        for side in ("left", "right")
        for end in ("Front", "Rear")
    )
    own = f"<wheelSeparation>{robot.track}</wheelSeparation>"
    own += f"<wheelDiameter>{2 * robot.radius}</wheelDiameter><torque>200</torque>"
    return plugin("libgazebo_ros_skid_steer_drive.so", named + own)


def _ros2_control(robot: RobotFile) -> str:
    parameters = "$(find made_description)/config/controllers.yaml"
    joints = "".join(
        f"<joint name='{name}_wheel_joint'><command_interface name='velocity'/>"
        "<state_interface name='position'/></joint>"
        for name, _, _ in robot.wheels()
    )
    return (
        "<ros2_control name='system' type='system'><hardware>"
        f"<plugin>gz_ros2_control/GazeboSimSystem</plugin></hardware>{joints}</ros2_control>"
    ) + plugin("gz_ros2_control-system", f"<parameters>{parameters}</parameters>")


def controllers(robot: RobotFile) -> str:
    """Return the file of the controllers' parameters."""
    names = [f"{name}_wheel_joint" for name, _, _ in robot.wheels()]
    if robot.steers:
        driven = [name for name in names if name.startswith("rear")]
        steering = ["front_left", "front_right"] if robot.layout == "ackermann" else ["front"]
        steering = [f"{name}_steer_joint" for name in steering]
        given = f"    rear_wheels_names: {driven}\n    front_wheels_names: {steering}\n"
        return f"steering:\n  ros__parameters:\n    front_steering: true\n{given}"
    sides = "".join(
        f"    {side}_wheel_names: {[name for name in names if side in name]}\n"
        for side in ("left", "right")
    )
    return (
        "controller_manager:\n  ros__parameters:\n    update_rate: 50\n"
        f"diff_cont:\n  ros__parameters:\n{sides}    wheel_separation: {robot.track}\n"
        f"    wheel_radius: {robot.radius}\n"
    )
