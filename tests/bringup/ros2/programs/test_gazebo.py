"""Gazebo's programs: a world that waits for its robot, and what spawns it there."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from ament_index_python import get_package_prefix
from simulation_interfaces.msg import Result
from simulation_interfaces.srv import SpawnEntity

from arjuna_core.files.shipped import shipped_file
from bringup.client.simulator import SimulatorError
from bringup.ros2.errors import Ros2Error
from bringup.ros2.prefix import add_prefix
from bringup.ros2.programs import gazebo
from bringup.ros2.verbs.forward import PROGRAMS
from tests.sim.robot_worlds import Held, write

pytestmark = pytest.mark.ros
BURGER = shipped_file("urdf/burger.urdf")
_BOX = '<sdf version="1.7"><model name="b"><static>true</static><link name="l"/></model></sdf>'


@pytest.mark.system
@pytest.mark.timeout(200)
def test_robots_of_one_launch_file_drive_each_in_its_namespace(tmp_path: Path) -> None:
    (tmp_path / "two.launch.py").write_text(_TWO.format(burger=BURGER))
    environment = {**os.environ, "ROS_DOMAIN_ID": "93", "HOME": str(tmp_path)}
    words = [sys.executable, "-m", "bringup.ros2.main", "launch", "two.launch.py"]
    log = tmp_path / "log"
    with log.open("wb") as output:
        launched = subprocess.Popen(
            words, stdout=output, stderr=output, cwd=tmp_path, env=environment
        )
    try:
        asked = subprocess.run(
            [sys.executable, "-c", _DRIVE],
            capture_output=True,
            text=True,
            env=environment,
            timeout=180,
            check=False,
        )
        assert asked.stdout.split()[-3:] == ["stayed", "drove", "/r2/odom"], (
            asked.stdout + asked.stderr + log.read_text()
        )
    finally:
        launched.send_signal(signal.SIGINT)
        assert launched.wait(60) == 0
    said = log.read_text()
    assert "spawned r1" in said
    assert "has died" not in said


_TWO = """
from launch import LaunchDescription
from launch.actions import ExecuteProcess, GroupAction
from launch_ros.actions import Node, PushROSNamespace

def generate_launch_description():
    found = [ExecuteProcess(cmd=['gz', 'sim', '-r', '-s', 'empty.world'], output='screen')]
    create = ['-name', 'r1', '-file', '{burger}', '-y', '0.5']
    named = {{'name': 'r2', 'file': '{burger}', 'x': 1.5, 'y': 0.5}}
    for name, given in (('r1', {{'arguments': create}}), ('r2', {{'parameters': [named]}})):
        spawn = Node(package='ros_gz_sim', executable='create', output='screen', **given)
        found.append(GroupAction([PushROSNamespace(name), spawn]))
    return LaunchDescription(found)
"""
_DRIVE = """
from contextlib import closing
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from bringup.client.simulator import SimulatorClient
with closing(SimulatorClient(120.0)) as client:
    node, heard = client.client, {}
    for name in ("r1", "r2"):
        topic = f"/{name}/odom"
        node.create_subscription(Odometry, topic, lambda m, n=name: heard.update({n: m}), 10)
    client.run_until(lambda: len(heard) == 2, 120.0, "both robots' odometry")
    out = node.create_publisher(Twist, "/r2/cmd_vel", 10)
    command = Twist()
    command.linear.x = 0.2
    node.create_timer(0.1, lambda: out.publish(command))
    def x(name):
        return heard[name].pose.pose.position.x
    client.run_until(lambda: x("r2") > 0.2, 60.0, "the second robot to drive")
    print("stayed" if abs(x("r1")) < 0.01 else "moved", "drove")
    topics = dict(node.get_topic_names_and_types())
    print(*(topic for topic in ("/odom", "/r2/odom") if topic in topics))
"""


def test_only_a_robot_is_waited_for(tmp_path: Path) -> None:
    (tmp_path / "box.sdf").write_text(_BOX)
    assert gazebo.unfit(BURGER) == ""
    assert gazebo.unfit(tmp_path / "box.sdf")
    assert "no.urdf" in gazebo.unfit(tmp_path / "no.urdf")


@pytest.mark.parametrize(
    ("own", "topic", "controls", "space"),
    [
        ("", "robot_description", "", ""),
        ("/a", "robot_description", "", "a"),
        ("/a", "/b/robot_description", "", "b"),
        ("/a", "/robot_description", "", "a"),
        ("", "/b/robot_description", "", ""),
        ("", "/b/robot_description", "/b", "b"),
        ("", "b/robot_description", "b", "b"),
        ("", "/b/robot_description", "/c", ""),
        ("/a", "", "/b", "a"),
    ],
)
def test_a_robot_is_in_the_namespace_of_its_controllers(
    own: str, topic: str, controls: str, space: str
) -> None:
    text = f"<plugin><ros><namespace>{controls}</namespace></ros></plugin>"
    assert gazebo.space_of(own, topic, text) == space


@pytest.mark.parametrize(
    ("words", "world"),
    [
        ("-r -s /tmp/playground.sdf", "/tmp/playground.sdf"),
        ("-r -s -v4 shapes.sdf", "shapes.sdf"),
        ("-s libgazebo_ros_init.so -s libgazebo_ros_factory.so my.world", "my.world"),
        ("--verbose -s libgazebo_ros_init.so", "empty.world"),
        ("house.world --ros-args --params-file gazebo.yaml", "house.world"),
    ],
)
def test_the_world_is_the_word_that_names_one(words: str, world: str) -> None:
    assert gazebo.named_world(words.split()) == world


def test_a_question_to_gazebo_itself_starts_no_world() -> None:
    with pytest.raises(Ros2Error, match="'gz fuel' asks Gazebo itself, which is not here"):
        gazebo.serve(["fuel", "list", "-t", "model"])


@pytest.mark.parametrize(("launched", "patience"), [("1 /r1/robot_state_publisher", 60), ("1", 8)])
def test_who_is_launched_to_describe_a_robot_is_waited_for(
    launched: str, patience: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    waited: list[float] = []
    monkeypatch.setenv("ARJUNA_LAUNCHED", launched)
    graph = SimpleNamespace(count_publishers=lambda topic: 0)
    until = lambda done, patience, required: waited.append(patience)  # noqa: E731
    client: Any = SimpleNamespace(client=graph, run_until=until)
    gazebo.await_description(client, "/r1/robot_")
    assert waited == [patience]


@pytest.mark.parametrize(
    ("topic", "describer", "space"),
    [("/r1/scan", "r1/", "/r1"), ("/r1/scan", "", ""), ("scan", "r1/", "")],
)
def test_a_robot_lives_where_its_file_s_topics_and_its_describer_are(
    topic: str, describer: str, space: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "r1.sdf"
    file.write_text(f"<sdf><model name='r1'><topic>{topic}</topic></model></sdf>")
    asked: list[Any] = []

    def ask(kind: Any, name: str, request: Any) -> Any:
        asked.append(request)
        return SimpleNamespace(entity_name=request.name)

    described = f"/{describer}robot_description"
    graph = SimpleNamespace(count_publishers=lambda topic: int(topic == described))
    until = lambda done, patience, required: done()  # noqa: E731
    client = SimpleNamespace(client=graph, run_until=until, ask=ask, close=lambda: None)
    monkeypatch.setattr(gazebo, "SimulatorClient", lambda *given: client)
    monkeypatch.setenv("ARJUNA_LAUNCHED", "1")
    gazebo.create(["-file", str(file), "-name", "r1"])
    assert [request.entity_namespace for request in asked] == [space]


def test_gazebo_s_window_is_asked_in_vain(capsys: pytest.CaptureFixture[str]) -> None:
    gazebo.serve(["service", "-s", "/gui/move_to/pose", "--req", "pose: {position: {x: -0.5}}"])
    assert "'arjuna view' shows the world" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "run"),
    [(["sim", "-g", "-v", "2"], gazebo.serve), ([], PROGRAMS["gazebo_ros", "gzclient"])],
)
def test_gazebos_window_stays_open(
    monkeypatch: pytest.MonkeyPatch, words: list[str], run: Any
) -> None:
    held = list[bool]()
    monkeypatch.setattr(signal, "pause", lambda: held.append(True))
    run(words)
    assert held, "launch files end all with it"


@pytest.mark.parametrize("package", ["gz_ros2_control", "gazebo_plugins", "turtlebot3"])
def test_packages_of_plugins_have_a_folder(package: str) -> None:
    add_prefix()
    assert Path(get_package_prefix(package), "share", package, "package.xml").is_file()


@pytest.mark.parametrize("kind", ["burger", "waffle", "waffle_pi"])
def test_the_burger_stands_for_each_turtlebot3(kind: str) -> None:
    share = add_prefix() / "share"
    gazebo, name = share / "turtlebot3_gazebo", f"turtlebot3_{kind}"
    for path in (
        gazebo / "models" / name / "model.sdf",
        gazebo / "urdf" / f"{name}.urdf",
        share / "turtlebot3_description" / "urdf" / f"{name}.urdf.xacro",
    ):
        assert path.read_text() == BURGER.read_text()


def test_a_world_that_lacks_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(gazebo, "Client", _TwoAsk)
    monkeypatch.setattr(_TwoAsk, "run_until", lambda *_, **__: False)
    with pytest.raises(Ros2Error, match=r"no\.world"):
        gazebo.serve(["-s", f"{tmp_path}/no.world"])
    assert f"there is no {tmp_path}/no.world" in capfd.readouterr().out


def test_why_a_robot_is_not_taken_is_told_once(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    answers = [SimulatorError(f"no wheels ({Result.RESULT_INCORRECT_STATE})")] * 9
    times = iter(range(99))

    def ask(*_: object) -> Any:
        if answers:
            raise answers.pop()
        return SimpleNamespace(entity_name="r")

    client: Any = SimpleNamespace(ask=ask, run_until=lambda *_, **__: False)
    monkeypatch.setattr(gazebo, "time", SimpleNamespace(monotonic=lambda: next(times)))
    assert gazebo._ask(client, SpawnEntity.Request()) == "r"
    assert capfd.readouterr().out == f"waits: no wheels ({Result.RESULT_INCORRECT_STATE})\n"


def test_gazebos_programs_are_the_simulator() -> None:
    programs = {path.name: path.read_text() for path in (add_prefix() / "bin").iterdir()}
    assert set(programs) == {"gazebo", "gz", "gzclient", "gzserver", "ign"}
    assert " gazebo_ros gzclient " in programs.pop("gzclient")
    assert all(" gazebo_ros gzserver " in text for text in programs.values())


def test_a_world_with_a_robot_waits_for_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    world, started = write(tmp_path, Held()), list[tuple[str, list[str]]]()
    monkeypatch.setattr(gazebo, "arjuna", lambda *words: started.append(words))
    monkeypatch.setenv("ROS_DOMAIN_ID", "93")
    gazebo.serve(["-r", "-s", str(world)])
    assert started == [("sim", ["--world", str(world)])]
    assert "waits" not in capfd.readouterr().out


class _TwoAsk:
    """A client whose service is asked twice, for a robot and for another, before it starts."""

    name = ""

    def __init__(self, **_: object) -> None:
        self.node, self.spawn, self.codes = self, None, list[int]()

    def __enter__(self) -> _TwoAsk:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def create_service(self, _: object, name: str, spawn: Callable[[Any, Any], Any]) -> None:
        if name != "/spawn_entity":
            return
        for wheels in ("odom", "wheels"):
            request = SpawnEntity.Request()
            topic = f"<odometry_topic>{wheels}</odometry_topic><odometry_frame>"
            text = BURGER.read_text().replace("<odometry_frame>", topic)
            request.entity_resource.resource_string, request.name = text, self.name
            self.codes.append(spawn(request, SpawnEntity.Response()).result.result)

    def count_publishers(self, _: str) -> int:
        return 0

    def run_until(self, *_: object, **__: object) -> bool:
        return True

    def pause(self, _: float) -> None:
        assert self.codes == [Result.RESULT_OK, Result.RESULT_INCORRECT_STATE]


def test_a_robot_that_starts_keeps_its_description_when_another_comes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    started: list[str] = []
    monkeypatch.setattr(gazebo, "Client", _TwoAsk)
    monkeypatch.setattr(
        gazebo, "arjuna", lambda _, words: started.append(Path(words[3]).read_text())
    )
    gazebo.serve(["-s", "empty.world"])
    assert "<odometry_topic>odom<" in started[0]


def test_a_robot_of_the_name_of_one_in_the_world_is_that_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    world, started = write(tmp_path, Held()), list[tuple[str, list[str]]]()
    monkeypatch.setattr(gazebo, "Client", _TwoAsk)
    monkeypatch.setattr(_TwoAsk, "name", Held().name)
    monkeypatch.setattr(_TwoAsk, "pause", lambda *_: None)
    monkeypatch.setattr(gazebo, "arjuna", lambda *words: started.append(words))
    gazebo.serve(["-r", "-s", str(world)])
    assert started == [("sim", ["--world", str(world)])]
    assert f"'{Held().name}' stands in the world's file" in capfd.readouterr().out
