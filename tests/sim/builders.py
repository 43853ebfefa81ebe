"""Robots, worlds and simulators for the tests of arjuna_sim."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from arjuna_core.errors import RobotError, WorldError
from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.config import SimulatorConfig
from arjuna_sim.driven_robot import Observation
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.world_file import load_world
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import Note
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.model.settings import S
from arjuna_sim.simulation import Simulation, solo

ROOT = Path(__file__).resolve().parents[2]
ROBOT = ROOT / "urdf" / "arjuna.urdf"
ROOM = ROOT / "worlds" / "arjuna_room.world"
EMPTY = ROOT / "worlds" / "empty.world"


def simulator(
    world: Path = EMPTY,
    config: SimulatorConfig | None = None,
    seed: int = 0,
    spawn: SE2 | None = None,
    robot: Path = ROBOT,
) -> Simulation:
    """Build a simulation of one robot; config chooses what is noise-free or uncalibrated."""
    starts, rng = solo(load_robot(robot), spawn), np.random.default_rng(seed)
    return Simulation(starts, load_world(world), config or SimulatorConfig(), rng)


def run(sim: Simulation, seconds: float, command: Velocity | None = None) -> Observation:
    """Step for a time, repeating a command; return the last observation."""
    for _ in range(round(seconds / sim.config.tick)):
        last = sim.drive(command)
    return last


def first(robot: RobotModel, kind: type[S]) -> S:
    """Return a robot's first sensor of a kind, which must be there."""
    found = robot.settings.first(kind)
    assert found is not None
    return found


def texts(notes: Iterable[Note]) -> tuple[str, ...]:
    """Return what a person reads of notes."""
    return tuple(note.text for note in notes)


def urdf_file(inside: str = "") -> XmlFile:
    """Return a robot's file of some tags, which exists nowhere."""
    return XmlFile(Path("r.urdf"), "robot", RobotError, f"<robot>{inside}</robot>".encode())


def sdf_file(inside: str = "", version: str = "1.9") -> XmlFile:
    """Return a world's file of some tags, which exists nowhere."""
    text = f"<sdf version='{version}'>{inside}</sdf>"
    return XmlFile(Path("w.sdf"), "sdf", WorldError, text.encode())


def saved_world(folder: Path, inside: str) -> Path:
    """Write a world of some models; return its path."""
    path = folder / "test.world"
    path.write_text(f"<sdf version='1.9'><world name='w'>{inside}</world></sdf>", encoding="utf-8")
    return path


def static(name: str, shape: str, pose: str) -> str:
    """Return a model of one solid shape that stands fast."""
    solid = f"<collision name='c'><geometry>{shape}</geometry></collision>"
    return (
        f"<model name='{name}'><static>1</static><pose>{pose}</pose>"
        f"<link name='l'>{solid}</link></model>"
    )


def edited(source: Path, folder: Path, old: str, new: str) -> Path:
    """Copy a text file with one passage replaced, which must be there."""
    text = source.read_text(encoding="utf-8")
    assert old in text
    target = folder / source.name
    target.write_text(text.replace(old, new, 1), encoding="utf-8")
    return target
