"""Launch files of the guides as they stand, and of the shapes of other people's robots.

What each starts is recorded, not run: a program's own words, and what ROS is told of it.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml
from launch import LaunchContext
from launch.events.process import ProcessExited, ProcessStarted
from launch.execute_process import ExecuteLocal
from launch_ros import lifecycle

from bringup.cli import parse
from bringup.ros2.prefix import add_prefix
from bringup.ros2.verbs import launch as verb

pytestmark = pytest.mark.ros
FILES = Path(__file__).parent / "files"
URDF = '<robot name="r"><link name="base_link"/></robot>'
_FILTERS = """
lanes_filter_info_server: {ros__parameters: {filter_info_topic: /lanes, mask_topic: /mask}}
keepout_filter_mask_server: {ros__parameters: {yaml_filename: "", topic_name: /keepout_mask}}
"""
_EMPTY = "{Visualization Manager: {Displays: []}}"


class Launched(NamedTuple):
    """The processes of a launch file, and what was said of it.

    Attributes:
        lines: `PACKAGE/EXECUTABLE words` or `arjuna COMMAND words`; folders are left out of paths.
        parameters: Those of each line's files, merged.
    """

    code: int
    lines: list[str]
    parameters: list[dict[str, Any]]
    said: str


Launch = Callable[..., Launched]


def _workspace(prefix: Path) -> None:
    for package in ("my_robot", "my_nav_robot", "first_pkg"):
        share, lib = prefix / "share" / package, prefix / "lib" / package
        texts = {
            share / "urdf" / "robot.urdf": URDF,
            share / "launch" / "rsp.launch.py": (FILES / "rsp.launch.py").read_text(),
            share / "config" / "twist_mux.yaml": "twist_mux: {ros__parameters: {a: 1}}",
            share / "config" / "ekf.yaml": "ekf_filter_node: {ros__parameters: {frequency: 30.0}}",
            share / "config" / "filters.yaml": _FILTERS,
            share / "config" / "slam.yaml": "slam_toolbox: {ros__parameters: {mode: mapping}}",
            share / "config" / "slam_params.yaml": "slam_toolbox: {ros__parameters: {}}",
            share / "config" / "nav2_params.yaml": "bt_navigator: {ros__parameters: {}}",
            share / "config" / "nav2_default.rviz": _EMPTY,
            share / "rviz" / "rviz_config.rviz": _EMPTY,
            share / "maps" / "my_map.yaml": "image: my_map.pgm",
            prefix / "share/ament_index/resource_index/packages" / package: "",
            lib / "talker": "#!/bin/sh\n",
            lib / "controller_node": "#!/bin/sh\n",
            lib / "simple_pose.py": "#!/bin/sh\n",
        }
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            path.chmod(0o755)


@pytest.fixture(scope="module")
def cache(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("cache")


@pytest.fixture
def started(
    cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Launch:
    _workspace(tmp_path / "install")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path / "install"))
    monkeypatch.setenv("PATH", f"{Path(sys.executable).parent}:/usr/bin:/bin")
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "log"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    monkeypatch.setenv("HOME", "/home/user")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "urdf").mkdir()
    (tmp_path / "urdf" / "robot.urdf").write_text(URDF)
    made = add_prefix()
    recorded: list[tuple[str, dict[str, Any]]] = []
    monkeypatch.setattr(lifecycle, "_PATIENCE", 0.2)

    def record(action: Any, context: LaunchContext) -> None:
        words = action.words(context)
        recorded.append(_shown(words, (tmp_path / "install", made)))
        details = {"action": action, "name": "x", "cmd": words, "pid": 1}
        context.emit_event_sync(ProcessStarted(**details))
        context.emit_event_sync(ProcessExited(returncode=0, **details))

    monkeypatch.setattr(ExecuteLocal, "execute", record)

    def run(name: str, *words: str) -> Launched:
        recorded.clear()
        code = verb.run([str(FILES / name), *words])
        given = capsys.readouterr()
        lines = [line for line, _ in recorded]
        return Launched(code, lines, [values for _, values in recorded], given.out + given.err)

    return run


def _shown(words: list[str], prefixes: tuple[Path, ...]) -> tuple[str, dict[str, Any]]:
    if words[:2] == [sys.executable, "-m"]:
        ours = words[3:]
        if words[2] == "bringup":
            parse([word for word in ours if "$(" not in word])  # its options are there
        words = ["arjuna", *ours]
    values: dict[str, Any] = {}
    left: list[str] = []
    rest = iter(words)
    for word in rest:
        if word == "--params-file":
            document = yaml.safe_load(Path(next(rest)).read_text())
            values |= next(iter(document.values()))["ros__parameters"]
        else:
            left.append(word)
    line = " ".join(left)
    for prefix in prefixes:
        line = line.replace(f"{prefix}/lib/", "").replace(f"{prefix}/share/", "")
    line = re.sub(r"/\S*/(?=(urdf|worlds|maps)/)", "", line)
    line = re.sub(r"(?s)<\?xml.*</robot>\n?", "SDF", re.sub(r"/tmp/nav2_\S+", "WORLD", line))
    return re.sub(r"/\S*/arjuna-launch-\S+\.yaml", "TMP", line), values


EXPECTED: dict[str, list[str | dict[str, str]]] = yaml.safe_load(
    (Path(__file__).parent / "started.yaml")
    .read_text(encoding="utf-8")
    .replace("$FILES", str(FILES))
    .replace("$BIN", str(Path(sys.executable).parent))
)
"""By file the lines of what it starts, and what it `says`."""


@pytest.mark.parametrize("name", EXPECTED)
def test_a_launch_file_starts_what_it_names(name: str, started: Launch) -> None:
    lines = [line for line in EXPECTED[name] if isinstance(line, str)]
    said = [line["says"] for line in EXPECTED[name] if isinstance(line, dict)]
    found = started(name)
    assert [line.removesuffix(" --ros-args") for line in found.lines] == lines
    assert all(text in found.said for text in said), found.said
    assert found.code == int(any("is not started" in text for text in said))
    assert "Traceback" not in found.said


def test_every_file_is_tried() -> None:
    assert {path.name for path in FILES.iterdir() if path.is_file()} == EXPECTED.keys()


@pytest.mark.parametrize(
    ("name", "words", "line", "values"),
    [
        ("opaque.launch.py", ["count:=1"], 0, {"gains": [1.0, 2.0], "nested.deep.value": True}),
        ("demo_launch.xml", [], 0, {"speed": 0.5, "label": "5", "a": 1}),
        ("demo_launch.xml", [], 2, {"port": 8766, "address": "127.0.0.1"}),
        ("robot_launch.py", ["use_sim_time:=true"], 0, {"use_sim_time": True}),
        ("sim_launch.py", [], 1, {"robot_description": URDF, "use_sim_time": True}),
        ("namespaced.launch.py", [], 0, {"use_sim_time": True}),
        ("static_frames.launch.py", [], 2, {}),
        ("spawned.launch.py", [], 5, {"use_sim_time": True}),
        ("own_navigation.launch.py", ["use_sim_time:=true"], 0, {"use_sim_time": True}),
        ("turtlebot3_own_world.launch.py", [], 2, {"use_sim_time": True, "frame_prefix": ""}),
        ("urdf_display.launch.py", [], 3, {"device_id": 1, "autorepeat_rate": 20.0}),
        ("urdf_display.launch.py", [], 4, {"publish_stamped_twist": True}),
        ("own_navigation.launch.py", ["use_composition:=True"], 1, {"use_sim_time": False}),
        (
            "own_navigation.launch.py",
            [],
            4,
            {
                "autostart": True,
                "node_names": [
                    *("controller_server", "planner_server", "behavior_server", "bt_navigator"),
                ],
            },
        ),
    ],
)
def test_parameters_reach_a_node_with_their_types(
    name: str,
    words: list[str],
    line: int,
    values: dict[str, Any],
    started: Launch,
) -> None:
    found = started(name, *words).parameters[line]
    assert {key: found[key] for key in values} == values


def test_a_file_of_an_installed_ros_is_the_one_that_is_here(started: Launch) -> None:
    path = started("installed_paths.launch.py").parameters[1]["yaml_filename"]
    assert Path(path) == add_prefix() / "share/nav2_bringup/maps/tb3_sandbox.yaml"


def test_poses_of_robots_are_read_from_the_command_line(
    started: Launch, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["ros2", "poses:=a={x: 1.5}; b={yaw: 1.57}"])
    said = started("several_robots.launch.py").said
    assert "a 1.5 0.0" in said
    assert "b 0.0 1.57" in said


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("cloned_multi", ["robots:=a={x: 1.0, y: 0.5}; b={x: -1, yaw: 1.57}", "params_file:=p"]),
        (
            "cloned_multi",
            [
                "robots:={name: a, pose: {x: 1.0, y: 0.5}};{name: b, pose: {x: -1, yaw: 1.57}}",
                "params_file:=p",
            ],
        ),
        (
            "unique_multi",
            [
                *("robots:=a={x: 1.0, y: 0.5}; b={x: -1, yaw: 1.57}", "a_params_file:=p"),
                "b_params_file:=p",
            ],
        ),
    ],
)
def test_nav2_s_several_robots_are_one_world_and_navigation_for_each(
    name: str, words: list[str], started: Launch
) -> None:
    file = add_prefix() / "share/nav2_bringup/launch" / f"{name}_tb3_simulation_launch.py"
    found = started(str(file), *words, "use_rviz:=False", "autostart:=True")
    assert found.lines == [
        "arjuna sim --robot urdf/burger.urdf --world worlds/pillar_arena.world"
        " --namespace a --at 1.0 0.5 --heading 0.0 --namespace b --at -1.0 0.0 --heading 1.57",
        "arjuna nav --map maps/pillar_arena.yaml --namespace a --params p",
        "arjuna nav --map maps/pillar_arena.yaml --namespace b --params p",
    ]
    assert "robots: 'x' is no robot; valid: NAME={x" in started(str(file), "robots:=x").said


@pytest.mark.parametrize("name", ["tb3_simulation", "tb4_simulation"])
def test_nav2_s_simulation_is_world_navigation_and_view(name: str, started: Launch) -> None:
    file = add_prefix() / "share/nav2_bringup/launch" / f"{name}_launch.py"
    start = "arjuna sim --robot urdf/burger.urdf --world worlds/pillar_arena.world --at"
    found = started(str(file), "namespace:=tb3", "x_pose:=1.0", "y_pose:=0.5", "headless:=False")
    assert found.lines == [
        f"{start} 1.0 0.5 --namespace tb3",
        "arjuna nav --map maps/pillar_arena.yaml --namespace tb3",
        "arjuna view --namespace tb3",
    ]
    assert started(str(file), "use_rviz:=False", "slam:=True").lines == [
        f"{start} -2 -0.5",
        "arjuna nav --slam",
    ]


@pytest.mark.parametrize("ending", [".launch.py", "_launch.py"])
def test_nav2_s_loopback_is_the_map_s_world_and_the_robot_where_it_is_said_to_be(
    ending: str, started: Launch
) -> None:
    file = add_prefix() / f"share/nav2_bringup/launch/tb3_loopback_simulation{ending}"
    words = ("use_rviz:=False", "params_file:=p", "map:=maps/office.yaml")
    assert started(str(file), *words).lines == [
        "arjuna sim --robot urdf/burger.urdf --param placed_by_estimate:=true"
        " --world maps/office.yaml",
        "arjuna nav --map maps/office.yaml --params p",
    ]


def test_a_turtlebot4_is_a_docked_robot_in_the_warehouse(started: Launch) -> None:
    file = add_prefix() / "share/turtlebot4_gz_bringup/launch/turtlebot4_gz.launch.py"
    found = started(str(file), "nav2:=true", "localization:=true", "x:=1.0", "namespace:=b")
    assert found.lines == [
        "arjuna sim --robot urdf/burger.urdf --world worlds/warehouse.world"
        " --at 1.0 0.0 --heading 0.0 --namespace b",
        "arjuna nav --without-navigation --map maps/warehouse.yaml --namespace b",
        "arjuna nav --without-localization --namespace b",
        "irobot_create_nodes/motion_control --ros-args -r __ns:=/b",
    ]
    assert "--world worlds/office.world" in started(str(file), "world:=office").lines[0]
    assert "no world 'maze'; valid: apriltag" in started(str(file), "world:=maze").said
    spawn = add_prefix() / "share/turtlebot4_ignition_bringup/launch/turtlebot4_spawn.launch.py"
    assert started(str(spawn), "x:=1.0", "yaw:=0.5", "namespace:=b").lines == [
        "ros_gz_sim/create -name turtlebot4 -file urdf/burger.urdf -robot_namespace b"
        " -x 1.0 -y 0.0 -Y 0.5",
        "irobot_create_nodes/motion_control --ros-args -r __ns:=/b",
    ]


def test_a_description_made_by_xacro_keeps_its_text(started: Launch) -> None:
    for name in ("rsp.launch.py", "display.launch.py", "urdf_display.launch.py"):
        text = started(name).parameters[0]["robot_description"]
        assert '\n<robot name="r">' in text


@pytest.mark.parametrize(
    ("name", "words", "line"),
    [
        ("display.launch.py", ["gui:=false"], "joint_state_publisher/joint_state_publisher"),
        ("own_namespace_if.launch.py", ["mode:=amcl"], "nav2_amcl/amcl --ros-args -r __node:=amcl"),
        (
            "own_namespace_if.launch.py",
            ["use_namespace:=true", "mode:=amcl"],
            "nav2_amcl/amcl --ros-args -r __node:=amcl -r __ns:=/ns",
        ),
        ("demo_launch.xml", ["gui:=true"], "rviz2/rviz2"),
        ("slam_nav.launch.py", ["sim:=true"], "arjuna nav --without-localization"),
    ],
)
def test_an_argument_decides(name: str, words: list[str], line: str, started: Launch) -> None:
    assert line not in started(name).lines
    assert line in started(name, *words).lines


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("x = 1", "has no function generate_launch_description()"),
        ("def generate_launch_description():\n    return 1", "valid: LaunchDescription"),
        ("import moveit_configs_utils", "'moveit_configs_utils' is not installed here"),
        (
            "from ament_index_python import get_package_share_directory as share\n"
            "share('cartographer_ros')",
            "package 'cartographer_ros' not found.*online_async_launch.py' maps",
        ),
        ("def generate_launch_description(:", "SyntaxError"),
        (
            "from launch import *\nfrom launch.actions import *\n"
            "def generate_launch_description():\n"
            "    return LaunchDescription([DeclareLaunchArgument('map')])",
            "Required launch argument 'map' was not provided|missing required argument 'map'",
        ),
        (
            "from launch import *\nfrom launch.substitutions import *\n"
            "from launch.actions import *\ndef generate_launch_description():\n"
            "    return LaunchDescription([LogInfo(msg=LaunchConfiguration('nope'))])",
            "launch configuration 'nope' does not exist",
        ),
    ],
)
def test_a_broken_file_is_named_with_its_remedy(
    text: str, problem: str, tmp_path: Path, started: Launch
) -> None:
    (tmp_path / "broken.launch.py").write_text(text)
    found = started(str(tmp_path / "broken.launch.py"))
    assert (found.code, found.lines) == (1, [])
    assert re.search(problem, found.said), found.said


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("<launch><nod pkg='a' exec='b'/></launch>", "<nod> is unknown; did you mean 'node'?"),
        ("<launch><node pkg='a'/></launch>", "<node> lacks 'exec', it has: pkg"),
        ("<launch><log message='$(vra x)'/></launch>", "did you mean 'var'?"),
        ("<launch><log message='$(var x'/></launch>", "lacks a ')'"),
        ("<robot/>", "is of <robot>; valid: <launch>"),
        ("<launch><include file='no.py'/></launch>", "launch file no.py does not exist"),
    ],
)
def test_a_broken_xml_file_is_named(
    text: str, problem: str, tmp_path: Path, started: Launch
) -> None:
    (tmp_path / "broken.launch.xml").write_text(text)
    found = started(str(tmp_path / "broken.launch.xml"))
    assert found.code == 1
    assert problem in found.said


def test_a_description_is_printed_and_started_below_a_prefix(started: Launch) -> None:
    printed = started("display.launch.py", "--print")
    assert (printed.code, printed.lines) == (0, [])
    assert "\n    Node(...)\n" in printed.said
    options = ("--launch-prefix", "nice -n 5", "--launch-prefix-filter", "joint_.*")
    prefixed = [
        line.startswith("nice -n 5 ") for line in started("display.launch.py", *options).lines
    ]
    assert sorted(prefixed) == [False, False, True]


def test_arguments_are_listed(started: Launch, capsys: pytest.CaptureFixture[str]) -> None:
    assert verb.run(["-s", str(FILES / "display.launch.py")]) == 0
    printed = capsys.readouterr().out
    assert "    'model':\n        Path of the URDF\n" in printed
    assert "        one of: true, false\n        (default: 'true')\n" in printed
    assert " at 0x" not in printed


def test_a_node_that_is_not_to_start_by_itself_is_left_alone(started: Launch) -> None:
    assert "ake transition" in started("lifecycle_slam.launch.py").said
    assert "ake transition" not in started("lifecycle_slam.launch.py", "autostart:=false").said
