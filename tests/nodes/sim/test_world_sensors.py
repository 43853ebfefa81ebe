"""Sensors of a world's models publish on their topics, wherever their model is."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import Twist, Vector3
from ros_gz_interfaces.msg import Contacts
from sensor_msgs.msg import CameraInfo, Image, LaserScan
from std_msgs.msg import Float64

from arjuna_core.pose3 import Pose3
from arjuna_core.ros import qos
from arjuna_sim.files.world_file import load_world
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim
from tests.sim.builders import simulator, texts

GROUND = "<include><uri>model://ground_plane</uri></include>"
BOX = "<collision name='c'><geometry><box><size>.2 .2 .2</size></box></geometry></collision>"
LIDAR = (
    "<sensor name='eye' type='lidar'><pose>0 0 .3 0 0 0</pose><update_rate>10</update_rate>"
    "{}<lidar><scan><horizontal><samples>3</samples><min_angle>-1.5707963</min_angle>"
    "<max_angle>1.5707963</max_angle></horizontal></scan><range><min>.05</min><max>20</max></range>"
    "</lidar></sensor>"
)
PRISM = (
    "<polyline><point>-.04 -.04</point><point>.04 -.04</point><point>.04 .04</point>"
    "<point>-.04 .04</point><height>1</height></polyline>"
)
CAMERA = (
    "<sensor name='lens' type='camera'><update_rate>10</update_rate><topic>street</topic><camera>"
    "<image><width>64</width><height>48</height></image></camera>"
    "<plugin name='p' filename='libgazebo_ros_camera.so'/></sensor>"
)


def model(name: str, pose: str, inside: str, static: bool = True) -> str:
    return (
        f"<model name='{name}'><static>{int(static)}</static><pose>{pose}</pose>"
        f"<link name='l'>{inside}</link></model>"
    )


def world_of(folder: Path, *models: str) -> Path:
    path = folder / "w.world"
    path.write_text(f"<sdf version='1.9'><world name='w'>{GROUND}{''.join(models)}</world></sdf>")
    return path


def test_topics_frames_and_poses_are_the_files(tmp_path: Path) -> None:
    odd = "<sensor name='odd' type='sonic'/>"
    moving = model("cart", "3 0 .1 0 0 0", BOX + LIDAR.format("<topic>seen</topic>"), static=False)
    world = load_world(
        world_of(tmp_path, model("pole 1", "1 2 0 0 0 1", LIDAR.format("") + odd + CAMERA), moving)
    )
    lidar, camera, other = world.sensors
    assert [each.settings.topic for each in world.sensors] == ["pole_1/scan", "street", "seen"]
    assert lidar.settings.frame == lidar.settings.site == "pole 1::l::eye"
    assert lidar.T_world.position == pytest.approx((1.0, 2.0, 0.3))
    assert other.T_model.position == pytest.approx((0.0, 0.0, 0.3))
    assert other.T_world.position == pytest.approx((3.0, 0.0, 0.4))
    assert camera.model == "pole 1"
    assert [note for note in texts(world.notes) if "simulated" in note] == [
        "sensor 'odd': type 'sonic' is not simulated",
    ]


def test_a_contact_sensor_feels_what_its_model_touches(bench: RosBench, tmp_path: Path) -> None:
    """The robot at a wall, as it stands there and after it was moved; a crate's own ground."""
    inside = "<contact><collision>c</collision></contact>"
    touch = f"<sensor name='touch' type='contact'>{inside}</sensor>"
    wall = model("wall", ".8 0 0 0 0 0", BOX.replace(".2 .2 .2", ".2 9 2") + touch)
    crate = model("crate", "-2 0 .1 0 0 0", BOX + touch, static=False)
    sim = start_sim(bench, world=str(world_of(tmp_path, wall, crate)))
    felt = bench.collect(Contacts, "/wall/touch/contacts", qos.SENSOR_SUBSCRIPTION)
    ground = bench.collect(Contacts, "/crate/touch/contacts", qos.SENSOR_SUBSCRIPTION)

    def touching() -> set[tuple[str, str]]:
        for _ in range(100):
            bench.publish(Twist, "/cmd_vel", Twist(linear=Vector3(x=0.5)), qos.LATEST)
            run(bench, sim, 1)
        pairs = [(c.collision1.name, c.collision2.name) for c in felt[-1].contacts]
        return {(own, other.partition("::")[0]) for own, other in pairs}

    run(bench, sim, 5)
    assert felt[-1].contacts == []
    assert ground[-1].contacts[0].collision2.name.startswith("ground_plane::")
    assert touching() == {("wall::link::collision", "robot")}
    sim.simulator.stage.move("wall", Pose3((1.6, 0.0, 0.0)))
    run(bench, sim, 5)
    assert felt[-1].contacts == []
    assert touching() == {("wall::link::collision", "robot")}


def test_readings_follow_a_model_that_is_moved(bench: RosBench, tmp_path: Path) -> None:
    wall = model("wall", "4 0 0 0 0 0", BOX.replace(".2 .2 .2", ".2 9 2"))
    watcher = model("watcher", "2 0 0 0 0 0", BOX + LIDAR.format(""))
    cart = model("cart", "2 3 .1 0 0 0", BOX + LIDAR.format("<topic>seen</topic>"), static=False)
    sim = start_sim(bench, world=str(world_of(tmp_path, wall, watcher, cart)))
    scans = bench.collect(LaserScan, "/watcher/scan", qos.SENSOR_SUBSCRIPTION)
    seen = bench.collect(LaserScan, "/seen", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 25)
    assert scans[-1].header.frame_id == "watcher::l::eye"
    assert scans[-1].ranges[1] == pytest.approx(1.9, abs=0.05)
    assert np.isinf([scans[-1].ranges[0], scans[-1].ranges[2]]).all()
    assert seen[-1].ranges[1] == pytest.approx(1.9, abs=0.05)
    for name, y in (("watcher", -1.0), ("cart", 1.0)):
        sim.simulator.stage.move(name, Pose3((1.0, y, 0.1)))
    run(bench, sim, 15)
    assert scans[-1].ranges[1] == pytest.approx(2.9, abs=0.05)
    assert seen[-1].ranges[1] == pytest.approx(2.9, abs=0.05)
    sim.simulator.stage.delete("watcher")
    run(bench, sim, 15)
    other = world_of(tmp_path, wall, watcher.replace("2 0 0 0 0 0", "0 2 0 0 0 0"))
    sim.simulator.load_world(load_world(other))
    run(bench, sim, 15)
    assert scans[-1].ranges[1] == pytest.approx(3.9, abs=0.05)


def test_camera_of_the_world_sees_it(bench: RosBench, tmp_path: Path) -> None:
    red = BOX.replace("collision", "visual").replace(
        "</visual>", "<material><diffuse>1 0 0 1</diffuse></material></visual>"
    )
    board = model("board", "2 0 .5 0 0 0", red.replace(".2 .2 .2", ".1 3 3"))
    sim = start_sim(
        bench, world=str(world_of(tmp_path, board, model("pole", "0 0 1 0 0 0", CAMERA)))
    )
    images = bench.collect(Image, "/street", qos.SENSOR_SUBSCRIPTION)
    infos = bench.collect(CameraInfo, "/camera_info", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 15)
    picture = np.frombuffer(images[-1].data, np.uint8).reshape(48, 64, 3).astype(int)
    middle = picture[24, 32]
    assert middle[0] > 2 * middle[1] + 20
    assert infos[-1].width == 64


def test_a_mover_is_commanded_by_its_topic_also_of_a_world_that_is_loaded(
    bench: RosBench, tmp_path: Path
) -> None:
    plugin = "<plugin filename='gz-sim-velocity-control-system' name='v'/></model>"
    mover = model("{}", "0 3 .1 0 0 0", BOX, static=False).replace("</model>", plugin)
    sim = start_sim(bench, world=str(world_of(tmp_path, mover.format("cart"))))

    def moved(name: str) -> float:
        before = sim.simulator.stage.motion(name).pose.position[0]
        for _ in range(50):
            bench.publish(Twist, f"/model/{name}/cmd_vel", Twist(linear=Vector3(x=0.5)), qos.LATEST)
            run(bench, sim, 1)
        return sim.simulator.stage.motion(name).pose.position[0] - before

    assert moved("cart") == pytest.approx(0.5, abs=0.05)
    sim.simulator.stage.load(load_world(world_of(tmp_path, mover.format("van"))))
    assert moved("van") == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize("shape", ["<box><size>.08 .08 2</size></box>", PRISM])
def test_a_lidar_of_the_world_sees_out_of_its_housing(tmp_path: Path, shape: str) -> None:
    """Its beams begin at its least range, beyond which it sees its own model too."""
    wall = BOX.replace("'c'>", "'w'><pose>0 2 0 0 0 0</pose>").replace(".2 .2 .2", "1 .2 2")
    housing = f"<collision name='c'><geometry>{shape}</geometry></collision>"
    inside = housing + wall + LIDAR.format("")
    sim = simulator(world_of(tmp_path, model("post", "9 9 0 0 0 0", inside)))
    scan = sim.fixed.sense(sim.fixed.settings[0], 0.0)
    assert scan.ranges == pytest.approx((np.inf, np.inf, 1.9))


def test_topics_that_ros_cannot_spell_are_published_as_it_can(
    bench: RosBench, tmp_path: Path
) -> None:
    eyes = LIDAR.format("<topic>front-eye/0/scan</topic>"), LIDAR.format("")
    models = [model(f"{i}-pole", f"2 {i} 0 0 0 0", BOX + eye) for i, eye in enumerate(eyes)]
    sim = start_sim(bench, world=str(world_of(tmp_path, *models)))
    scans = bench.collect(LaserScan, "/front_eye/_0/scan", qos.SENSOR_SUBSCRIPTION)
    below = bench.collect(LaserScan, "/_1_pole/scan", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 25)
    assert scans
    assert below


def test_a_joint_of_a_model_turns_by_its_plugins_topic(bench: RosBench, tmp_path: Path) -> None:
    plugin = "<plugin filename='gz-sim-joint-controller-system' name='c'><joint_name>j</joint_name>"
    turntable = model("table", "0 3 .1 0 0 0", BOX, static=False).replace(
        "</model>",
        "<joint name='j' type='continuous'><parent>world</parent><child>l</child>"
        f"<axis><xyz>0 0 1</xyz></axis></joint>{plugin}</plugin></model>",
    )
    sim = start_sim(bench, world=str(world_of(tmp_path, turntable)))
    bench.publish(Float64, "/model/table/joint/j/cmd_vel", Float64(data=0.5), qos.LATEST)
    run(bench, sim, 100)
    (name,) = sim.simulator.stage.world.motors
    assert sim.simulator.stage.motion(name).pose.planar().theta == pytest.approx(1.0, abs=0.05)
