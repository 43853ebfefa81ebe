"""Copies of messages, and their bytes: the same as those that go through rclpy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.serialization import deserialize_message, serialize_message
from tf2_msgs.msg import TFMessage

from arjuna_core.ros.local.cdr import to_cdr
from arjuna_core.ros.messages import copier, fresh
from tests.helpers.messages import fill
from tests.nodes.core.test_reading import TYPES, parts

pytestmark = pytest.mark.ros


@pytest.fixture
def filler(monkeypatch: pytest.MonkeyPatch) -> fill.Filler:
    monkeypatch.setattr(fill, "LENGTHS", (0, 1, 7, 30))
    monkeypatch.setattr(fill, "ZIGZAG", 50)
    monkeypatch.setattr(fill, "_MOST", 1000)
    return fill.Filler(np.random.default_rng(4))


@pytest.mark.parametrize("cls", TYPES, ids=lambda cls: str(cls.__name__))
def test_a_copy_is_what_would_have_come_through_the_middleware(
    cls: Any, filler: fill.Filler
) -> None:
    for message in (cls(), *(filler.message(cls) for _ in range(8))):
        through = deserialize_message(serialize_message(message), cls)
        assert parts(copier(cls)(message)) == parts(through)


@pytest.mark.parametrize("cls", TYPES, ids=lambda cls: str(cls.__name__))
def test_its_bytes_are_those_of_the_middleware_but_for_the_gaps(
    cls: Any, filler: fill.Filler
) -> None:
    for message in (cls(), *(filler.message(cls) for _ in range(8))):
        theirs, ours = serialize_message(message), to_cdr(message)
        assert parts(deserialize_message(ours, cls)) == parts(deserialize_message(theirs, cls))
        assert len(ours) <= len(theirs)  # rclpy counts gaps before what is not there
        assert all(a == b for a, b in zip(theirs, ours, strict=False) if b != 0)
        assert to_cdr(message) == ours


@pytest.mark.parametrize("cls", [Odometry, OccupancyGrid, TFMessage])
def test_a_fresh_message_is_a_default_one_of_its_own(cls: Any) -> None:
    first = fresh(cls)
    assert first == cls()
    if cls is Odometry:
        first.pose.covariance[0] = first.twist.twist.linear.x = 1.0
    elif cls is OccupancyGrid:
        first.data.append(1)
    else:
        first.transforms.append(None)
    assert fresh(cls) == cls()
