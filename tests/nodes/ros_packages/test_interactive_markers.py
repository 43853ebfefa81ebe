"""interactive_markers as scripts use them: served, dragged, with menus."""

from __future__ import annotations

from typing import Any

import pytest
from geometry_msgs.msg import Point, Pose
from interactive_markers import InteractiveMarkerServer, MenuHandler
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile
from visualization_msgs.msg import (
    InteractiveMarker,
    InteractiveMarkerFeedback,
    InteractiveMarkerUpdate,
)
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.ros.convert import header
from tests.helpers.ros import RosBench

MOVED, CHOSEN = InteractiveMarkerFeedback.POSE_UPDATE, InteractiveMarkerFeedback.MENU_SELECT


class _Drag:
    """A server of one marker, and the client that drags it."""

    def __init__(self, bench: RosBench) -> None:
        self.bench, self.updates, self.calls = bench, list[Any](), list[Any]()
        sim_time = Parameter("use_sim_time", value=True)
        node = bench.process.make_node("drag", parameter_overrides=[sim_time])
        self.server = InteractiveMarkerServer(node, "knob")
        bench.node.create_subscription(
            InteractiveMarkerUpdate, "/knob/update", self.updates.append, QoSProfile(depth=9)
        )
        marker = InteractiveMarker(header=header("base_link", 0.0), name="k")
        self.server.insert(marker, feedback_callback=self.calls.append)
        bench.advance()

    def apply(self) -> Any:
        """Return what clients get of the changes."""
        self.server.applyChanges()
        self.bench.advance()
        return self.updates[-1]

    def feedback(self, event: int, x: float = 0.0, client: str = "rviz", menu: int = 0) -> None:
        """Send what a client sends when its marker is dragged or its menu is used."""
        message = InteractiveMarkerFeedback(client_id=client, marker_name="k", event_type=event)
        message.pose, message.menu_entry_id = Pose(position=Point(x=x)), menu
        self.bench.publish(InteractiveMarkerFeedback, "/knob/feedback", message)


@pytest.fixture
def drag(bench: RosBench) -> _Drag:
    return _Drag(bench)


def test_a_marker_is_there_for_clients_once_changes_are_applied(drag: _Drag) -> None:
    assert drag.updates == []
    update = drag.apply()
    assert (update.seq_num, [each.name for each in update.markers]) == (1, ["k"])
    drag.server.applyChanges()
    drag.bench.advance()
    assert len(drag.updates) == 1  # nothing has changed
    client = drag.bench.node.create_client(GetInteractiveMarkers, "/knob/get_interactive_markers")
    answer = client.call_async(GetInteractiveMarkers.Request())
    drag.bench.advance()
    assert [each.name for each in answer.result().markers] == ["k"]


def test_a_dragged_marker_calls_back_and_moves_in_its_own_frame(drag: _Drag) -> None:
    drag.apply()
    drag.feedback(MOVED, x=0.5)
    assert [each.pose.position.x for each in drag.calls] == [0.5]
    [moved] = drag.apply().poses
    assert (moved.name, moved.header.frame_id, moved.pose.position.x) == ("k", "base_link", 0.5)
    assert drag.server.setPose("k", Pose())  # as a script does when the mouse is released
    assert drag.apply().poses[0].pose.position.x == 0.0
    assert not drag.server.setPose("other", Pose())


def test_of_two_clients_one_drags_for_a_second(drag: _Drag) -> None:
    drag.apply()
    drag.feedback(MOVED, x=0.5)
    drag.feedback(MOVED, x=0.9, client="foxglove")
    assert len(drag.calls) == 1
    drag.bench.advance(1.1)
    drag.feedback(MOVED, x=0.9, client="foxglove")
    assert len(drag.calls) == 2


def test_an_erased_marker_is_gone(drag: _Drag) -> None:
    drag.apply()
    assert drag.server.erase("k")
    assert not drag.server.erase("other")
    assert drag.server.get("k") is None
    assert not drag.server.setPose("k", Pose())
    assert drag.apply().erases == ["k"]
    drag.feedback(MOVED)
    assert drag.calls == []


def test_a_menu_lists_its_entries_and_calls_the_chosen_one(drag: _Drag) -> None:
    menu, chosen = MenuHandler(), list[Any]()
    speed = menu.insert("Speed")
    fast = menu.insert("Fast", parent=speed, callback=chosen.append)
    assert fast is not None
    assert menu.insert("Lost", parent=9) is None
    menu.setCheckState(fast, MenuHandler.UNCHECKED)
    assert menu.apply(drag.server, "k")
    assert not menu.apply(drag.server, "other")
    entries = [(e.id, e.parent_id, e.title) for e in drag.apply().markers[0].menu_entries]
    assert entries == [(1, 0, "Speed"), (2, 1, "[ ] Fast")]
    drag.feedback(CHOSEN, menu=fast)
    assert len(chosen) == 1
    assert drag.calls == []
    menu.setCheckState(fast, MenuHandler.CHECKED)
    assert menu.reApply(drag.server)
    assert drag.apply().markers[0].menu_entries[1].title == "[x] Fast"
