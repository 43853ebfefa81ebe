"""Warnings of topics on which nothing comes."""

from __future__ import annotations

import pytest
from nav_msgs.msg import Odometry

from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.silence import Silence, subscribe_watched
from tests.helpers.ros import RosBench


class Listener(ManagedNode):
    """Hears odometry, where others publish it."""

    DEFAULT_NAME = "listener"

    def configure(self) -> None:
        of = Silence(Odometry, "message", qos.DEFAULT, "set odom_topic", rare=True)
        subscribe_watched(self, "odom", of, lambda _: None)


@pytest.mark.parametrize("after", [0.0, 9.0])
def test_what_others_publish_later_is_found_too(
    bench: RosBench, after: float, capfd: pytest.CaptureFixture[str]
) -> None:
    """A robot that started after the node was not found: it looked once."""
    bench.activated(Listener)
    bench.advance(after)
    assert "no message comes" not in capfd.readouterr().err
    bench.publish(Odometry, "/base/odom", Odometry())
    bench.advance(20.0)
    said = capfd.readouterr().err
    assert said.count("messages are on /base/odom: set odom_topic") == 1
