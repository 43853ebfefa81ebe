"""Gazebo's topics of where entities are."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from gazebo_msgs.msg import ModelStates
from geometry_msgs.msg import Pose, PoseArray, PoseStamped, Transform, TransformStamped
from tf2_msgs.msg import TFMessage

from arjuna_sim.nodes.services.entity_topics import EntityTopics, messages_of
from arjuna_sim.nodes.services.known_entities import KnownEntities
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, spawn, start_in, start_sim
from tests.sim import drive_cases as cases

PLUGIN = (
    "<gazebo><plugin filename='gz-sim-pose-publisher-system'"
    " name='gz::sim::systems::PosePublisher'>{}</plugin></gazebo>"
)
OWN = "<publish_link_pose>false</publish_link_pose><publish_model_pose>true</publish_model_pose>"
NESTED = "<publish_nested_model_pose>true</publish_nested_model_pose>"


def topics_of(sim: Any) -> EntityTopics:
    return EntityTopics(sim, KnownEntities(sim.simulator))


def test_all_models_have_a_state(bench: RosBench) -> None:
    message = topics_of(start_in(bench)).states()
    assert len(message.name) == len(message.pose) == len(message.twist) > 0
    assert message.header.frame_id == "world"


def test_all_that_moves_stands_before_what_does_not(bench: RosBench) -> None:
    sim = start_in(bench, "arjuna_room.world")
    spawn(bench, "crate", "box:0.4,0.4,0.4?mass=2", x=0.8)
    topics = topics_of(sim)
    moving, all_ = (
        [T.child_frame_id for T in topics.poses(f"/world/any/{kind}")]
        for kind in ("dynamic_pose/info", "pose/info")
    )
    robot = moving[0]
    assert moving[1] == f"{robot}/base_footprint"
    assert {f"{robot}/front_left_wheel", "crate"} <= set(moving)
    assert set(moving) < set(all_)
    assert topics.poses("/world/any/other") == []


@pytest.mark.parametrize(
    ("tags", "says"),
    [
        (None, ["r"]),
        (OWN, ["r"]),
        ("", ["r/base", "r/front_left_wheel"]),
        (NESTED, ["r", "r/base", "r/front_left_wheel"]),
    ],
)
def test_a_robot_s_poses_are_those_of_its_pose_publisher(
    tags: str | None, says: list[str], bench: RosBench, tmp_path: Path
) -> None:
    path = cases.mecanum().write(tmp_path)
    tag = "" if tags is None else PLUGIN.format(tags)
    path.write_text(path.read_text().replace("</robot>", f"{tag}</robot>"))
    found = topics_of(start_sim(bench, robot=str(path))).poses("/model/r/pose")
    assert [T.child_frame_id for T in found][: len(says)] == says
    assert len(found) == len(says) + (3 if "r/base" in says else 0)
    assert {T.header.frame_id for T in found} <= {"world", "r"}


def test_poses_are_messages_of_the_bridge_s_type(bench: RosBench) -> None:
    found = topics_of(start_in(bench)).poses("/world/any/pose/info")
    assert len(found) > 1
    for kind, count in (
        (TFMessage, 1),
        (PoseArray, 1),
        *((one, len(found)) for one in (Pose, PoseStamped, Transform, TransformStamped)),
    ):
        messages = messages_of(kind, found)
        assert [type(message) for message in messages] == [kind] * count
        assert messages_of(kind, []) == ([TFMessage()] if kind is TFMessage else [])


def test_they_are_there_once_somebody_listens() -> None:
    with closing(RosBench(transport="dds")) as bench:
        sim = start_in(bench)
        run(bench, sim, 50)
        assert bench.node.count_publishers("/model_states") == 0
        states = bench.collect(ModelStates, "/model_states")
        poses = bench.collect(PoseStamped, "/world/w/model/robot/pose")
        run(bench, sim, 100)
        assert len(states) >= 5
        assert len(poses) >= 25
