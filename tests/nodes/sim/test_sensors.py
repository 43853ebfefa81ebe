"""Sensors and the camera publish when somebody listens."""

from __future__ import annotations

import io
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gazebo_msgs.msg import ContactsState
from PIL import Image as Picture
from ros_gz_interfaces.msg import Altimeter, Contacts
from sensor_msgs.msg import (
    BatteryState,
    CameraInfo,
    CompressedImage,
    Image,
    Imu,
    LaserScan,
    MagneticField,
    NavSatFix,
    PointCloud2,
    Range,
)
from std_msgs.msg import Bool
from std_srvs.srv import Trigger
from tf2_msgs.msg import TFMessage

from arjuna_core.files.shipped import shipped_file
from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_core.ros.convert import time_msg
from arjuna_sim.devices.camera import Camera, CameraError, Shot
from arjuna_sim.nodes.robot_state_publisher import RobotStatePublisherNode
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start, start_sim
from tests.sim.builders import edited
from tests.sim.robot_cases import RobotMaker

BEAMS = """<ray><scan><horizontal><samples>60</samples></horizontal>{}</scan></ray>"""
ROWS = "<vertical><samples>4</samples><max_angle>0.2</max_angle></vertical>"
UP = Pose3((0.0, 0.0, 0.2))
TYPES = {
    "gps/fix": NavSatFix,
    "imu/mag": MagneticField,
    "altimeter": Altimeter,
    "bump/contacts": Contacts,
    "states": ContactsState,
    "sonar": Range,
    "top/points": PointCloud2,
    "rear/scan": LaserScan,
    "second/data": Imu,
}


@pytest.fixture
def robot(tmp_path: Path) -> str:
    """Return a robot with a sensor of each kind beside the first ones."""
    maker = RobotMaker(tmp_path)
    maker.add("navsat", "gps")
    maker.add("magnetometer", "compass")
    maker.add("altimeter", "height")
    maker.add("contact", "bump")
    states = "<bumperTopicName>states</bumperTopicName><frameName>world</frameName>"
    maker.add("contact", "old", f"<plugin filename='libgazebo_ros_bumper.so'>{states}</plugin>")
    maker.add("sonar", "sonar", pose=UP)
    maker.add("gpu_lidar", "top", BEAMS.format(ROWS) + "<topic>top</topic>", pose=UP)
    maker.add("ray", "rear", BEAMS.format(""), pose=UP)
    maker.add("imu", "second", pose=Pose3.from_rpy((0.0, 0.0, 0.0), (3.14159265, 0.0, 0.0)))
    return str(maker.write(bare=False))


def _listen(bench: RosBench, sim: Any) -> dict[str, list[Any]]:
    return {
        topic: bench.collect(kind, f"/{topic}", qos.SENSOR_SUBSCRIPTION)
        for topic, kind in TYPES.items()
    }


def test_each_sensor_publishes_its_type_at_its_rate(bench: RosBench, robot: str) -> None:
    room = str(shipped_file("worlds/arjuna_room.world"))
    sim = start_sim(bench, robot=robot, world=room)
    received = _listen(bench, sim)
    run(bench, sim, 50)
    assert {topic: len(found) for topic, found in received.items()} == dict.fromkeys(TYPES, 10)
    cloud = received["top/points"][-1]
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity", "ring"]
    assert (cloud.point_step, cloud.row_step) == (18, 18 * cloud.width)
    assert len(cloud.data) == cloud.row_step > 0
    assert cloud.header.frame_id == "top_link_top"
    assert received["second/data"][-1].linear_acceleration.z == pytest.approx(-9.81, abs=0.1)
    assert received["sonar"][-1].radiation_type == Range.ULTRASOUND
    assert not received["bump/contacts"][-1].contacts
    assert (received["states"][-1].states, received["states"][-1].header.frame_id) == ([], "world")
    assert received["altimeter"][-1].vertical_velocity == pytest.approx(0.0, abs=1e-3)
    assert np.isfinite(received["rear/scan"][-1].ranges).all()


def test_messages_name_the_frames_of_the_file_where_others_publish_those(
    bench: RosBench, robot: str
) -> None:
    sim = start_sim(bench, robot=robot, frames_of_file=True)
    received = _listen(bench, sim)
    run(bench, sim, 10)
    assert received["top/points"][-1].header.frame_id == "top_link"


def test_frames_of_sensors_off_their_links_are_published(bench: RosBench, robot: str) -> None:
    static = bench.collect(TFMessage, "/tf_static", qos.TF_STATIC)
    start(bench, RobotStatePublisherNode(bench.process, {"robot": robot}))
    found = {t.child_frame_id: t for t in static[0].transforms}
    for name in ("sonar", "top", "rear"):
        frame = found[f"{name}_link_{name}"]
        assert frame.header.frame_id == f"{name}_link"
        assert frame.transform.translation.z == pytest.approx(0.2)


def test_what_nobody_hears_is_not_read(
    bench: RosBench, robot: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sim = start_sim(bench, robot=robot)
    monkeypatch.setattr(sim.simulator.robot, "sense", lambda *_: pytest.fail("was read"))
    run(bench, sim, 20)


def test_each_camera_has_topics_of_its_own(
    bench: RosBench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    depth = np.full((480, 640), np.inf, np.float32)
    depth[240, 320] = 2.0

    def draw(self: Any, model: Any, data: Any, color: bool, depths: bool) -> Shot:
        return Shot(np.zeros((480, 640, 3), np.uint8), depth if depths else None)

    monkeypatch.setattr(Camera, "shoot", draw)
    maker = RobotMaker(tmp_path)
    for name in ("left", "right"):
        maker.add("camera", name, f"<topic>{name}/image_raw</topic>")
    maker.add("rgbd_camera", "oakd", "<topic>oakd</topic>")
    sim = start_sim(bench, robot=str(maker.write()))
    topics = ("left/image_raw", "right/image_raw", "oakd/image", "oakd/depth_image")
    images = {topic: bench.collect(Image, f"/{topic}", qos.SENSOR_SUBSCRIPTION) for topic in topics}
    clouds = bench.collect(PointCloud2, "/oakd/points", qos.SENSOR_SUBSCRIPTION)
    infos = bench.collect(CameraInfo, "/oakd/camera_info", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert {topic: len(found) for topic, found in images.items()} == dict.fromkeys(topics, 10)
    assert len(clouds) == len(infos) == 10
    assert images["right/image_raw"][0].header.frame_id == "right_link_optical_frame"
    assert images["oakd/depth_image"][0].encoding == "32FC1"
    x, y, z = np.frombuffer(bytes(clouds[0].data), "<f4")
    assert (x, y, z) == pytest.approx((0.0, 0.0, 2.0), abs=0.01)


def test_clouds_are_drawn_as_seldom_as_is_asked_while_nobody_looks_at_pictures(
    bench: RosBench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    depth = np.ones((480, 640), np.float32)
    monkeypatch.setattr(Camera, "shoot", lambda *arguments: Shot(None, depth))
    maker = RobotMaker(tmp_path)
    maker.add("rgbd_camera", "oakd", "<topic>oakd</topic>")
    sim = start_sim(bench, robot=str(maker.write()), cloud_rate=4.0)
    clouds = bench.collect(PointCloud2, "/oakd/points", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert len(clouds) == 4
    images = bench.collect(Image, "/oakd/depth_image", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert (len(images), len(clouds)) == (10, 14)


def test_a_camera_publishes_to_listeners(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> None:
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


@pytest.mark.parametrize(
    ("form", "encoding", "pixel", "inside"),
    [("L8", "mono8", (67,), "mono8"), ("B8G8R8", "bgr8", (10, 10, 200), "bgr8")],
)
def test_colours_are_written_as_the_camera_s_file_says(
    bench: RosBench,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    form: str,
    encoding: str,
    pixel: tuple[int, ...],
    inside: str,
) -> None:
    robot = edited(shipped_file("urdf/arjuna.urdf"), tmp_path, "R8G8B8", form)
    sim = start_sim(bench, robot=str(robot))
    shot = Shot(np.full((480, 640, 3), (200, 10, 10), np.uint8), None)
    monkeypatch.setattr(Camera, "shoot", lambda *_: shot)
    images = bench.collect(Image, "/camera/image_raw", qos.SENSOR_SUBSCRIPTION)
    topic = "/camera/image_raw/compressed"
    pictures = bench.collect(CompressedImage, topic, qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 5)
    assert (images[0].encoding, images[0].step) == (encoding, 640 * len(pixel))
    assert tuple(images[0].data[: len(pixel)]) == pixel
    assert pictures[0].format == f"{encoding}; jpeg compressed {inside}"
    with Picture.open(io.BytesIO(bytes(pictures[0].data))) as picture:
        assert picture.mode == ("L" if encoding == "mono8" else "RGB")
        seen = np.asarray(picture, int)[240, 320]
    assert np.abs(seen - (67 if encoding == "mono8" else np.array((200, 10, 10)))).max() < 5


def test_pictures_are_compressed_for_who_listens(
    bench: RosBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As image_transport has them."""
    sim = start_sim(bench)
    shot = Shot(np.full((480, 640, 3), (200, 10, 10), np.uint8), None)
    monkeypatch.setattr(Camera, "shoot", lambda *_: shot)
    topic = "/camera/image_raw/compressed"
    pictures = bench.collect(CompressedImage, topic, qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 5)
    assert pictures[0].format == "rgb8; jpeg compressed bgr8"
    with Picture.open(io.BytesIO(bytes(pictures[0].data))) as picture:
        assert (picture.format, picture.size) == ("JPEG", (640, 480))
        assert np.abs(np.asarray(picture, int)[240, 320] - (200, 10, 10)).max() < 5


def test_a_camera_without_opengl_is_off(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_pictures_do_not_delay_real_time(bench: RosBench, monkeypatch: pytest.MonkeyPatch) -> None:
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


_BATTERY = """<gazebo><plugin filename="gz-sim-linearbatteryplugin-system"
name="gz::sim::systems::LinearBatteryPlugin"><battery_name>pack</battery_name><voltage>12</voltage>
<initial_charge>0.5</initial_charge><capacity>1</capacity><power_load>12</power_load>
<smooth_current_tau>0.01</smooth_current_tau><enable_recharge>true</enable_recharge>
<charging_time>0.1</charging_time><recharge_by_topic>true</recharge_by_topic>
<power_draining_topic>/work</power_draining_topic>
<stop_power_draining_topic>/rest</stop_power_draining_topic></plugin></gazebo></robot>"""


def test_batteries_are_filled_and_drained_by_services_and_topics(
    bench: RosBench, tmp_path: Path
) -> None:
    path = RobotMaker(tmp_path).write()
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("</robot>", _BATTERY), encoding="utf-8")
    sim = start_sim(bench, robot=str(path))
    base = "/model/arjuna/battery/pack"
    states = bench.collect(BatteryState, f"{base}/state", qos.SENSOR_SUBSCRIPTION)

    def status() -> tuple[int, float]:
        run(bench, sim, 10)
        return states[-1].power_supply_status, round(states[-1].current, 1)

    charging, draining = (
        getattr(BatteryState, f"POWER_SUPPLY_STATUS_{word}") for word in ("CHARGING", "DISCHARGING")
    )
    resting = BatteryState.POWER_SUPPLY_STATUS_NOT_CHARGING, 0.0
    assert status() == resting
    bench.publish(Bool, "/work", Bool(), qos.DEFAULT)
    assert status() == (draining, -1.0)
    assert bench.call(Trigger, f"{base}/recharge/start", Trigger.Request()).success
    assert status() == (charging, 9.0)
    bench.publish(Bool, "/rest", Bool(), qos.DEFAULT)
    assert status() == (charging, 10.0)
    bench.publish(Bool, f"{base}/recharge/stop", Bool(), qos.DEFAULT)
    assert status()[0] == resting[0]
