"""The camera sees the boxes where they are."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.devices.camera import CameraError, focal_length
from arjuna_sim.devices.sensors.camera import CameraSettings
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.simulation import Simulation
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited, simulator


def _picture(sim: Simulation) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    try:
        picture = sim.robot.picture().color
    except CameraError as error:
        pytest.skip(str(error))
    assert picture is not None
    return picture


def _depth(sim: Simulation) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    shot = sim.robot.picture(color=False, depth=True)
    assert shot.color is None
    assert shot.depth is not None
    return shot.depth


def test_red_box_stands_in_the_middle_as_wide_as_geometry_says() -> None:
    sim = simulator(ROOM)
    picture = _picture(sim).astype(int)
    sim.close()
    assert picture.shape == (480, 640, 3)
    red = (picture[:, :, 0] > 2 * picture[:, :, 1]) & (picture[:, :, 0] > 80)
    columns = np.flatnonzero(red[230])
    camera = sim.robot.model.settings.first(CameraSettings)
    assert camera is not None
    width = focal_length(camera) * 0.5 / (2.25 - 0.20)
    assert len(columns) == pytest.approx(width, abs=3)
    assert columns.mean() == pytest.approx(319.5, abs=2)


def test_camera_turns_with_the_robot() -> None:
    sim = simulator(ROOM, spawn=SE2(0.0, 0.0, 0.3))
    picture = _picture(sim).astype(int)
    sim.close()
    red = (picture[:, :, 0] > 2 * picture[:, :, 1]) & (picture[:, :, 0] > 80)
    assert np.flatnonzero(red.any(axis=0)).mean() > 400  # turned left, it stands to the right


def test_robot_without_a_camera_says_so(tmp_path: Path) -> None:
    sim = simulator(ROOM, robot=edited(ROBOT, tmp_path, 'type="camera"', 'type="thermal"'))
    assert any("'thermal' is not simulated" in note for note in sim.notes)
    with pytest.raises(CameraError, match="has no camera sensor"):
        sim.robot.picture()


def test_depth_is_the_distance_along_the_axis_and_infinite_in_the_sky() -> None:
    sim = simulator(ROOM)
    _picture(sim)  # skips where nothing can be drawn
    depth = _depth(sim)
    sim.close()
    assert depth.shape == (480, 640)
    assert depth[235, 320] == pytest.approx(2.25 - 0.20, abs=0.01)  # the red box
    assert np.isinf(depth[0]).all()


def test_camera_follows_what_is_spawned() -> None:
    sim = simulator(EMPTY)
    _picture(sim)
    far = _depth(sim)
    box = Part(Shape(Kind.BOX, (0.4, 0.4, 1.0)))
    sim.stage.spawn(Entity("crate", (box,), start=Pose3((2.0, 0.0, 0.5))))
    near = _depth(sim)
    sim.close()
    assert near[235, 320] == pytest.approx(2.0 - 0.2 - 0.2, abs=0.01)
    assert far[235, 320] > 3.0
