"""Pictures are drawn for who looks, and beside the physics in real time."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
import pytest
from sensor_msgs.msg import CameraInfo, Image

from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_sim.devices.camera import Camera, CameraError, Shot
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim


def test_camera_publishes_only_for_who_looks(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = start_sim(bench)
    drawn: list[float] = []

    def draw(self: Any, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        drawn.append(sim.simulator.time)
        assert color
        return Shot(
            np.zeros((480, 640, 3), np.uint8), np.ones((480, 640), np.float32) if depth else None
        )

    monkeypatch.setattr(Camera, "shoot", draw)
    run(bench, sim, 10)
    assert drawn == []
    images = bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    infos = bench.collect(CameraInfo, "/camera/camera_info", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert len(images) == len(infos) == len(drawn) == 30
    assert (images[0].encoding, images[0].step) == ("rgb8", 1920)
    assert images[0].header.frame_id == "camera_link_optical_frame"
    assert infos[0].header.frame_id == images[0].header.frame_id
    assert infos[0].k[2] == 320.0
    depths = bench.collect(Image, "/camera/depth/image_raw", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert (len(images), len(depths), len(drawn)) == (60, 30, 60)  # one shot for both
    assert (depths[0].encoding, depths[0].step, len(depths[0].data)) == (
        "32FC1", 2560, 2560 * 480
    )  # fmt: skip


def test_camera_that_cannot_draw_is_switched_off_and_nothing_else(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = start_sim(bench)
    tries: list[float] = []

    def fail(*arguments: Any) -> Any:
        tries.append(sim.simulator.time)
        raise CameraError("no off-screen OpenGL works")

    monkeypatch.setattr(Camera, "shoot", fail)
    bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 20)
    assert len(tries) == 1
    assert sim.simulator.time == 0.4


def test_in_real_time_pictures_are_drawn_beside_the_physics(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A picture that takes long holds no tick up, and comes with the stamp of what it shows."""
    sim = start_sim(bench)
    start, go_on = threading.Event(), threading.Event()

    def draw(self: Any, model: Any, data: Any, color: bool, depth: bool) -> Shot:
        start.set()
        assert go_on.wait(10.0)
        return Shot(np.zeros((480, 640, 3), np.uint8), None)

    monkeypatch.setattr(Camera, "shoot", draw)
    images = bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    sim.realtime_due(0.0)
    run(bench, sim, 20)
    assert start.wait(10.0)
    assert images == []
    assert sim.simulator.time == 0.4
    go_on.set()
    while not images:
        run(bench, sim, 1)
        assert sim.simulator.time < 100.0
    assert images[0].header.stamp == time_msg(0.04)
    sim.trigger_deactivate()
    sim.trigger_cleanup()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("camera")]
