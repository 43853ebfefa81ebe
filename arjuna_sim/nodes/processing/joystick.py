"""joy_node and teleop_node: a gamepad as messages, and these as velocities."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import Joy

from arjuna_core.config import fixed, param, share_param
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.processing.joystick import Device, Gamepad, deflected, device_path

_POLL = 0.01  # [s] from one look at the device to the next: the period of the system's clock


@dataclass(frozen=True)
class JoyConfig:
    """Parameters of `joy_node`."""

    device_id: int = fixed(0, "Number of the gamepad.", minimum=0, maximum=255)
    device_name: str = fixed("", "Its name; empty for its number.")
    dev: str = param("", "Its device, as /dev/input/js0; empty for name or number.", path=True)
    deadzone: float = share_param(0.05, "Share of a stick's range that is its middle.")
    autorepeat_rate: float = param(
        20.0, "Rate of messages without a change; 0 for none.", unit="Hz", minimum=0.0, maximum=1000
    )
    sticky_buttons: bool = fixed(False, "Whether a press toggles a button.")
    coalesce_interval_ms: int = fixed(
        1, "Time within which changes come as one message.", unit="ms", minimum=0
    )


class JoyNode(ManagedNode):
    """Publishes a gamepad on `joy`, read by the kernel's joystick interface."""

    Config = JoyConfig
    DEFAULT_NAME = "joy_node"

    def configure(self) -> None:
        """Create the topic and look for the device."""
        config: JoyConfig = self.config
        path = config.dev or device_path(config.device_id, config.device_name)
        self._device, self._was_open = Device(path), False
        self._pad = Gamepad(config.deadzone, config.sticky_buttons)
        self._published = 0.0
        self._out = self.publisher(Joy, "joy", qos.DEFAULT)
        self.every(max(_POLL, config.coalesce_interval_ms / 1000.0), self._poll)
        self._poll()
        if not self._device.is_open:
            self.get_logger().warning(f"there is no gamepad at {path}; it is looked for again")

    def on_config(self, config: JoyConfig) -> None:
        """Take a new dead zone."""
        self._pad.deadzone = config.deadzone

    def cleanup(self) -> None:
        """Close the device."""
        self._device.close()

    def _poll(self) -> None:
        changed = self._pad.take(self._device.read())
        if self._device.is_open != self._was_open:
            self._was_open = self._device.is_open
            state = "opened" if self._was_open else "lost"
            self.get_logger().info(f"{state} the gamepad {self._device.path}")
            if not self._was_open:  # nothing stays pressed that nobody holds
                self._pad.axes.clear()
                self._pad.buttons.clear()
        rate = self.config.autorepeat_rate
        repeats = rate > 0.0 and self.now - self._published >= 1.0 / rate - 1e-9
        if self.active and self._was_open and (changed or repeats):
            self._published = self.now
            message = Joy(header=header("joy", self.now), axes=self._pad.axes)
            message.buttons = self._pad.buttons
            self._out.publish(message)


def _axis(default: int = -1) -> Any:
    return param(default, "Axis of the gamepad; -1 for none.", minimum=-1, maximum=255)


def _scale(default: float, unit: str) -> Any:
    return param(default, "Velocity of the full deflection.", unit=unit)


@dataclass(frozen=True)
class LinearAxes:
    """The axes of linear velocity."""

    x: int = _axis(5)
    y: int = _axis()
    z: int = _axis()


@dataclass(frozen=True)
class AngularAxes:
    """The axes of turn rates."""

    yaw: int = _axis(2)
    pitch: int = _axis()
    roll: int = _axis()


@dataclass(frozen=True)
class LinearScale:
    """Linear velocities of full deflections."""

    x: float = _scale(0.5, "m/s")
    y: float = _scale(0.0, "m/s")
    z: float = _scale(0.0, "m/s")


@dataclass(frozen=True)
class AngularScale:
    """Turn rates of full deflections."""

    yaw: float = _scale(0.5, "rad/s")
    pitch: float = _scale(0.0, "rad/s")
    roll: float = _scale(0.0, "rad/s")


@dataclass(frozen=True)
class TeleopTwistJoyConfig:
    """Parameters of `teleop_twist_joy_node`."""

    require_enable_button: bool = param(True, "Whether a button must be held to drive.")
    enable_button: int = param(5, "That button.", minimum=-1, maximum=255)
    enable_turbo_button: int = param(
        -1, "Button for the turbo's velocities; -1 for none.", minimum=-1, maximum=255
    )
    inverted_reverse: bool = param(False, "Whether the turn is negated when driving backward.")
    publish_stamped_twist: bool = fixed(False, "Whether TwistStamped is published.")
    frame: str = fixed("teleop_twist_joy", "Frame of TwistStamped.")
    axis_linear: LinearAxes = field(default_factory=LinearAxes)
    axis_angular: AngularAxes = field(default_factory=AngularAxes)
    scale_linear: LinearScale = field(default_factory=LinearScale)
    scale_angular: AngularScale = field(default_factory=AngularScale)
    scale_linear_turbo: LinearScale = field(default_factory=lambda: LinearScale(x=1.0))
    scale_angular_turbo: AngularScale = field(default_factory=lambda: AngularScale(yaw=1.0))


class TeleopTwistJoyNode(ManagedNode):
    """Publishes `cmd_vel` from `joy` while a button is held; one 0 when it is released."""

    Config = TeleopTwistJoyConfig
    DEFAULT_NAME = "teleop_twist_joy_node"

    def configure(self) -> None:
        """Create the topics."""
        self._stopped = False
        kind = TwistStamped if self.config.publish_stamped_twist else Twist
        self._out = self.publisher(kind, "cmd_vel", qos.DEFAULT)
        self.subscribe(Joy, "joy", self._on_joy, qos.DEFAULT)

    def _on_joy(self, message: Any) -> None:
        config: TeleopTwistJoyConfig = self.config

        def held(button: int) -> bool:
            return 0 <= button < len(message.buttons) and bool(message.buttons[button])

        if held(config.enable_turbo_button):
            self._publish(message.axes, config.scale_linear_turbo, config.scale_angular_turbo)
        elif not config.require_enable_button or held(config.enable_button):
            self._publish(message.axes, config.scale_linear, config.scale_angular)
        elif not self._stopped:
            self._send(Twist())
            self._stopped = True

    def _publish(self, axes: Any, linear: LinearScale, angular: AngularScale) -> None:
        config, twist = self.config, Twist()
        for name in ("x", "y", "z"):
            axis = getattr(config.axis_linear, name)
            setattr(twist.linear, name, deflected(axes, axis, getattr(linear, name)))
        for name, part in (("yaw", "z"), ("pitch", "y"), ("roll", "x")):
            axis = getattr(config.axis_angular, name)
            setattr(twist.angular, part, deflected(axes, axis, getattr(angular, name)))
        if config.inverted_reverse and twist.linear.x < 0.0:
            twist.angular.z = -twist.angular.z
        self._send(twist)
        self._stopped = False

    def _send(self, twist: Twist) -> None:
        if self.config.publish_stamped_twist:
            twist = TwistStamped(header=header(self.config.frame, self.now), twist=twist)
        self._out.publish(twist)
