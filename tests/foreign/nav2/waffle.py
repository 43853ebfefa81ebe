"""A TurtleBot3 Waffle in TurtleBot3's world, with Nav2's own parameter file, in lock-step."""

from __future__ import annotations

from pathlib import Path

from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from bringup.cli import parse
from bringup.lockstep import LockStep
from bringup.parameters.files import merged
from bringup.parameters.inputs import gather
from bringup.scenarios.drive import placed
from bringup.stack import LOCALIZATION_GROUP, NAVIGATION_GROUP, SIM_GROUP
from tests.helpers.nav.stock_files import nav2_file

START = SE2(-2.0, -0.5, 0.0)
"""Where TurtleBot3's launch files put the robot."""
_BURGER_AS_WAFFLE = {
    'name="burger"': 'name="waffle"',
    'xyz="-0.032 0 0.070"': 'xyz="-0.064 0 0.047"',
    'size="0.14 0.14 0.14"': 'size="0.266 0.266 0.094"',
    'mass value="0.82"': 'mass value="1.37"',
    'ixx="0.0022" iyy="0.0021" izz="0.0020"': 'ixx="0.0091" iyy="0.0091" izz="0.0161"',
    'xyz="0 0.08 0.023"': 'xyz="0 0.144 0.023"',
    'xyz="0 -0.08 0.023"': 'xyz="0 -0.144 0.023"',
    'xyz="-0.081 0 -0.005"': 'xyz="-0.177 0 -0.005"',
    'xyz="-0.032 0 0.172"': 'xyz="-0.064 0 0.122"',
    'xyz="-0.032 0 0.068"': 'xyz="0 0 0.068"',
    "<wheel_separation>0.160<": "<wheel_separation>0.287<",
    "<effectiveTrackWidth>0.1611<": "<effectiveTrackWidth>0.287<",
    "<max_linear_velocity>0.22<": "<max_linear_velocity>0.26<",
}
"""The Waffle's dimensions and masses, of TurtleBot3's data sheet, in place of the Burger's."""


def waffle(folder: Path) -> Path:
    """Write the Waffle's URDF."""
    text = shipped_file("urdf/burger.urdf").read_text(encoding="utf-8")
    for burger, own in _BURGER_AS_WAFFLE.items():
        assert burger in text, burger
        text = text.replace(burger, own)
    path = folder / "waffle.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def in_its_world(folder: Path, text: str = "") -> LockStep:
    """Return the robot with localization and navigation active; it does not know where it is.

    Args:
        folder: Where its files go.
        text: Its parameter file; Nav2's own if empty.
    """
    file = folder / "nav2_params.yaml"
    file.write_text(text or nav2_file(), encoding="utf-8")
    words = ["--robot", str(waffle(folder)), "--params", str(file)]
    where = ["--map", str(shipped_file("maps/pillar_arena.yaml"))]
    parameters = merged(gather(parse(["nav", *where, *words])), placed(START))
    sim = {"sim": {"world": str(shipped_file("worlds/pillar_arena.world"))}}
    robot = LockStep(merged(parameters, sim), strict=True)
    robot.start(SIM_GROUP, LOCALIZATION_GROUP, NAVIGATION_GROUP)
    robot.run(1.0)
    return robot
