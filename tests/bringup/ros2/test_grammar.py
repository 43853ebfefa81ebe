"""The command line of `ros2`: its grammar, its help, and whose program runs."""

from __future__ import annotations

import argparse
import itertools
import os
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import pytest
from std_msgs.msg import String

from arjuna_core.files.shipped import shipped_file
from bringup.cli import parse
from bringup.ros2.grammar import VERBS, build_parser, choices_of
from bringup.ros2.launches import LAUNCHES
from bringup.ros2.main import main, real_ros2, without_wheels
from bringup.ros2.roslaunch import commands_of, is_ros1
from bringup.ros2.verbs import forward, launch, multicast, send
from bringup.ros2.verbs.forward import RosArguments, ros_arguments

pytestmark = pytest.mark.ros
_BURGER, _PILLARS = shipped_file("urdf/burger.urdf"), shipped_file("worlds/pillar_arena.world")


def test_help_imports_neither_ros_nor_numpy() -> None:
    code = (
        "import sys; from bringup.ros2.main import main\n"
        "try: main(['topic', 'pub', '--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'rclpy', 'numpy', 'yaml'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_every_verb_has_its_function() -> None:
    for name, command in choices_of(build_parser()):
        for verb, parser in choices_of(command):
            module, function = parser.get_default("run").split(":")
            path = Path(*VERBS.split("."), f"{module}.py")
            assert f"\ndef {function}(" in path.read_text(), (name, verb)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["topic", "echo", "/scan", "--once"], {"topic_name": "/scan", "once": True}),
        (["topic", "--include-hidden-topics", "list"], {"include_hidden_topics": True}),
        (["topic", "list", "-a", "-t"], {"include_hidden_topics": True, "show_types": True}),
        (["topic", "list"], {"include_hidden_topics": False, "count_topics": False}),
        (["topic", "pub", "-1", "/x", "a/B", "{}"], {"once": True, "values": "{}"}),
        (["topic", "pub", "-r", "5", "/x", "a/B"], {"rate": 5.0, "times": 0}),
        (["topic", "hz", "/x", "-w", "7"], {"window": 7}),
        (["service", "call", "/x", "a/srv/B", "{c: 1}"], {"values": "{c: 1}"}),
        (["action", "send_goal", "-f", "/x", "a/B", "{}"], {"feedback": True, "goal": "{}"}),
        (["param", "set", "/n", "p", "-1.5"], {"parameter_name": "p", "value": "-1.5"}),
        (["param", "list"], {"node_name": None}),
        (["lifecycle", "set", "/n", "activate"], {"transition": "activate"}),
        (["interface", "show", "a/msg/B"], {"type": "a/msg/B"}),
        (["node", "info", "/n", "--no-daemon", "--spin-time", "2"], {"spin_time": 2.0}),
    ],
)
def test_words_become_arguments(words: list[str], expected: dict[str, object]) -> None:
    arguments = vars(build_parser().parse_args(words))
    assert {name: arguments[name] for name in expected} == expected


@pytest.mark.parametrize(
    "words",
    [
        ["topic", "hz"],
        ["topic", "hz", "/x", "--window", "0"],
        ["topic", "pub", "/x", "a/B", "--once", "--times", "3"],
        ["topic", "pub", "/x", "a/B", "--rate", "0"],
        ["topic", "echo", "/x", "--qos-reliability", "good"],
        ["nope"],
    ],
)
def test_wrong_words_end_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert "usage: ros2" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ([], "  topic      Various topic related sub-commands\n"),
        (["--use-python-default-buffering"], "  topic      Various topic related sub-commands\n"),
        (["topic"], "  bw     Display bandwidth used by topic\n"),
        (["topic"], "\n  Call `ros2 topic <command> -h` for more detailed usage.\n"),
    ],
)
def test_without_a_verb_the_help_is_printed(
    words: list[str], line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 0
    out = capsys.readouterr().out
    assert "\nCommands:\n" in out
    assert line in out


def _program(folder: Path) -> Path:
    folder.mkdir()
    path = folder / "ros2"
    path.write_text("#!/bin/sh\n")
    path.chmod(0o755)
    return path


@pytest.mark.parametrize(
    ("on_path", "environment", "is_run"),
    [
        (["own", "real"], {"ROS_DISTRO": "jazzy"}, True),
        (["own"], {"ROS_DISTRO": "jazzy"}, False),
        (["real"], {}, False),
        (["real"], {"ROS_DISTRO": "jazzy", "ARJUNA_ROS2_HANDED_ON": "1"}, False),
    ],
)
def test_another_ros2_is_run_where_its_ros_is_sourced(
    on_path: list[str], environment: dict[str, str], is_run: bool, tmp_path: Path
) -> None:
    real, own = _program(tmp_path / "real"), _program(tmp_path / "own")
    path = ":".join(str(tmp_path / name) for name in on_path)
    assert real_ros2({**environment, "PATH": path}, own) == (str(real) if is_run else None)


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ("daemon stop", 0, "The daemon is not running\n"),
        ("component list", 0, ""),
        ("component types", 0, ""),
        ("component load /container nav2_amcl nav2_amcl::AmclNode", 1, "There are no containers"),
        ("component unload /container 1", 1, "There are no containers: each node is a process"),
    ],
)
def test_what_ros2_has_processes_for_and_this_one_has_not(
    words: str, code: int, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words.split()) == code
    captured = capsys.readouterr()
    assert (captured.err if code else captured.out).startswith(said)


def test_a_datagram_is_sent_and_received(capsys: pytest.CaptureFixture[str]) -> None:
    nothing = argparse.Namespace()
    listening = threading.Thread(target=multicast.receive, args=(nothing,), daemon=True)
    listening.start()
    for _ in range(100):
        multicast.send(nothing)
        listening.join(0.1)
        if not listening.is_alive():
            break
    assert re.search(r"Received from [0-9.]+:[0-9]+: 'Hello World!'\n", capsys.readouterr().out)


def test_doctors_hello_counts_who_greets(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    taken, rounds = list[Callable[[String], None]](), itertools.count()

    def greet(seconds: float) -> None:
        if next(rounds) == 12:
            raise KeyboardInterrupt
        taken[0](String(data="hello, it's me far"))
        multicast._send("hello, it's me near", None)

    node = Mock(create_subscription=lambda kind, topic, take, depth: taken.append(take))
    client = SimpleNamespace(node=node, pause=greet)
    monkeypatch.setattr(multicast, "Client", lambda **given: nullcontext(client))
    ticks = itertools.count(0.0, 0.1)
    monkeypatch.setattr(multicast, "time", SimpleNamespace(monotonic=lambda: next(ticks)))
    assert main(["doctor", "hello"]) == 0
    printed = capsys.readouterr().out
    sent = r"Topic: /canyouhearme, Published Msg Count: \d+\nSubscribed from:\n.*\n +far +\d+ +\n"
    assert re.search(sent, printed)
    assert re.search(r"225.0.0.1/49150, Sent.*\nReceived from:\n.*\n +near +\d+ +\n-+\n", printed)


def test_ros2_test_is_launch_test(monkeypatch: pytest.MonkeyPatch) -> None:
    started = Mock()
    monkeypatch.setattr(os, "execv", started)
    main(["test", "--package-name", "robot", "run.test.py", "use_sim_time:=true"])
    words = "-m launch_testing.launch_test --package-name robot run.test.py use_sim_time:=true"
    assert started.call_args.args[1][1:] == words.split()


def test_pub_waits_for_all_who_listen_and_until_they_have_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    done, met = list[str](), iter([True, True, False])
    publisher = SimpleNamespace(
        get_subscription_count=lambda: 1,
        publish=lambda message: done.append(message.data),
        wait_for_all_acked=lambda limit: done.append("had"),
    )

    def another(*given: object, **named: object) -> bool:
        done.append("looked")
        return next(met)

    node = Mock(create_publisher=lambda *given: publisher)
    client = SimpleNamespace(node=node, pause=lambda seconds: None, run_until=another)
    monkeypatch.setattr(send, "Client", lambda *given: nullcontext(client))
    main(["topic", "pub", "--once", "/late", "std_msgs/msg/String", "{data: sent}"])
    assert done == ["looked", "looked", "looked", "sent", "had"]


def test_an_unknown_program_names_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "tf2_rso", "tf2_echo"]) == 1
    printed = capsys.readouterr().err
    assert printed.startswith(
        "Package 'tf2_rso' not found; did you mean 'tf2_ros'?; 'ros2 run FILE"
    )


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Return the words of the commands of Arjuna that would have been started."""
    commands: list[list[str]] = []
    for module in (forward, launch):
        monkeypatch.setattr(module, "arjuna", lambda name, rest: commands.append([name, *rest]))
    return commands


def test_ros_arguments_are_parted_from_a_program_s_own() -> None:
    words = "-f a --ros-args --remap /cmd_vel:=/b -p stamped:=true -p speed:=0.5 -- -t c"
    assert ros_arguments(words.split()) == RosArguments(
        ["-f", "a", "-t", "c"],
        {"cmd_vel": "/b"},
        {"stamped": "true", "speed": "0.5"},
    )
    words = "a --ros-args --params-file p.yaml --log-level x:=debug --log-level warn -e -- b"
    assert ros_arguments(words.split()) == RosArguments(
        ["a", "b"], files=["p.yaml"], level="warn", unused=["-e"]
    )


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            "run teleop_twist_keyboard teleop_twist_keyboard --ros-args -r cmd_vel:=/x"
            " -p speed:=0.2",
            "teleop --keys twist --timeout 1e9 --topic /x --speed 0.2 --turn 1.0",
        ),
        ("run nav2_map_server map_saver_cli -f maps/room", "save-map maps/room --timeout 10.0"),
        (
            "run nav2_map_server map_saver_cli -f a --occ 65 --fmt png --ros-args -r map:=/plan",
            "save-map a --timeout 10.0 --topic /plan --occ 65 --fmt png",
        ),
        (
            "run foxglove_bridge foxglove_bridge --ros-args -p port:=8799 -p address:=0.0.0.0",
            "view --foxglove --port 8799 --host 0.0.0.0",
        ),
        ("run slam_toolbox async_slam_toolbox_node", "slam"),
        (
            "run slam_toolbox sync_slam_toolbox_node --ros-args --params-file s.yaml"
            " -p use_sim_time:=false -r scan:=/front -r __ns:=/a -r map:=/m --log-level debug",
            "slam --params s.yaml --use-sim-time false --scan-topic /front --namespace /a"
            " --remap map:=/m --param synchronous:=true --log-level debug",
        ),
        (
            "run slam_toolbox localization_slam_toolbox_node --ros-args -p map_file_name:=room",
            "slam --param map_file_name:=room --param mode:=localization",
        ),
        ("run slam_toolbox lifelong_slam_toolbox_node", "slam --param mode:=lifelong"),
        ("run slam_toolbox map_and_localization_slam_toolbox_node", "slam"),
        ("launch nav2_bringup bringup_launch.py map:=m.yaml", "nav --map m.yaml"),
        (
            "launch nav2_bringup bringup_launch.py map:=m.yaml params_file:=p.yaml"
            " use_sim_time:=false",
            "robot --map m.yaml --params p.yaml",
        ),
        (
            "launch nav2_bringup bringup_launch.py map:=m.yaml params_file:=p.yaml"
            " use_sim_time:=True",
            "nav --use-sim-time true --map m.yaml --params p.yaml",
        ),
        ("launch nav2_bringup bringup_launch.py slam:=True map:=m.yaml", "nav --slam"),
        (
            "launch slam_toolbox online_async_launch.py slam_params_file:=s.yaml autostart:=true",
            "slam --params s.yaml",
        ),
        (
            "launch slam_toolbox online_sync_launch.py use_sim_time:=False",
            "slam --param synchronous:=true --use-sim-time false",
        ),
        ("launch slam_toolbox offline_launch.py", "slam --param synchronous:=true"),
        (
            "launch slam_toolbox localization_launch.py slam_params_file:=s.yaml",
            "slam --param mode:=localization --params s.yaml",
        ),
        (
            "launch slam_toolbox lifelong_launch.py use_sim_time:=true",
            "slam --param mode:=lifelong",
        ),
        (
            "launch nav2_bringup slam_launch.py params_file:=p.yaml use_sim_time:=false",
            "slam --param synchronous:=true --use-sim-time false --params p.yaml",
        ),
        (
            "launch nav2_bringup navigation_launch.py use_sim_time:=false params_file:=p.yaml",
            "robot --without-localization --params p.yaml",
        ),
        (
            "launch nav2_bringup bringup_launch.py use_localization:=False namespace:=/a"
            " log_level:=warn",
            "nav --without-localization --namespace /a --log-level warn",
        ),
        (
            "launch turtlebot4_navigation localization.launch.py map:=m.yaml params:=p.yaml",
            "nav --without-navigation --map m.yaml --params p.yaml",
        ),
        (
            "launch turtlebot4_navigation nav2.launch.py use_sim_time:=true namespace:=a",
            "nav --without-localization --namespace a",
        ),
        (
            "launch turtlebot4_navigation slam.launch.py sync:=false params:=p.yaml",
            "slam --param synchronous:=true --params p.yaml --param synchronous:=false",
        ),
        (
            "launch turtlebot4_viz view_robot.launch.py namespace:=a model:=lite",
            "view --namespace a",
        ),
        (
            "launch nav2_bringup rviz_launch.py namespace:=a rviz_config:=x.rviz",
            "view --namespace a --config x.rviz",
        ),
        ("launch gazebo_ros gazebo.launch.py world:=w.world", "run gazebo_ros gzserver w.world"),
        ("launch gazebo_ros gazebo.launch.py verbose:=false gui:=false", "run gazebo_ros gzserver"),
        (
            "launch ros_gz_sim gz_sim.launch.py gz_args:=-r\\ empty.sdf gz_version:=8",
            "run ros_gz_sim gzserver -r empty.sdf",
        ),
        ("launch turtlebot3_cartographer cartographer.launch.py", "slam"),
        (
            "launch nav2_collision_monitor collision_monitor_node.launch.py params_file:=p.yaml",
            "run nav2_collision_monitor collision_monitor --ros-args --params-file p.yaml",
        ),
        (
            "launch turtlebot3_gazebo turtlebot3_world.launch.py x_pose:=1 y_pose:=0.5",
            f"sim --robot {_BURGER} --world {_PILLARS} --at 1 0.5",
        ),
        (
            "launch turtlebot3_gazebo turtlebot3_world.launch.py",
            f"sim --robot {_BURGER} --world {_PILLARS} --at -2 -0.5",
        ),
        ("doctor --report --json", "doctor --json"),
    ],
)
def test_words_become_a_command_of_arjuna(
    words: str, expected: str, started: list[list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    main(shlex.split(words))
    assert started == [expected.split()]
    assert "no effect" not in capsys.readouterr().out
    if started[0][0] != "run":
        parse(started[0])


@pytest.mark.parametrize("option", [["--prefix", "env A=1 nice"], ["--prefix=env A=1 nice"]])
def test_a_program_runs_below_a_prefix(
    option: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    execvp = Mock(side_effect=KeyboardInterrupt)
    monkeypatch.setattr(os, "execvp", execvp)
    assert main(["run", *option, "tf2_ros", "tf2_echo", "a", "b"]) == 0
    words = execvp.call_args.args[1]
    assert words[:3] == ["env", "A=1", "nice"]
    assert words[-5:] == ["run", "tf2_ros", "tf2_echo", "a", "b"]
    assert main(["run", "--prefix", "no_debugger -x", "tf2_ros", "tf2_echo"]) == 1
    assert capsys.readouterr().err == "--prefix: there is no program 'no_debugger'\n"


@pytest.mark.parametrize(
    ("words", "expected", "unused"),
    [
        (
            "slam_toolbox online_async_launch.py autostart:=false use_lifecycle_manager:=true",
            "slam",
            ["no effect: autostart:=false (nodes start", "no effect: use_lifecycle_manager:=true"],
        ),
        (
            "nav2_bringup localization_launch.py map:=m.yaml use_composition:=True",
            "nav --without-navigation --map m.yaml",
            ["no effect: use_composition:=True (each group of nodes is one process)"],
        ),
        (
            "nav2_bringup navigation_launch.py map:=m.yaml mapp:=m.yaml --debug",
            "nav --without-localization",
            ["map:=m.yaml (unknown argument", "mapp:=m.yaml (unknown", "--debug (unknown option"],
        ),
        (
            "nav2_bringup bringup_launch.py map:=m.yaml namespace:=a use_namespace:=false",
            "nav --map m.yaml",
            ["no effect: namespace (use_namespace is false)"],
        ),
        (
            "nav2_bringup bringup_launch.py mpa:=m.yaml slam:=true use_respawn:=False",
            "nav --slam",
            ["mpa:=m.yaml (unknown argument; did you mean 'map'?)", "use_respawn:=False"],
        ),
    ],
)
def test_what_a_launch_file_s_command_has_no_use_for_is_said(
    words: str,
    expected: str,
    unused: list[str],
    started: list[list[str]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    main(["launch", *words.split()])
    assert started == [expected.split()]
    printed = capsys.readouterr().out
    assert f"$ python -m bringup {expected}\n" in printed
    assert all(word in printed for word in unused)
    assert printed.count("no effect") == len(unused)
    parse(started[0])


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (
            "turtlebot3_world.launch x_pos:=0",
            [f"sim --world {_PILLARS} --robot {_BURGER} --at 0 -0.5"],
        ),
        ("turtlebot3_slam.launch slam_methods:=gmapping", ["slam"]),
        ("turtlebot3_navigation.launch map_file:=m.yaml", ["nav --map m.yaml"]),
        ("turtlebot3_teleop_key.launch", ["run teleop_twist_keyboard teleop_twist_keyboard"]),
        ("nope.launch", []),
    ],
)
def test_known_launch_files_of_ros_1_are_commands(words: str, expected: list[str]) -> None:
    file, *given = words.split()
    found = commands_of("turtlebot3", file, given)
    assert [" ".join(command) for command in found] == expected


_ARG = '<arg name="map"/>'


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (f'{_ARG}<node pkg="p" type="t" name="n" args="$(arg map)"/>', True),
        (f'{_ARG}<include file="$(find p)/launch/a.launch"/>', True),
        (f'{_ARG}<node pkg="p" exec="e" args="$(var map)"/>', False),
        (f'{_ARG}<node pkg="p" exec="e" args="$(arg map)"/>', False),
        (f'{_ARG}<include file="$(find-pkg-share p)/$(arg map)"/>', False),
    ],
)  # fmt: skip
def test_launch_files_that_mix_ros_1_into_ros_2_are_of_ros_2(
    text: str, expected: bool, tmp_path: Path
) -> None:
    (tmp_path / "a.launch.xml").write_text(f"<launch>{text}</launch>")
    assert is_ros1(tmp_path / "a.launch.xml") is expected


def test_what_a_launch_file_of_ros_1_lacks_is_its_exit_code(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "a.launch"
    path.write_text('<launch><node pkg="nowhere" type="t.py" name="n"/></launch>')
    assert main(["launch", str(path)]) == 1
    assert "nowhere t.py is not started" in capfd.readouterr().out


def test_a_parameter_file_names_the_map(tmp_path: Path, started: list[list[str]]) -> None:
    path = tmp_path / "nav2.yaml"
    path.write_text("map_server: {ros__parameters: {yaml_filename: a/room.yaml}}")
    main(["launch", "nav2_bringup", "localization_launch.py", f"params_file:={path}"])
    expected = ["nav", "--without-navigation", "--map", "a/room.yaml", "--params", str(path)]
    assert started == [expected]


@pytest.mark.parametrize(("package", "file"), LAUNCHES)
def test_every_launch_file_lists_its_arguments(
    package: str, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["launch", package, file, "--show-args"]) == 0
    printed = capsys.readouterr().out
    assert "use_sim_time" in printed
    assert "Without an effect here: " in printed


@pytest.mark.parametrize(
    "words",
    [
        "-p nav2_bringup navigation_launch.py",
        "nav2_bringup navigation_launch.py --print-description",
        "-n nav2_bringup navigation_launch.py use_sim_time:=true --print",
    ],
)
def test_a_launch_file_is_printed_instead_of_started(
    words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["launch", *words.split()]) == 0
    assert capsys.readouterr().out == "$ python -m bringup nav --without-localization\n"


def test_an_unknown_launch_file_names_those_there_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["launch", "slam_toolbox", "online_asynch_launch.py"]) == 1
    printed = capsys.readouterr().err
    assert "did you mean 'slam_toolbox online_async_launch.py'?" in printed
    assert "python -m bringup" in printed


@pytest.mark.parametrize("words", ["bag", "launch --help", "run --help"])
def test_commands_that_hand_on_have_help(words: str, capsys: pytest.CaptureFixture[str]) -> None:
    code = main(words.split())
    assert (code, capsys.readouterr().out[:12]) == (0, "usage: ros2 ")


def test_a_real_ros2_gets_none_of_our_libraries() -> None:
    ours, theirs = f"{sys.prefix}/lib/ros_rcl.libs", "/opt/ros/jazzy/lib"
    set_ = {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1", "LD_LIBRARY_PATH": f"{ours}:{theirs}"}
    assert without_wheels({**set_, "HOME": "/a"}) == {"HOME": "/a", "LD_LIBRARY_PATH": theirs}
    assert without_wheels({"LD_LIBRARY_PATH": ours}) == {}
