"""Cameras: their tags, plugins and pictures."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_core.se2 import SE2
from arjuna_sim.devices.camera import CameraError, focal_length
from arjuna_sim.devices.lens import Lens, distorted
from arjuna_sim.devices.sensors.camera import CameraSettings, read_camera, read_depth_camera
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.entities import Entity
from arjuna_sim.model.geometry.shapes import Kind, Part, Shape
from arjuna_sim.simulation import Simulation
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited, first, simulator, texts, urdf_file

TOPICS = ("topic", "depth_topic", "cloud_topic", "info_topic")


def read(inside: str = "", depth: bool = False, kind: str = "camera") -> CameraSettings:
    """Return what a sensor's tags say."""
    return read_with_notes(inside, depth, kind)[0]


def read_with_notes(
    inside: str, depth: bool = False, kind: str = "camera"
) -> tuple[CameraSettings, tuple[str, ...]]:
    xml = urdf_file(f"<sensor name='eye' type='{kind}'>{inside}</sensor>")
    (found,) = (read_depth_camera if depth else read_camera)(SensorTag(xml, xml.root[0], "head"))
    return found, texts(xml.notes)


def test_what_no_tag_says_is_as_in_gazebo() -> None:
    found = read()
    assert (found.width, found.height, found.horizontal_fov) == (640, 480, 1.047)
    assert (found.near, found.far, found.rate) == (0.05, 100.0, 30.0)
    assert (found.link, found.frame, found.name, found.depth) == ("head", "head", "eye", False)


def test_tags_say_size_view_and_distances() -> None:
    image = "<image><width>320</width><height>200</height></image>"
    inside = f"<horizontal_fov>2.0</horizontal_fov>{image}<clip><near>0.2</near><far>9</far></clip>"
    found = read(f"<camera>{inside}</camera><update_rate>5</update_rate>", depth=True)
    assert (found.width, found.height, found.horizontal_fov) == (320, 200, 2.0)
    assert (found.near, found.far, found.rate, found.depth) == (0.2, 9.0, 5.0, True)


_CLIP = "<clip><near>0.3</near><far>8</far></clip>"


@pytest.mark.parametrize(
    ("inside", "depth", "reach"),
    [
        ("", True, (0.0, math.inf)),
        (f"<camera><depth_camera>{_CLIP}</depth_camera></camera>", True, (0.3, 8.0)),
        ("<plugin><min_depth>0.4</min_depth><max_depth>3</max_depth></plugin>", True, (0.4, 3.0)),
        ("<plugin><pointCloudCutoff>0.5</pointCloudCutoff></plugin>", True, (0.5, math.inf)),
        (f"<camera><depth_camera>{_CLIP}</depth_camera></camera>", False, (0.0, math.inf)),
    ],
)
def test_distances_have_a_reach_of_their_own(
    inside: str, depth: bool, reach: tuple[float, float]
) -> None:
    found = read(inside, depth)
    assert (found.depth_near, found.depth_far) == reach
    assert (found.near, found.far) == (0.05, 100.0)
    assert found.details().endswith(f" {max(0.05, reach[0]):g} to {min(100.0, reach[1]):g} m")


@pytest.mark.parametrize(
    ("tag", "value", "problem"),
    [
        ("image/width", "1", ""),
        ("image/width", "4096", ""),
        ("image/height", "1", ""),
        ("image/height", "4096", ""),
        ("image/width", "0", r"image is 0 x 480; valid: 1 to 4096 pixels"),
        ("image/width", "4097", r"image is 4097 x 480; valid"),
        ("image/height", "0", r"image is 640 x 0; valid"),
        ("image/height", "4097", r"image is 640 x 4097; valid"),
        ("clip/near", "0", r"0.0 to 100.0 must be 0 < near < far"),
        ("clip/near", "99.9", ""),
        ("clip/near", "100", r"must be 0 < near < far"),
        ("clip/far", "0.05", r"must be 0 < near < far"),
        ("horizontal_fov", "0", r"valid: above 0, up to 2 pi"),
        ("horizontal_fov", "0.001", ""),
        ("horizontal_fov", str(2.0 * math.pi), ""),
        ("horizontal_fov", "6.29", r"valid: above 0, up to 2 pi"),
    ],
)
def test_values_end_at_their_bounds(tag: str, value: str, problem: str) -> None:
    outer, _, inner = tag.partition("/")
    content = f"<{inner}>{value}</{inner}>" if inner else value
    inside = f"<camera><{outer}>{content}</{outer}></camera>"
    if not problem:
        read(inside)
        return
    with pytest.raises(RobotError, match=problem):
        read(inside)


@pytest.mark.parametrize(("angle", "seen"), [(2.8, 2.8), (2.81, 2.8), (6.2, 2.8), (1.5, 1.5)])
def test_a_fish_eye_sees_what_a_flat_picture_can_hold(angle: float, seen: float) -> None:
    tag = f"<camera><horizontal_fov>{angle}</horizontal_fov></camera>"
    found, notes = read_with_notes(tag)
    assert found.horizontal_fov == seen
    cut = f"sensor 'eye': <horizontal_fov> {angle:g} is cut to 2.8, as it has no lens"
    assert notes == ((cut,) if seen != angle else ())


def plugin(inside: str) -> str:
    return f"<plugin name='p' filename='libgazebo_ros_camera.so'>{inside}</plugin>"


NAMED, REMAPPED = "<camera_name>left</camera_name>", "<ros>{}</ros>"
SPACE, WHOLE = "<namespace>/r1</namespace>", "<remapping>{}:={}</remapping>"
IMAGE = "<imageTopicName>{}</imageTopicName>"
DEPTH = "<depthImageTopicName>{}</depthImageTopicName>"
CLOUD = "<pointCloudTopicName>{}</pointCloudTopicName>"


@pytest.mark.parametrize(
    ("depth", "inside", "given"),
    [
        (False, "", {"topic": "camera/image_raw"}),
        (True, "", {"topic": "camera/image_raw", "cloud_topic": "camera/points"}),
        (False, plugin(NAMED), {"topic": "left/image_raw"}),
        (
            True,
            plugin(NAMED),
            {
                "topic": "left/image_raw",
                "depth_topic": "left/depth/image_raw",
                "cloud_topic": "left/points",
            },
        ),
        (False, plugin(NAMED + IMAGE.format("rgb")), {"topic": "left/rgb"}),
        (False, plugin(NAMED + IMAGE.format("/rgb")), {"topic": "/rgb"}),
        (False, plugin(IMAGE.format("rgb")), {"topic": "rgb"}),
        (
            True,
            plugin(IMAGE.format("rgb") + DEPTH.format("far") + CLOUD.format("dots")),
            {"topic": "rgb", "depth_topic": "far", "cloud_topic": "dots"},
        ),
        (
            True,
            plugin(NAMED + DEPTH.format("/far") + CLOUD.format("dots")),
            {"topic": "left/image_raw", "depth_topic": "/far", "cloud_topic": "left/dots"},
        ),
        # a remapping names the topic whole; ~ is the plug-in, which is seldom named as its camera
        (
            False,
            plugin(REMAPPED.format(WHOLE.format("image_raw", "seen"))),
            {"topic": "eye/image_raw"},
        ),
        (
            False,
            plugin(NAMED + REMAPPED.format(WHOLE.format("~/image_raw", "front/rgb"))),
            {"topic": "left/image_raw"},
        ),
        (
            False,
            plugin(
                "<camera_name>p</camera_name>"
                + REMAPPED.format(WHOLE.format("~/image_raw", "~/rgb"))
            ),
            {"topic": "p/rgb"},
        ),
        (
            False,
            plugin(NAMED + REMAPPED.format(WHOLE.format("/left/image_raw", "seen"))),
            {"topic": "seen", "info_topic": "left/camera_info"},
        ),
        (False, plugin(""), {"topic": "eye/image_raw"}),
        (False, plugin(NAMED + REMAPPED.format(SPACE)), {"topic": "/r1/left/image_raw"}),
        (False, plugin(REMAPPED.format(SPACE)), {"topic": "/r1/eye/image_raw"}),
        (
            False,
            plugin(NAMED + REMAPPED.format(SPACE + WHOLE.format("left/image_raw", "front/rgb"))),
            {"topic": "/r1/front/rgb", "info_topic": "/r1/left/camera_info"},
        ),
        (
            True,
            plugin(
                NAMED
                + REMAPPED.format(
                    WHOLE.format("left/image_raw", "/rgb/image_raw")
                    + WHOLE.format("left/camera_info", "/rgb/camera_info")
                    + WHOLE.format("left/depth/image_raw", "/far/image_raw")
                )
            ),
            {
                "topic": "/rgb/image_raw",
                "depth_topic": "/far/image_raw",
                "cloud_topic": "left/points",
            },
        ),
        (
            False,
            "<topic>__default_topic__</topic>" + plugin(NAMED),
            {"topic": "left/image_raw"},
        ),
    ],
)
def test_plugins_join_the_camera_and_its_picture(
    depth: bool, inside: str, given: dict[str, str]
) -> None:
    assert topics(read(inside, depth)) == given


def test_names_of_ros_1_do_not_count_in_a_file_of_ros_2() -> None:
    """As in gazebo_ros, which then names the camera as its sensor."""
    old = "<cameraName>robot/head</cameraName><frameName>lens</frameName>" + IMAGE.format("rgb")
    found, _ = read_with_notes(plugin(old))
    assert (found.topic, found.frame) == ("robot/head/rgb", "lens")
    found, notes = read_with_notes(plugin(old + REMAPPED.format(SPACE)))
    assert (found.topic, found.frame) == ("/r1/eye/image_raw", "head")
    assert "<cameraName>, <frameName>, <imageTopicName>: of ROS 1, not read by" in notes[0]


@pytest.mark.parametrize(
    ("kind", "depth", "given"),
    [
        ("camera", False, {"topic": "eye/left"}),
        (
            "depth_camera",
            True,
            {
                "topic": "eye/left/image",
                "depth_topic": "eye/left",
                "cloud_topic": "eye/left/points",
            },
        ),
        (
            "rgbd_camera",
            True,
            {
                "topic": "eye/left/image",
                "depth_topic": "eye/left/depth_image",
                "cloud_topic": "eye/left/points",
                "info_topic": "eye/left/camera_info",
            },
        ),
    ],
)
def test_gz_makes_all_topics_of_one(kind: str, depth: bool, given: dict[str, str]) -> None:
    assert topics(read("<topic> eye/left </topic>", depth, kind)) == given
    named = "<camera><camera_info_topic> lens </camera_info_topic></camera><topic>eye/left</topic>"
    assert topics(read(named, depth, kind)) == given | {"info_topic": "lens"}


def test_the_optical_frame_is_named_before_others() -> None:
    frames = "<gz_frame_id>/body</gz_frame_id>{}<camera/>"
    assert read(frames.format("")).frame == "body"
    optical = "<camera><optical_frame_id>/lens</optical_frame_id></camera>"
    assert read(frames.format(optical)).frame == "lens"


def topics(found: CameraSettings) -> dict[str, Any]:
    """Return the topics."""
    return {key: name for key in TOPICS if (name := getattr(found, key))}


def _picture(sim: Simulation) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    try:
        picture = sim.robot.picture(first(sim.robot.model, CameraSettings)).color
    except CameraError as error:
        pytest.skip(str(error))
    assert picture is not None
    return picture


def _depth(sim: Simulation) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    shot = sim.robot.picture(first(sim.robot.model, CameraSettings), color=False, depth=True)
    assert shot.color is None
    assert shot.depth is not None
    return shot.depth


def test_red_box_stands_in_the_middle_as_wide_and_far_as_geometry_says() -> None:
    """A depth is the distance along the axis, and infinite in the sky."""
    sim = simulator(ROOM)
    picture = _picture(sim).astype(int)
    depth = _depth(sim)
    sim.close()
    assert depth.shape == (480, 640)
    assert depth[235, 320] == pytest.approx(2.25 - 0.20, abs=0.01)
    assert np.isinf(depth[0]).all()
    assert picture.shape == (480, 640, 3)
    red = (picture[:, :, 0] > 2 * picture[:, :, 1]) & (picture[:, :, 0] > 80)
    columns = np.flatnonzero(red[230])
    camera = sim.robot.model.settings.first(CameraSettings)
    assert camera is not None
    width = focal_length(camera) * 0.5 / (2.25 - 0.20)
    assert len(columns) == pytest.approx(width, abs=3)
    assert columns.mean() == pytest.approx(319.5, abs=2)


def test_noise_of_the_file_is_that_of_each_pixel_and_the_same_each_time(tmp_path: Path) -> None:
    noise = "<camera><noise><type>gaussian</type><stddev>0.02</stddev></noise>"
    robot = edited(ROBOT, tmp_path, "<camera>", noise)
    plain, first, again = (simulator(ROOM, robot=one) for one in (ROBOT, robot, robot))
    ideal, one, other = (_picture(sim) for sim in (plain, first, again))
    first.drive()
    error = one.astype(int)[240:] - ideal[240:]
    assert error.std() == pytest.approx(0.02 * 255, rel=0.05)
    assert abs(error.mean()) < 0.1
    assert np.array_equal(one, other)
    assert not np.array_equal(_picture(first), one)
    for sim in (plain, first, again):
        sim.close()


@pytest.mark.parametrize(
    ("inside", "depth", "encoding", "note"),
    [
        ("", False, "rgb8", None),
        ("<image><format>L8</format></image>", False, "mono8", None),
        ("<image><format>bgr_int8</format></image>", False, "bgr8", None),
        ("<image><format>L16</format></image>", False, "rgb8", "<format> L16: its pictures are"),
        ("<image><format>R_FLOAT32</format></image>", True, "rgb8", None),
        ("<lens><type>gnomonical</type></lens>", False, "rgb8", None),
        ("<lens><type>stereographic</type></lens>", False, "rgb8", "<lens>: its pictures are"),
        ("<lens><intrinsics/></lens>", False, "rgb8", "<lens>: its pictures are"),
        (
            "<triggered>true</triggered>",
            False,
            "rgb8",
            "<triggered>: it takes pictures at its rate",
        ),
    ],
)
def test_colours_are_written_as_the_file_says(
    inside: str, depth: bool, encoding: str, note: str | None
) -> None:
    found, notes = read_with_notes(f"<camera>{inside}</camera>", depth)
    assert found.encoding == encoding
    assert [bool(note and note in each) for each in notes] == [True] * (note is not None)


LENS = "<camera><distortion>{}</distortion></camera>"


def test_lens_is_what_the_file_says() -> None:
    tags = "<k1>-.2</k1><k2>.1</k2><k3>.01</k3><p1>.002</p1><p2>.003</p2>"
    assert read(LENS.format(tags)).distortion == (-0.2, 0.1, 0.002, 0.003, 0.01)
    assert read(LENS.format("<k1>0.0</k1>")).distortion == ()
    (depth,) = read_with_notes(LENS.format(tags), depth=True)[1]
    assert "are those of an ideal lens" in depth
    (middle,) = read_with_notes(LENS.format(f"{tags}<center>0.4 0.5</center>"))[1]
    assert "the picture's middle" in middle


@pytest.mark.parametrize(
    "distortion",
    [
        *((-0.3, 0.1, 0.0, 0.0, 0.0), (0.2, 0.0, 0.0, 0.0, 0.0), (-0.1, 0.0, 0.01, -0.02, 0.0)),
        (-0.25, 0.05, -0.002, 0.001, -0.01),
    ],
    ids=["barrel", "cushion", "skewed", "all"],
)
def test_lens_shows_points_where_its_formula_says(distortion: tuple[float, ...]) -> None:
    settings = replace(read(), width=160, height=120, distortion=distortion)
    lens, f = Lens(settings, focal_length(settings)), focal_length(settings)
    rows, columns = np.mgrid[: lens.height, : lens.width] + 0.5
    ideal = np.stack((columns - lens.width / 2, rows - lens.height / 2)) / f
    shown = distorted(ideal, distortion) * f + np.array([80.0, 60.0])[:, None, None]
    scaled = np.stack((*shown, np.ones_like(rows)), axis=-1)
    picture = lens.picture(np.clip(scaled, 0, 255).astype(np.uint8)).astype(float)
    rows, columns = np.mgrid[:120, :160] + 0.5
    black = (picture == 0).all(axis=-1)
    assert not black.any()
    assert np.abs(picture[..., 0] - columns)[~black].max() < 1.6
    assert np.abs(picture[..., 1] - rows)[~black].max() < 1.6


def test_red_box_is_where_the_lens_shows_it(tmp_path: Path) -> None:
    barrel = "<camera><distortion><k1>-0.3</k1></distortion>"
    robot = edited(ROBOT, tmp_path, "<camera>", barrel)
    wide: list[Any] = []
    depths: list[Any] = []
    for one in (ROBOT, robot):
        sim = simulator(ROOM, robot=one, spawn=SE2(0.0, 0.0, 0.3))
        picture = _picture(sim).astype(int)
        depths.append(_depth(sim))
        sim.close()
        red = (picture[:, :, 0] > 2 * picture[:, :, 1]) & (picture[:, :, 0] > 80)
        wide.append(np.flatnonzero(red[230])[[0, -1]])
        assert np.mean(wide[-1]) > 400  # turned left, it stands to the right
    camera = sim.robot.model.settings.first(CameraSettings)
    assert camera is not None
    f = focal_length(camera)
    ideal = (np.array(wide[0]) + 0.5 - 320) / f
    moved = distorted(np.stack((ideal, np.full(2, (230.5 - 240) / f))), camera.distortion)
    assert wide[1] == pytest.approx(moved[0] * f + 320 - 0.5, abs=2)
    assert abs(wide[1][1] - wide[0][1]) > 5  # it does something
    assert np.array_equal(*depths)  # of an ideal lens


def test_unknown_camera_is_none_and_noted(tmp_path: Path) -> None:
    sim = simulator(ROOM, robot=edited(ROBOT, tmp_path, 'type="camera"', 'type="thermal"'))
    assert any("'thermal' is not simulated" in note for note in sim.notes)
    assert sim.robot.model.settings.first(CameraSettings) is None


def test_no_distance_is_beyond_its_reach(tmp_path: Path) -> None:
    clip = "<camera><depth_camera><clip><near>1</near><far>2</far></clip></depth_camera>"
    text = ROBOT.read_text("utf-8").replace('type="camera"', 'type="depth"')
    short = tmp_path / "short.urdf"
    short.write_text(text.replace("<camera>", clip, 1), "utf-8")
    seen = []
    for sim in (simulator(ROOM), simulator(ROOM, robot=short)):
        _picture(sim)
        seen.append(_depth(sim))
        sim.close()
    wide, cut = seen
    assert wide.min() < 1.0 < 2.0 < wide[np.isfinite(wide)].max()
    expected = np.where(wide < 1.0, -np.inf, np.where(wide > 2.0, np.inf, wide))
    assert np.array_equal(cut, expected)


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
