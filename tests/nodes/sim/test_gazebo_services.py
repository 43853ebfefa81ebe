"""Gazebo's services answer by simulation_interfaces', each in its own words."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest
from builtin_interfaces.msg import Duration, Time
from gazebo_msgs import srv
from geometry_msgs.msg import Point, Pose, PoseStamped, Vector3, Wrench
from ros_gz_interfaces.msg import Entity, EntityFactory, WorldControl, WorldReset
from simulation_interfaces.msg import EntityState, Resource, Result, SimulationState
from simulation_interfaces.srv import (
    GetEntityState,
    GetSimulatorFeatures,
    SetEntityState,
    SpawnEntity,
)
from std_srvs.srv import Empty

from arjuna_core.ros.context import class_of
from arjuna_core.ros.convert import quaternion
from arjuna_sim.nodes.services.gazebo import GazeboServices
from arjuna_sim.nodes.services.known_entities import KnownEntities
from arjuna_sim.nodes.sim import SimNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_in

CRATE = """<sdf version="1.7"><model name="crate"><link name="l"><inertial><mass>1</mass></inertial>
<collision name="c"><geometry><box><size>0.4 0.4 0.4</size></box></geometry></collision>
</link></model></sdf>"""


@pytest.fixture
def ask(bench: RosBench) -> Any:
    return asking(start_in(bench))


def asking(sim: SimNode) -> Any:
    """Return what calls Gazebo Classic's services of a simulator."""
    (gazebo,) = sim.kept(GazeboServices)

    def call(service: str, /, **fields: Any) -> Any:
        short = service.rpartition("/")[2].title().replace("_", "")
        short = {"ClearJointEfforts": "JointRequest", "ClearLinkWrenches": "LinkRequest"}.get(
            short, short
        )
        answer = gazebo._answer_of(f"/{service}", f"gazebo_msgs/srv/{short}")
        assert answer is not None
        kind = getattr(srv, short)
        return answer(kind.Request(**fields), kind.Response())

    return call


def spawn(ask: Any, name: str, x: float, yaw: float = 0.0, frame: str = "") -> Any:
    request = srv.SpawnEntity.Request()
    request.initial_pose.position.x = x
    request.initial_pose.orientation = quaternion(yaw)
    pose = request.initial_pose
    return ask("spawn_entity", name=name, xml=CRATE, initial_pose=pose, reference_frame=frame)


def test_entities_come_move_and_go(ask: Any) -> None:
    answer = spawn(ask, "", 2.0)
    assert answer.success
    assert answer.status_message == "SpawnEntity: Successfully spawned entity [crate]"
    assert "crate" in ask("get_model_list").model_names
    state = ask("gazebo/get_entity_state", name="crate").state
    state.name, state.pose.position.y = "crate", 1.5
    assert ask("gazebo/set_entity_state", state=state).success
    moved = ask("get_entity_state", name="crate", reference_frame="world")
    assert (moved.state.pose.position.x, moved.state.pose.position.y) == pytest.approx((2.0, 1.5))
    assert moved.header.frame_id == "world"
    assert ask("delete_entity", name="crate").success
    assert "crate" not in ask("get_model_list").model_names


def test_poses_are_relative_to_an_entity_where_it_is_named(ask: Any) -> None:
    assert spawn(ask, "one", 2.0, math.pi / 2).success
    assert spawn(ask, "two", 1.0, frame="one").success
    world = ask("get_entity_state", name="two").state.pose.position
    assert (world.x, world.y) == pytest.approx((2.0, 1.0))
    near = ask("get_entity_state", name="two", reference_frame="one").state.pose.position
    assert (near.x, near.y) == pytest.approx((1.0, 0.0), abs=1e-9)


def test_what_cannot_be_done_fails_with_a_reason(ask: Any) -> None:
    assert spawn(ask, "crate", 2.0).success
    assert "taken" in spawn(ask, "crate", 3.0).status_message
    assert "does not exist" in ask("delete_entity", name="nobody").status_message
    assert not ask("get_entity_state", name="nobody").success
    assert not ask("get_entity_state", name="crate", reference_frame="nobody").success
    assert not ask("set_entity_state").success
    assert not ask("spawn_entity", name="x", xml="<nothing/>").success


def bridged(gazebo: GazeboServices, short: str, /, **fields: Any) -> bool:
    kind = class_of(f"ros_gz_interfaces/srv/{short}")
    return bool(gazebo.bridged[short](kind.Request(**fields), kind.Response()).success)


def test_entities_come_move_and_go_by_a_bridge_s_services(bench: RosBench) -> None:
    sim = start_in(bench)
    (gazebo,) = sim.kept(GazeboServices)
    made = EntityFactory(name="one", sdf=CRATE)
    made.pose.position.x = 2.0
    assert bridged(gazebo, "SpawnEntity", entity_factory=made)
    assert not bridged(gazebo, "SpawnEntity", entity_factory=made)  # the name is taken
    made.allow_renaming = True
    assert bridged(gazebo, "SpawnEntity", entity_factory=made)
    made.pose.position.x = 3.0
    entity = Entity(name="one", type=Entity.MODEL)
    assert bridged(gazebo, "SetEntityPose", entity=entity, pose=made.pose)
    known = {each.name: each for each in KnownEntities(sim.simulator).all()}
    assert {"one", "one_1"} <= known.keys()
    state = KnownEntities(sim.simulator).state(known["one"])
    assert state.pose.position.x == pytest.approx(3.0)
    assert bridged(gazebo, "DeleteEntity", entity=entity)
    assert not bridged(gazebo, "DeleteEntity", entity=entity)


def test_a_world_is_controlled_by_a_bridge_s_service(bench: RosBench) -> None:
    sim = start_in(bench)
    (gazebo,) = sim.kept(GazeboServices)

    def control(**fields: Any) -> bool:
        return bridged(gazebo, "ControlWorld", world_control=WorldControl(**fields))

    assert control(pause=True)
    assert control(pause=True)
    assert sim.state == SimulationState.STATE_PAUSED
    before = sim.simulator.time
    assert control(pause=True, multi_step=3)
    assert sim.simulator.time == pytest.approx(before + 3 * sim.config.tick)
    assert control(pause=True, reset=WorldReset(all=True))
    assert sim.simulator.time == before == 0.0
    assert control()
    assert sim.state == SimulationState.STATE_PLAYING
    assert not control(seed=3)


def test_all_requests_that_wait_are_answered_at_once_but_for_a_flood(bench: RosBench) -> None:
    (gazebo,) = start_in(bench).kept(GazeboServices)
    waiting: list[int] = []
    answer = gazebo._counted(lambda request, response: waiting.pop())

    def spin_once(timeout_sec: float) -> None:
        if waiting:
            answer(None, None)

    gazebo._executor = SimpleNamespace(spin_once=spin_once)
    for count, left in ((7, 0), (60, 10)):
        waiting[:] = range(count)
        gazebo._poll()
        assert len(waiting) == left


def test_gazebo_classic_s_plain_services_hold_and_reset_the_world(bench: RosBench) -> None:
    sim = start_in(bench)
    (gazebo,) = sim.kept(GazeboServices)

    def ask_plainly(name: str) -> None:
        answer = gazebo._answer_of(f"/gazebo/{name}", "std_srvs/srv/Empty")
        assert answer is not None
        answer(Empty.Request(), Empty.Response())

    for name, state in ("pause", SimulationState.STATE_PAUSED), ("unpause", None):
        ask_plainly(f"{name}_physics")
        ask_plainly(f"{name}_physics")
        assert sim.state == (state or SimulationState.STATE_PLAYING)
    run(bench, sim, 3)
    for name, time in ("reset_world", sim.simulator.time), ("reset_simulation", 0.0):
        ask_plainly(name)
        assert sim.simulator.time == time
    assert gazebo._answer_of("/clear", "std_srvs/srv/Empty") is None


def test_only_what_clients_ask_for_is_served_and_once(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    (gazebo,) = start_in(bench).kept(GazeboServices)
    served: list[tuple[str, str]] = []
    kinds = {
        "/spawn_entity": "gazebo_msgs/srv/SpawnEntity",
        "/robot1/get_model_list": "gazebo_msgs/srv/GetModelList",
        "/get_link_state": "gazebo_msgs/srv/GetLinkState",
        "/delete_entity": "other_msgs/srv/DeleteEntity",
    }
    monkeypatch.setattr(gazebo, "_wanted", lambda: set(kinds.items()))
    monkeypatch.setattr(
        gazebo,
        "_serve",
        lambda some: served.extend((kind.__name__, name) for kind, name, _ in some),
    )
    gazebo._look()
    gazebo._look()
    assert served == [("GetModelList", "/robot1/get_model_list"), ("SpawnEntity", "/spawn_entity")]


def test_standard_services_answer_below_gazebos_node_too(bench: RosBench) -> None:
    sim = start_in(bench)
    (gazebo,) = sim.kept(GazeboServices)

    def call(kind: Any, space: str, service: str, /, **fields: Any) -> Any:
        type_name = f"simulation_interfaces/srv/{kind.__name__}"
        answer = gazebo._answer_of(f"{space}/{service}", type_name)
        return answer and answer(kind.Request(**fields), kind.Response())

    assert call(GetSimulatorFeatures, "/gzserver", "get_simulator_features").features.features
    crate = Resource(resource_string=CRATE)
    start = PoseStamped(pose=Pose(position=Point(y=2.0)))
    fields = {"name": "c", "entity_resource": crate, "initial_pose": start}
    spawned = call(SpawnEntity, "/gzserver", "spawn_entity", **fields)
    assert spawned.result.result == Result.RESULT_OK
    state = EntityState()
    state.pose.position.x = 2.0  # neither set_pose nor set_twist: gz sets both
    set_to = call(SetEntityState, "/gzserver", "set_entity_state", entity="c", state=state)
    assert set_to.result.result == Result.RESULT_OK, set_to.result.error_message
    found = call(GetEntityState, "/gzserver", "get_entity_state", entity="c").state
    assert found.pose.position.x == pytest.approx(2.0)
    assert call(GetEntityState, "/other", "get_entity_state", entity="c") is None


def test_links_and_joints_are_pushed_for_a_time(bench: RosBench) -> None:
    sim = start_in(bench)
    ask = asking(sim)
    assert spawn(ask, "crate", 2.0).success
    wrench = Wrench(force=Vector3(z=20.0))
    lasts = Duration(sec=-1)
    assert ask("apply_link_wrench", link_name="crate::l", wrench=wrench, duration=lasts).success
    run(bench, sim, 50)
    height = ask("get_entity_state", name="crate").state.pose.position.z
    assert height == pytest.approx(0.2 + 0.5 * (20.0 - 9.81), abs=0.1)
    ask("clear_link_wrenches", link_name="crate::l")
    run(bench, sim, 150)
    assert ask("get_entity_state", name="crate").state.pose.position.z < 1.0
    lasts = Duration(nanosec=500_000_000)
    start = sim.now + 1.0
    later = Time(sec=int(start), nanosec=int(start % 1.0 * 1e9))
    joint = "front_left_joint"
    answer = ask("apply_joint_effort", joint_name=joint, start_time=later, duration=lasts)
    assert answer.success
    ask("clear_joint_efforts", joint_name=joint)
    answer = ask("apply_joint_effort", joint_name="none", effort=1.0, duration=lasts)
    assert not answer.success
    assert answer.status_message.startswith("joint 'none' does not exist")
    assert ask("clear_joint_efforts", joint_name="none") is not None
