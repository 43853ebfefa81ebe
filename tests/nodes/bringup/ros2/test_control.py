"""`ros2 control` and the spawners print and do what ros2controlcli's do, beside a simulated arm."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from nav_msgs.msg import Odometry

from arjuna_core.files.shipped import shipped_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.grammar import build_parser, load
from bringup.ros2.programs import spawner
from bringup.ros2.verbs import control
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim
from tests.sim.arms import CONTROLLERS, write_arm
from tests.sim.drive_cases import Robot, four
from tests.sim.drive_cases import control as controlled


class BenchClient:
    """Calls services within the process under test."""

    def __init__(self, bench: RosBench) -> None:
        self._bench = bench

    def __enter__(self) -> BenchClient:
        return self

    def __exit__(self, *error: object) -> None:
        return None

    def call(self, kind: Any, name: str, request: Any, timeout: float) -> Any:
        return self._bench.call(kind, name, request)


@pytest.fixture
def ros2(bench: RosBench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], None]:
    path = write_arm(tmp_path, CONTROLLERS)
    start_sim(bench, robot=str(path), world=str(shipped_file("worlds/empty.world")))
    for module in (control, spawner):
        monkeypatch.setattr(module, "Client", lambda *given: BenchClient(bench))

    def run(line: str) -> None:
        arguments: argparse.Namespace = build_parser().parse_args(["control", *line.split()])
        load(arguments.run)(arguments)

    return run


def test_controllers_are_listed_in_columns(
    ros2: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    ros2("list_controllers --claimed-interfaces")
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].split() == [
        *("arm_controller", "joint_trajectory_controller/JointTrajectoryController", "active")
    ]
    assert lines[1:3] == ["\tclaimed interfaces:", "\t\tshoulder/position"]
    ros2("list_hardware_interfaces")
    assert "\tfinger/position [available] [claimed]" in capsys.readouterr().out.splitlines()
    ros2("list_hardware_components")
    assert "\tname: arm_system\n" in capsys.readouterr().out
    ros2("list_controller_types")
    assert "controller_interface::ControllerInterface" in capsys.readouterr().out


def test_a_controller_goes_through_its_states(
    ros2: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    ros2("set_controller_state arm_controller inactive")
    ros2("unload_controller arm_controller")
    for _ in range(2):  # as launch files ask for what the robot's start has done
        ros2("load_controller arm_controller --set-state active")
    ros2("switch_controllers --deactivate arm_controller --activate positions --strict")
    assert capsys.readouterr().out.splitlines() == [
        "Successfully deactivated arm_controller",
        "Successfully unloaded arm_controller",
        "Successfully loaded arm_controller",
        "Successfully configured arm_controller",
        "Successfully activated arm_controller",
        "Controller arm_controller is active already",
        "Successfully switched controllers",
    ]
    with pytest.raises(Ros2Error, match="'arm_controller' wants joints that 'positions' commands"):
        ros2("set_controller_state arm_controller active")
    with pytest.raises(Ros2Error, match="Error loading controller nobody"):
        ros2("load_controller nobody")
    with pytest.raises(Ros2Error, match="Error loading controller positions"):
        ros2("load_controller positions")
    with pytest.raises(Ros2Error, match="a controller is loaded"):
        ros2("reload_controller_libraries")
    ros2("reload_controller_libraries --force-kill")
    ros2("list_controllers")
    assert "No controllers are currently loaded!" in capsys.readouterr().out


def test_spawners_bring_controllers_up_and_down(
    ros2: Callable[[str], None], capsys: pytest.CaptureFixture[str]
) -> None:
    spawner.main(["gripper", "speeds", "-c", "controller_manager"])
    spawner.unspawn(["gripper"])
    spawner.main(["gripper", "--inactive"])
    ros2("list_controllers")
    out = capsys.readouterr().out
    assert "Controller gripper is active already\nSuccessfully activated speeds\n" in out
    found = {line.split()[0]: line.split()[-1] for line in out.splitlines()[-6:]}
    assert (found["speeds"], found["gripper"], found["arm_controller"]) == (
        *("active", "inactive", "inactive"),
    )


def test_in_a_launch_file_a_manager_may_be_long_in_starting(
    bench: RosBench, ros2: Callable[[str], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    waited: list[float] = []

    class Timed(BenchClient):
        def call(self, kind: Any, name: str, request: Any, timeout: float) -> Any:
            waited.append(timeout)
            return super().call(kind, name, request, timeout)

    monkeypatch.setattr(control, "Client", lambda *given: Timed(bench))
    monkeypatch.delenv("ARJUNA_LAUNCHED", raising=False)
    ros2("list_controllers")
    monkeypatch.setenv("ARJUNA_LAUNCHED", "1")
    ros2("list_controllers")
    assert waited == [10.0, 60.0]


def test_a_spawner_says_what_it_waits_for(
    bench: RosBench,
    ros2: Callable[[str], None],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.delenv("ARJUNA_LAUNCHED", raising=False)

    class Late(BenchClient):
        def call(self, kind: Any, name: str, request: Any, timeout: float) -> Any:
            if timeout <= 10.0:
                raise Ros2Error("timed out")
            return super().call(kind, name, request, timeout)

    monkeypatch.setattr(spawner, "Client", lambda *given: Late(bench))
    spawner.main(["gripper"])
    first, *rest = capsys.readouterr().out.splitlines()
    assert first.startswith("waiting for controller_manager/list_controllers: 'arjuna sim")
    assert rest == ["Controller gripper is active already"]
    with pytest.raises(Ros2Error, match="timed out"):
        spawner.main(["gripper", "--controller-manager-timeout", "5"])


def test_a_spawner_s_remaps_rename_the_drive_s_topics(
    bench: RosBench,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    tag, files = controlled(
        "controller_manager: {ros__parameters: {wheels: {type:"
        " diff_drive_controller/DiffDriveController}}}\n"
        "wheels: {ros__parameters: {wheel_separation: 0.28, wheel_radius: 0.06,"
        " left_wheel_names: [front_left_wheel_joint, rear_left_wheel_joint],"
        " right_wheel_names: [front_right_wheel_joint, rear_right_wheel_joint]}}\n"
    )
    path = Robot(four(), tag, files=files).write(tmp_path, "robot.urdf")
    world = str(shipped_file("worlds/empty.world"))
    sim = start_sim(bench, robot=str(path), world=world, fused_odometry=False)
    monkeypatch.setattr(spawner, "Client", lambda *given: BenchClient(bench))
    rules = "-r /wheels/cmd_vel:=/cmd_vel --remap ~/odom:=/moved -r ~/tf:=/tf"
    spawner.main(["wheels", "--controller-ros-args", rules])
    said = "no effect: wheels: no topic of the drive: ~/tf:=/tf\n"
    assert said in capsys.readouterr().out
    seen = bench.collect(Odometry, "/moved")
    forward = TwistStamped(twist=Twist(linear=Vector3(x=0.3)))
    for _ in range(20):
        bench.publish(TwistStamped, "/cmd_vel", forward)
        run(bench, sim, 1)
    assert seen[-1].twist.twist.linear.x > 0.1


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        ([], "controller_manager"),  # below the namespace of its node
        (["-n", "/r1"], "/r1/controller_manager"),
        (["-c", "/r2/controller_manager"], "/r2/controller_manager"),
    ],
)
def test_a_spawner_asks_the_manager_of_its_namespace(
    words: list[str], asked: str, bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Refusing(BenchClient):
        def call(self, kind: Any, name: str, request: Any, timeout: float) -> Any:
            raise Ros2Error(name)

    monkeypatch.setattr(spawner, "Client", lambda *given: Refusing(bench))
    with pytest.raises(Ros2Error, match=f"^{asked}/list_controllers$"):
        spawner.main(["wheels", *words])
