"""Programs that `ros2 run` runs, and the bridge."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from arjuna_core.pose3 import Pose3
from arjuna_core.ros.convert import transform_msg
from arjuna_core.se2 import SE2
from arjuna_sim.model.settings import BRIDGES
from bringup.ros2.errors import Ros2Error
from bringup.ros2.programs.bridge import Bridged, Relay, bridged, marks, simulated
from bringup.ros2.programs.relays import relayed
from bringup.ros2.programs.static_transform_publisher import parse
from bringup.ros2.programs.tf2_echo import lines
from bringup.ros2.programs.tf2_monitor import Delays, chain_of
from tests.helpers.processes import Lines
from tests.helpers.ros import RosBench
from tests.helpers.ros2.commands import Outcome
from tests.nodes.bringup.ros2.conftest import ENVIRONMENT

TURNED = Pose3.from_rpy((1.0, 2.0, -3.0), (0.0, 0.0, 0.5))


@pytest.mark.parametrize(
    "words",
    [
        "--x 1 --y 2 --z -3 --yaw 0.5 --frame-id map --child-frame-id base",
        "1 2 -3 0.5 0 0 map base",
        "1 2 -3 0 0 0.247404 0.968912 map base",
        "--x 1 --y 2 --z -3 --qz 0.247404 --qw 0.968912 --frame-id map --child-frame-id base",
    ],
)
def test_a_static_transform_in_all_its_forms(words: str) -> None:
    frame, child, pose = parse(words.split())
    assert (frame, child, pose.position) == ("map", "base", TURNED.position)
    assert pose.quaternion == pytest.approx(TURNED.quaternion, abs=1e-6)


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        ("--x 1 --frame-id map", "--frame-id and --child-frame-id are needed"),
        ("1 2 3 map base", "unknown arguments: 1 2 3 map base"),
        ("--yaw 1 --qw 1 --frame-id a --child-frame-id b", "cannot specify both quaternion"),
        ("1 2 3 4 5 x map base", "could not convert string to float"),
    ],
)
def test_wrong_words_are_refused(
    words: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit, match="2"):
        parse(words.split())
    assert problem in capsys.readouterr().err


def test_tf2_echo_prints_a_pose_in_every_form() -> None:
    assert lines(1.25, TURNED) == [
        "At time 1.250000000",
        "- Translation: [1.000, 2.000, -3.000]",
        "- Rotation: in Quaternion (xyzw) [0.000, 0.000, 0.247, 0.969]",
        "- Rotation: in RPY (radian) [0.000, 0.000, 0.500]",
        "- Rotation: in RPY (degree) [0.000, 0.000, 28.648]",
        "- Matrix:",
        "  0.878 -0.479  0.000  1.000",
        "  0.479  0.878  0.000  2.000",
        "  0.000  0.000  1.000 -3.000",
        "  0.000  0.000  0.000  1.000",
    ]


def test_tf2_monitor_reports_delays_of_frames_and_of_a_chain() -> None:
    delays = Delays(now=10.0)
    for stamp in (9.5, 9.0):
        moving = transform_msg(SE2(), "odom", "base", stamp)
        delays.add(TFMessage(transforms=[moving, transform_msg(SE2(), "map", "odom", 9.75)]))
    delays.net.append(1.5)
    parents = {"base": "odom", "odom": "map", "lidar": "base", "other": "map"}
    assert chain_of(parents, "lidar", "map") == ["lidar", "base", "odom", "map"]
    assert chain_of(parents, "base", "other") == ["base", "odom", "map", "other"]
    head, frames = delays.lines(["base", "odom"]), delays.lines()
    assert head[3:6] == [
        "RESULTS: for odom to base",
        "Chain is: base -> odom",
        "Net delay     avg = 1.5: max = 1.5",
    ]
    assert frames[3] == "RESULTS: for all Frames"
    assert (
        "Frame: base, published by <no authority available>, Average Delay: 0.75, Max Delay: 1"
        in frames
    )
    assert re.fullmatch(
        r"Node: <no authority available> [\d.e+]+ Hz, Average Delay: 0.5 Max Delay: 0.625",
        frames[-1],
    )


def test_view_frames_writes_a_graph_and_a_pdf(ros2: Callable[..., Outcome], tmp_path: Path) -> None:
    name = tmp_path / "tree"
    assert ros2("run", "tf2_tools", "view_frames", "-t", "3", "-o", str(name)).code == 0
    assert (
        '"map" -> "base"[label=" Broadcaster: default_authority'
        in name.with_suffix(".gv").read_text()
    )
    assert name.with_suffix(".pdf").read_bytes().startswith(b"%PDF")


STRING = "std_msgs/msg/String"
CONFIG = f"""
- ros_topic_name: "/front/scan"
  gz_topic_name: "scan"
  ros_type_name: "{STRING}"
  gz_type_name: "gz.msgs.LaserScan"
  direction: GZ_TO_ROS
- topic_name: "chatter"
  ros_type_name: "{STRING}"
  gz_type_name: "gz.msgs.StringMsg"
"""


def test_arguments_and_remappings_are_read() -> None:
    words = [f"/scan@{STRING}[gz.msgs.LaserScan", f"/cmd_vel@{STRING}]gz.msgs.Twist"]
    words += ["--ros-args", "-r", "/scan:=/front/scan"]
    assert list(bridged(words)) == [
        Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"),
        Bridged("/cmd_vel", "/cmd_vel", STRING, "ROS_TO_GZ"),
    ]
    with pytest.raises(Ros2Error, match="'/scan' is no topic"):
        list(bridged(["/scan"]))


def test_a_bridge_says_whether_it_hands_transforms_on() -> None:
    def said(*words: str) -> list[str]:
        return marks(list(bridged(list(words))))

    odom = "/odom@nav_msgs/msg/Odometry[gz.msgs.Odometry"
    assert said() == []
    assert said(odom, "/tf@tf2_msgs/msg/TFMessage]gz.msgs.Pose_V") == [BRIDGES]
    frames = "/model/bot/tf@tf2_msgs/msg/TFMessage[gz.msgs.Pose_V"
    assert said(odom, frames) == [BRIDGES, f"{BRIDGES}/tf"]
    assert said(odom, "/model/bot/pose@tf2_msgs/msg/TFMessage[gz.msgs.Pose_V") == [BRIDGES]


def test_services_of_a_bridge_are_the_simulators_and_topics_beside_them_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, kind = tmp_path / "bridge.yaml", "ros_gz_interfaces/srv/ControlWorld"
    path.write_text(f"- {{service_name: /world/w/other, ros_type_name: a/srv/Attach}}\n{CONFIG}")
    words = [f"/world/w/control@{kind}", f"/world/w/set_pose@{kind}@gz.msgs.Pose@gz.msgs.Boolean"]
    words += [f"/c@{STRING}[gz.msgs.StringMsg", "--ros-args", "-p", f"config_file:={path}"]
    services, topics = ["/world/w/control", "/world/w/set_pose"], ["/c", "/scan", "/chatter"]
    assert [topic.gz for topic in bridged(words)] == services + topics
    (said,) = capsys.readouterr().out.splitlines()
    assert said.startswith("/world/w/other is not bridged: of the types, the simulator has Spawn")


def test_names_below_the_bridge_s_namespace(tmp_path: Path) -> None:
    """ROS's are relative to it, Gazebo's where they are expanded; a launch file's values count."""
    path, values = tmp_path / "bridge.yaml", tmp_path / "values.yaml"
    path.write_text(f"- {{topic_name: scan, ros_type_name: {STRING}}}\n")
    words = ["--ros-args", "-r", "__ns:=/a", "--params-file", str(values)]
    for expands, gz in ("false", "/scan"), ("true", "/a/scan"):
        given = f"{{config_file: {path}, expand_gz_topic_names: {expands}}}"
        values.write_text(f"/**: {{ros__parameters: {given}}}\n")
        assert list(bridged(words)) == [Bridged(gz, "/a/scan", STRING, "BIDIRECTIONAL")]


def test_file_is_read_but_for_entries_that_are_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bridge.yaml"
    path.write_text(f"- ros topic_name: /imu\n{CONFIG}- none\n")
    words = ["--ros-args", "-p", f"config_file:={path}"]
    assert list(bridged(words)) == [
        Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"),
        Bridged("/chatter", "/chatter", STRING, "BIDIRECTIONAL"),
    ]
    said = capsys.readouterr().out.splitlines()
    assert len(said) == 2
    assert "left out: the entry {'ros topic_name': '/imu'} needs ros_topic_name, gz_to" in said[0]


def test_messages_come_under_the_other_name_while_somebody_listens(bench: RosBench) -> None:
    relay = Relay(bench.node, Bridged("/scan", "/front/scan", STRING, "GZ_TO_ROS"), raw=False)
    relay.look()
    bench.publish(String, "/scan", String(data="early"))
    assert bench.node.count_subscribers("/scan") == 0
    heard = bench.collect(String, "/front/scan")
    relay.look()
    bench.publish(String, "/scan", String(data="now"))
    assert [message.data for message in heard] == ["now"]


def test_poses_of_entities_come_from_the_simulator_by_gazebo_s_names(bench: RosBench) -> None:
    poses = Bridged("/model/a/pose", "/truth", STRING, "BIDIRECTIONAL")
    assert simulated(bench.node, poses) == poses._replace(direction="GZ_TO_ROS")


def test_a_model_s_own_topics_are_the_robot_s(bench: RosBench) -> None:
    """Wherever the robot is, once it is there; a topic that its file calls so stays."""
    commands = Bridged("/model/a/cmd_vel", "/model/a/cmd_vel", STRING, "BIDIRECTIONAL")
    odometry = Bridged("/model/a/odometry", "/odometry", STRING, "BIDIRECTIONAL")
    assert simulated(bench.node, commands) is None
    bench.collect(String, "/cmd_vel")
    assert simulated(bench.node, commands) == ("/cmd_vel", commands.ros, STRING, "ROS_TO_GZ")
    bench.publish(String, "/a/odom", String())
    assert simulated(bench.node, odometry) == ("/a/odom", "/odometry", STRING, "GZ_TO_ROS")
    bench.collect(String, "/model/a/cmd_vel")
    assert simulated(bench.node, commands) == (*commands[:3], "ROS_TO_GZ")
    other = Bridged("/model/a-b/joint/c/0/cmd_pos", "/cmd_pos", STRING, "ROS_TO_GZ")
    assert simulated(bench.node, other) is None  # ROS cannot spell it
    bench.collect(String, "/model/a_b/joint/c/_0/cmd_pos")
    assert simulated(bench.node, other) == ("/model/a_b/joint/c/_0/cmd_pos", *other[1:])


def test_a_model_spawned_by_another_name_has_the_topics_of_its_file(bench: RosBench) -> None:
    force = Bridged("/model/bot/joint/a/cmd_force", "/force", STRING, "ROS_TO_GZ")
    bench.publish(String, force.gz, String())  # of a node that knows that name
    bench.collect(String, "/model/made/joint/b/cmd_force")
    assert simulated(bench.node, force) is None
    bench.collect(String, "/model/made/joint/a/cmd_force")
    assert simulated(bench.node, force) == force._replace(gz="/model/made/joint/a/cmd_force")
    bench.collect(String, "/bot/model/made/joint/a/cmd_force")
    assert simulated(bench.node, force) == force._replace(gz="/bot/model/made/joint/a/cmd_force")


def test_a_bridge_to_no_name_of_ros_is_refused() -> None:
    with pytest.raises(Ros2Error, match="token that starts with a number"):
        list(bridged(["/a/0/b@std_msgs/msg/String[gz.msgs.StringMsg"]))
    words = ["/a/0/b@std_msgs/msg/String[gz.msgs.StringMsg", "--ros-args", "-r", "/a/0/b:=/b"]
    assert [(each.gz, each.ros) for each in bridged(words)] == [("/a/0/b", "/b")]


@pytest.mark.parametrize(
    ("gz", "own"),
    [
        ("/world/w/model/a/link/rack/top/sensor/lidar/scan", "/a/scan"),
        ("/world/w/model/a/link/rack/sensor/lidar/scan", "/a/lidar/scan"),
        ("/world/w/model/a/link/rack/sensor/lidar/scan/points", "/a/scan/points"),
        ("/world/w/model/a/link/rack/sensor/gyro/imu", "/imu/data"),
        ("/model/a/joint_state", "/a/joint_states"),
    ],
)
def test_topics_that_gazebo_names_are_the_simulator_s(bench: RosBench, gz: str, own: str) -> None:
    named = Bridged(gz, "/other", STRING, "GZ_TO_ROS")
    assert simulated(bench.node, named) is None
    bench.publish(String, own, String())
    assert simulated(bench.node, named) == named._replace(gz=own)
    clock = named._replace(gz="/world/w/clock")
    assert simulated(bench.node, clock) == named._replace(gz="/clock")


def test_commands_go_the_other_way(bench: RosBench) -> None:
    taken = bench.collect(String, "/model/cmd_vel")
    topic = Bridged("/model/cmd_vel", "/cmd_vel", STRING, "BIDIRECTIONAL")
    relay = Relay(bench.node, topic, raw=False)
    relay.look()
    bench.publish(String, "/cmd_vel", String(data="go"))
    assert [message.data for message in taken] == ["go"]


@pytest.mark.parametrize(
    ("name", "words", "names", "passed"),
    [
        ("relay", "/scan", ("/scan", "/scan_relay"), "yyyyyy"),
        ("relay", "/scan out --ros-args -r __node:=r", ("/scan", "out"), "yyyyyy"),
        (
            "relay",
            "--ros-args -p input_topic:=/scan -p output_topic:=/out",
            ("/scan", "/out"),
            "yyyyyy",
        ),
        ("throttle", "messages imu 2.5 slow", ("imu", "slow"), "ynnnyn"),
        (
            "throttle",
            "--ros-args -p input_topic:=imu -p msgs_per_sec:=5.0",
            ("imu", "imu_throttle"),
            "ynynyn",
        ),
        ("drop", "/scan 2 3", ("/scan", "/scan_drop"), "nnynny"),
    ],
)
def test_some_messages_of_a_topic_have_another_name(
    name: str, words: str, names: tuple[str, str], passed: str
) -> None:
    asked = relayed(name, words.split())
    assert asked[:2] == names
    assert "".join("ny"[asked.passes(0.1 * k + 1e-6 * k)] for k in range(6)) == passed


@pytest.mark.parametrize("words", [["relay"], ["throttle", "imu"], ["throttle", "imu", "0"]])
def test_a_relay_without_its_words_says_which(words: list[str]) -> None:
    with pytest.raises(Ros2Error, match=r"valid: IN (msgs_per_sec )?\[OUT\]"):
        relayed(words[0], words[1:])


_PICTURE = "{height: 2, width: 2, encoding: rgb8, step: 6, data: [9,9,9,9,9,9,9,9,9,9,9,9]}"
_PUB = "topic pub -r 10 /wish geometry_msgs/msg/Twist"
_STAMPER = "twist_stamper twist_stamper --ros-args -r cmd_vel_in:=/wish -r /cmd_vel_out:=/again"


@pytest.mark.parametrize(
    ("words", "sent", "kind"),
    [
        ("topic_tools relay /chatter /again", [], "std_msgs/msg/String"),
        (_STAMPER, [*_PUB.split(), "{linear: {x: 0.5}}"], "geometry_msgs/msg/TwistStamped"),
        (
            "image_transport republish raw compressed --ros-args -r in:=/wish"
            " -r /out/compressed:=/again",
            [*["topic", "pub", "-r", "10", "/wish", "sensor_msgs/msg/Image"], _PICTURE],
            "sensor_msgs/msg/CompressedImage",
        ),
        (
            "demo_nodes_cpp talker --ros-args -r chatter:=/again",
            ["run", "demo_nodes_py", "listener"],
            "std_msgs/msg/String",
        ),
    ],
)
def test_a_topic_is_handed_on(
    words: str,
    sent: list[str],
    kind: str,
    ros2: Callable[..., Outcome],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name, value in ENVIRONMENT.items():
        monkeypatch.setenv(name, value)
    command = "-m", "bringup.ros2.main"
    with Lines(*command, "run", *words.split()), Lines(*command, *(sent or ["node", "list"])):
        printed = ros2("topic", "echo", "--once", "/again", kind)
    assert printed.code == 0
    assert ("x: 0.5" if "Twist" in kind else "data:") in printed.out
