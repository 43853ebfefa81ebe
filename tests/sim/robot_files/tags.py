"""Tags of which robot files are made."""

from __future__ import annotations


def fixed(parent: str, child: str, xyz: str) -> str:
    """Return a fixed joint, named after its child."""
    return (
        f"<joint name='{child}_joint' type='fixed'><parent link='{parent}'/><child link='{child}'/>"
        f"<origin xyz='{xyz}' rpy='0 0 0'/></joint>"
    )


def hinged(parent: str, child: str, xyz: str, axis: str) -> str:
    """Return a joint that turns freely, named after its child."""
    return (
        f"<joint name='{child}_joint' type='continuous'><parent link='{parent}'/>"
        f"<child link='{child}'/><origin xyz='{xyz}'/><axis xyz='{axis}'/></joint>"
    )


def sphere(radius: float) -> str:
    """Return a sphere's `<geometry>`."""
    return f"<geometry><sphere radius='{radius}'/></geometry>"


def box_inertia(mass: float, x: float = 0.05, y: float = 0.05, z: float = 0.05) -> str:
    """Return a box's `<inertia>`."""
    a, b, c = (mass / 12.0 * s for s in (y * y + z * z, x * x + z * z, x * x + y * y))
    return f"<inertia ixx='{a}' ixy='0' ixz='0' iyy='{b}' iyz='0' izz='{c}'/>"


def plugin(file: str, inside: str = "") -> str:
    """Return a plugin's tag."""
    return f"<gazebo><plugin filename='{file}' name='drive'>{inside}</plugin></gazebo>"


def sides(*ends: str) -> str:
    """Return the tags by which a plugin names the wheels of both sides, at ends of a robot."""
    return "".join(
        f"<{side}_joint>{end}_{side}_wheel_joint</{side}_joint>"
        for end in ends
        for side in ("left", "right")
    )


def transmission(joint: str) -> str:
    """Return the tag of ROS 1 that hands a joint to a velocity controller."""
    interface = "hardware_interface/VelocityJointInterface"
    return (
        f"<transmission name='{joint}_trans'><type>transmission_interface/SimpleTransmission</type>"
        f"<joint name='{joint}'><hardwareInterface>{interface}</hardwareInterface></joint>"
        f"<actuator name='{joint}_motor'><mechanicalReduction>1</mechanicalReduction></actuator>"
        "</transmission>"
    )
