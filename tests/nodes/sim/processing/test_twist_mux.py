"""twist_mux: priorities, time-outs and locks."""

from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import Twist, TwistStamped
from std_msgs.msg import Bool

from arjuna_sim.nodes.processing.twist_mux import TwistMuxNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import start

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


def test_sources_of_the_other_type_are_named(
    bench: RosBench, capfd: pytest.CaptureFixture[str]
) -> None:
    start(bench, TwistMuxNode(bench.process, {"topics": {"a": {"topic": "nav_vel"}}}))
    _say(bench, "nav_vel", 1.0)
    bench.advance(6.0)
    text = "'nav_vel' is not heard: it is of geometry_msgs/msg/Twist, not TwistStamped"
    assert capfd.readouterr().err.count(f"{text}; set use_stamped to false") == 1
