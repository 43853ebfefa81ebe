"""Pace of the simulator: without ROS, through ROS in lock-step, by beams and by boxes."""

from __future__ import annotations

import argparse
import importlib.util
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco

from arjuna_core.twist import Velocity
from arjuna_sim.simulation import Simulation
from tests.sim.builders import ROBOT, ROOM, edited, simulator

_BEAMS = (90, 180, 360, 720, 1440, 2880)
_BOXES = (10, 30, 100, 300, 1000)
_PUSHABLE, _ACTORS = 100, 30
_REPEATS = 3
_SENSORS = "physics, lidar 10 Hz, IMU 50 Hz, odometry 50 Hz"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add this benchmark's options."""
    parser.add_argument(
        "--seconds",
        type=float,
        default=30.0,
        metavar="S",
        help="simulated time a run (%(default)s)",
    )


def run(arguments: argparse.Namespace) -> dict[str, Any]:
    """Measure simulated seconds per second of one core, the best of three runs each.

    Returns:
        `core_real_time_factor` and `ros_real_time_factor` (None without rclpy) of the shipped robot
        in the shipped room, `mujoco_real_time_factor` of MuJoCo alone on the same model and path,
        and the core's factor `by_beams` and `by_boxes`, among 100 boxes that can be pushed and
        among 30 actors.
    """
    seconds = arguments.seconds
    print(f"simulated per real second on one core; {_SENSORS}")
    core, alone = paired_factors(simulator(ROOM), seconds)
    _show("without ROS", core)
    _show("mj_step alone, same path", alone)
    ros = _ros_factor(seconds) if importlib.util.find_spec("rclpy") else None
    if ros is None:
        print("through ROS       skipped: rclpy is not installed")
    else:
        _show("through ROS, lock-step", ros)
    with tempfile.TemporaryDirectory() as folder:
        beams = {n: _core_factor(_with_beams(n, Path(folder)), seconds) for n in _BEAMS}
        _table("beams in the shipped room", beams)
        boxes = {n: _core_factor(_with_boxes(n, Path(folder)), seconds) for n in _BOXES}
        _table("boxes, 360 beams", boxes)
        pushed = _core_factor(_with_boxes(_PUSHABLE, Path(folder), pushable=True), seconds)
        _show(f"{_PUSHABLE} boxes to be pushed", pushed)
        people = _core_factor(_with_actors(_ACTORS, Path(folder)), seconds)
        _show(f"{_ACTORS} actors", people)
    return {
        "core_real_time_factor": core,
        "mujoco_real_time_factor": alone,
        "ros_real_time_factor": ros,
        "by_beams": beams,
        "by_boxes": boxes,
        "pushable_boxes_real_time_factor": pushed,
        "actors_real_time_factor": people,
    }


def paired_factors(sim: Simulation, seconds: float) -> tuple[float, float]:
    """Return the simulated per CPU time of the core, and of MuJoCo with the same controls."""
    model, data, controls = sim.stage.scene.model, sim.stage.data, []
    for i in range(round(seconds / sim.config.tick)):
        sim.drive(_command(i))
        controls.append(data.ctrl.copy())

    def physics(i: int) -> None:
        data.ctrl[:] = controls[i]
        mujoco.mj_step(model, data, nstep=sim.config.substeps)

    core = alone = 0.0
    for _ in range(_REPEATS):
        sim.reset()
        core = max(core, _once(lambda i: sim.drive(_command(i)), seconds, sim.config.tick))
        sim.reset()
        alone = max(alone, _once(physics, seconds, sim.config.tick))
    return core, alone


def _core_factor(sim: Simulation, seconds: float) -> float:
    return _best(lambda i: sim.drive(_command(i)), seconds, sim.config.tick)


def _ros_factor(seconds: float) -> float:
    """Measure the sim's nodes, commanded each tick, with subscribers of all but the camera."""
    from geometry_msgs.msg import Twist
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import Imu, JointState, LaserScan

    from bringup.lockstep import LockStep
    from bringup.parameters.files import shipped_parameters
    from bringup.stack import SIM_GROUP

    lockstep = LockStep(shipped_parameters())
    topics = {"odom": Odometry, "scan": LaserScan, "imu/data": Imu, "joint_states": JointState}
    for topic, kind in topics.items():
        lockstep.client.create_subscription(kind, topic, lambda message: None, 10)
    commands = lockstep.client.create_publisher(Twist, "cmd_vel", 1)

    def step(i: int) -> None:
        message = Twist()
        message.linear.x, message.angular.z = _command(i).x, _command(i).yaw_rate
        commands.publish(message)
        lockstep.step()

    try:
        lockstep.start(SIM_GROUP)
        return _best(step, seconds, lockstep.sim.config.tick)
    finally:
        lockstep.close()


def _best(step: Callable[[int], object], seconds: float, tick: float) -> float:
    """Return simulated time per processor time of the fastest run."""
    return max(_once(step, seconds, tick) for _ in range(_REPEATS))


def _once(step: Callable[[int], object], seconds: float, tick: float) -> float:
    count, start = round(seconds / tick), time.process_time()
    for i in range(count):
        step(i)
    return count * tick / (time.process_time() - start)


def _command(i: int) -> Velocity:
    """Drive circles that stay in the room."""
    return Velocity(0.4, yaw_rate=0.6 + 0.3 * math.sin(i / 200))


def _with_beams(count: int, folder: Path) -> Simulation:
    old, new = "<samples>360</samples>", f"<samples>{count}</samples>"
    return simulator(ROOM, robot=edited(ROBOT, folder, old, new))


def _with_actors(count: int, folder: Path) -> Simulation:
    """Let people walk to and fro beside the robot's path."""
    actors = "".join(
        f"<actor name='a{i}'><script><trajectory id='0' type='walk'>"
        f"<waypoint><time>0</time><pose>3 {0.7 * i - 10} 0 0 0 0</pose></waypoint>"
        f"<waypoint><time>5</time><pose>8 {0.7 * i - 10} 0 0 0 0</pose></waypoint>"
        "</trajectory></script></actor>"
        for i in range(count)
    )
    return simulator(_written(folder / f"{count}_actors.world", actors))


def _with_boxes(count: int, folder: Path, pushable: bool = False) -> Simulation:
    """Put boxes on a square grid of 1.5 m around the start, which stays free."""
    side = math.ceil(math.sqrt(count + 9))
    cells = [(i - side // 2, j - side // 2) for i in range(side) for j in range(side)]
    free = [cell for cell in cells if max(abs(cell[0]), abs(cell[1])) > 1][:count]
    models = "".join(_box(i, 1.5 * x, 1.5 * y, not pushable) for i, (x, y) in enumerate(free))
    return simulator(_written(folder / f"{count}_boxes.world", models))


def _written(path: Path, inside: str) -> Path:
    ground = "<include><uri>model://ground_plane</uri></include>"
    path.write_text(f'<sdf version="1.6"><world name="made">{ground}{inside}</world></sdf>')
    return path


def _box(number: int, x: float, y: float, static: bool) -> str:
    geometry = "<geometry><box><size>0.5 0.5 0.6</size></box></geometry>"
    return (
        f'<model name="box_{number}"><static>{str(static).lower()}</static>'
        f"<pose>{x} {y} 0.3 0 0 0</pose>"
        f'<link name="link"><collision name="collision">{geometry}</collision></link></model>'
    )


def _show(what: str, factor: float) -> None:
    print(f"{what:<28}{factor:8.1f} x")


def _table(what: str, factors: dict[int, float]) -> None:
    print(f"{what}:")
    for count, factor in factors.items():
        _show(f"  {count}", factor)
