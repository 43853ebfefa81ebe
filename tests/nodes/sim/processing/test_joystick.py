"""Joystick and twist_mux: who commands the robot."""

from __future__ import annotations

import os
import struct
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from sensor_msgs.msg import Joy
from std_msgs.msg import Bool

from arjuna_sim.nodes.processing.joystick import JoyNode, TeleopTwistJoyNode
from arjuna_sim.nodes.processing.twist_mux import TwistMuxNode
from arjuna_sim.processing.joystick import Gamepad, device_path
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import start

BUTTON, AXIS, INITIAL = 1, 2, 0x80


def _event(kind: int, number: int, value: int) -> bytes:
    return struct.pack("<IhBB", 0, value, kind, number)


def test_sticks_are_positive_forward_and_rest_in_the_dead_zone() -> None:
    pad = Gamepad(deadzone=0.1)
    assert pad.take(_event(AXIS | INITIAL, 1, -32768) + _event(BUTTON | INITIAL, 2, 0))
    assert pad.axes == pytest.approx([0.0, 1.0])
    assert pad.buttons == [0, 0, 0]
    pad.take(_event(AXIS, 0, round(32767 * 0.55)) + _event(AXIS, 1, round(32767 * 0.099)))
    assert pad.axes == pytest.approx([-0.5, 0.0], abs=1e-4)
    half = _event(BUTTON, 0, 1)
    assert not pad.take(half[:3])
    assert pad.take(half[3:])
    assert pad.buttons[0] == 1


def test_sticky_buttons_stay_until_they_are_pressed_again() -> None:
    pad = Gamepad(sticky_buttons=True)
    pressed = []
    for value in (1, 0, 1, 0):
        pad.take(_event(BUTTON, 0, value))
        pressed.append(pad.buttons[0])
    assert pressed == [1, 1, 0, 0]


def test_a_device_is_found_by_its_name(tmp_path: Path) -> None:
    for number, name in enumerate(("Wheel", "Pad")):
        (tmp_path / f"js{number}" / "device").mkdir(parents=True)
        (tmp_path / f"js{number}" / "device" / "name").write_text(f"{name}\n")
    assert device_path(0, "Pad", tmp_path) == "/dev/input/js1"
    assert device_path(3, "", tmp_path) == "/dev/input/js3"


@pytest.fixture
def device(tmp_path: Path) -> Any:
    """A device's path, a pipe in the tests, and what sends events by it."""
    path = tmp_path / "js0"
    os.mkfifo(path)
    holder = os.open(path, os.O_RDWR)
    yield path, lambda *events: os.write(holder, b"".join(events))
    os.close(holder)


def test_a_pad_is_published_on_changes_and_again(bench: RosBench, device: Any) -> None:
    path, send = device
    joys = bench.collect(Joy, "joy")
    start(bench, JoyNode(bench.process, {"dev": str(path), "autorepeat_rate": 5.0}))
    send(_event(AXIS | INITIAL, 0, 0), _event(BUTTON | INITIAL, 0, 0))
    bench.advance(0.04)
    assert len(joys) == 1
    assert joys[0].header.frame_id == "joy"
    send(_event(BUTTON, 0, 1))
    bench.advance(0.02)
    assert list(joys[-1].buttons) == [1]
    bench.advance(1.0)
    assert len(joys) == 2 + 5


def test_a_device_may_be_plugged_in_later(bench: RosBench, tmp_path: Path) -> None:
    joys = bench.collect(Joy, "joy")
    start(bench, JoyNode(bench.process, {"dev": str(tmp_path / "js9")}))
    bench.advance(0.2)
    assert not joys
    (tmp_path / "js9").write_bytes(_event(AXIS, 2, 32767))
    bench.advance(0.04)
    assert list(joys[0].axes) == pytest.approx([0.0, 0.0, -1.0])


PS3 = {
    "axis_linear": {"x": 1, "y": 0},
    "scale_linear": {"x": 0.7, "y": 0.3},
    "scale_linear_turbo": {"x": 1.5},
    "axis_angular": {"yaw": 2},
    "scale_angular": {"yaw": 0.4},
    "enable_button": 1,
    "enable_turbo_button": 2,
}


def _driven(bench: RosBench, *presses: int, **values: Any) -> list[Any]:
    """Return the velocities of one message a press: of no button, of one, ..."""
    stamped = values.get("publish_stamped_twist", False)
    sent = bench.collect(TwistStamped if stamped else Twist, "cmd_vel")
    start(bench, TeleopTwistJoyNode(bench.process, {**PS3, **values}))
    for pressed in presses:
        buttons = [int(number == pressed) for number in range(3)]
        bench.publish(Joy, "joy", Joy(axes=[0.5, -1.0, 1.0], buttons=buttons))
    return sent


def test_a_velocity_is_sent_while_a_button_is_held_and_one_0_after(bench: RosBench) -> None:
    sent = _driven(bench, -1, 1, 2, -1, -1)
    assert [one.linear.x for one in sent] == pytest.approx([0.0, -0.7, -1.5, 0.0])
    assert sent[1].linear.y == pytest.approx(0.15)
    assert [one.angular.z for one in sent] == pytest.approx([0.0, 0.4, 1.0, 0.0])


def test_reverse_can_be_inverted_and_no_button_be_needed(bench: RosBench) -> None:
    given = {"inverted_reverse": True, "require_enable_button": False}
    (sent,) = _driven(bench, -1, publish_stamped_twist=True, frame="base", **given)
    assert sent.twist.angular.z == pytest.approx(-0.4)
    assert sent.header.frame_id == "base"


def test_axes_that_a_pad_lacks_are_0(bench: RosBench) -> None:
    (sent,) = _driven(bench, 1, axis_angular={"yaw": 9})
    assert sent.angular.z == 0.0


VALUES: dict[str, Any] = {
    "use_stamped": False,
    "topics": {
        "navigation": {"topic": "nav_vel", "timeout": 0.5, "priority": 10},
        "joystick": {"topic": "joy_vel", "timeout": 0.5, "priority": 100},
    },
    "locks": {
        "pause": {"topic": "pause_navigation", "timeout": 0.0, "priority": 100},
        "watchdog": {"topic": "alive", "timeout": 0.3, "priority": 50},
    },
}


def _say(bench: RosBench, topic: str, speed: float) -> None:
    message = Twist()
    message.linear.x = speed
    bench.publish(Twist, topic, message)


def test_the_highest_priority_passes_until_its_source_is_silent(bench: RosBench) -> None:
    out = bench.collect(Twist, "cmd_vel_out")
    start(bench, TwistMuxNode(bench.process, {**VALUES, "locks": {}}))
    _say(bench, "nav_vel", 1.0)
    _say(bench, "joy_vel", 2.0)
    _say(bench, "nav_vel", 3.0)
    bench.advance(0.48)
    _say(bench, "nav_vel", 4.0)
    bench.advance(0.06)
    _say(bench, "nav_vel", 5.0)
    assert [one.linear.x for one in out] == [1.0, 2.0, 5.0]


def test_a_lock_masks_lower_priorities_while_it_is_on(bench: RosBench) -> None:
    out = bench.collect(Twist, "cmd_vel_out")
    values = {**VALUES, "locks": {"pause": VALUES["locks"]["pause"] | {"priority": 50}}}
    start(bench, TwistMuxNode(bench.process, values))
    bench.publish(Bool, "pause_navigation", Bool(data=True))
    _say(bench, "nav_vel", 1.0)
    _say(bench, "joy_vel", 2.0)
    bench.advance(1.0)
    bench.publish(Bool, "pause_navigation", Bool(data=False))
    _say(bench, "nav_vel", 3.0)
    assert [one.linear.x for one in out] == [2.0, 3.0]


def test_a_lock_with_a_timeout_locks_while_it_is_silent(bench: RosBench) -> None:
    out = bench.collect(Twist, "cmd_vel_out")
    start(bench, TwistMuxNode(bench.process, VALUES))
    _say(bench, "nav_vel", 1.0)
    bench.publish(Bool, "alive", Bool(data=False))
    _say(bench, "nav_vel", 2.0)
    bench.advance(0.4)
    _say(bench, "nav_vel", 3.0)
    assert [one.linear.x for one in out] == [2.0]


def test_commands_may_be_stamped_and_0_never_passes(bench: RosBench) -> None:
    out = bench.collect(TwistStamped, "cmd_vel_out")
    topics = {"a": {"topic": "a", "priority": 1}, "b": {"topic": "b", "priority": 0}}
    start(bench, TwistMuxNode(bench.process, {"topics": topics}))
    bench.publish(TwistStamped, "b", TwistStamped())
    assert not out
    bench.publish(TwistStamped, "a", TwistStamped())
    assert len(out) == 1


@pytest.mark.parametrize("stamped", [False, True])
def test_a_source_of_the_other_type_passes_as_the_output_s(bench: RosBench, stamped: bool) -> None:
    """Files of Humble name no type: nothing passed, for Jazzy's default is TwistStamped."""
    sent, kind = (Twist, TwistStamped) if stamped else (TwistStamped, Twist)
    out, message = bench.collect(kind, "cmd_vel_out"), sent()
    (message if stamped else message.twist).linear.x = 1.0
    topics = {"a": {"topic": "nav_vel", "priority": 1}}
    start(bench, TwistMuxNode(bench.process, {"use_stamped": stamped, "topics": topics}))
    for _ in range(4):
        bench.publish(sent, "nav_vel", message)
        bench.advance(2.0)
    assert (out[-1].twist if stamped else out[-1]).linear.x == 1.0
