"""Lidars, sonars and infrared sensors: what their tags say, at the edge of what is valid."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from arjuna_core.errors import RobotError
from arjuna_core.pose3 import Pose3
from arjuna_sim.devices.sensors.lidar import (
    CloudSettings,
    LidarSettings,
    RangeSettings,
    read_lidar,
    read_sonar,
    surroundings,
)
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.model.settings import SensorSettings
from arjuna_sim.model.urdf import Urdf
from tests.sim.builders import texts, urdf_file

HALF_PI = math.pi / 2
URDF = Urdf(Path("r.urdf"), "r", "", "mast")


def element(inside: str, kind: str = "x") -> SensorTag:
    xml = urdf_file(f"<sensor name='s' type='{kind}'>{inside}</sensor>")
    return SensorTag(xml, xml.root[0], "mast")


def read(inside: str) -> list[SensorSettings]:
    return read_lidar(element(inside))


def one(inside: str) -> LidarSettings:
    (found,) = read(inside)
    assert isinstance(found, LidarSettings)
    return found


def ray(horizontal: str = "", vertical: str = "", ranges: str = "", more: str = "") -> str:
    scan = f"<horizontal>{horizontal}</horizontal><vertical>{vertical}</vertical>"
    return f"<ray><scan>{scan}</scan><range>{ranges}</range></ray>{more}"


def samples(count: int, low: float = -1.0, high: float = 1.0) -> str:
    given = f"<min_angle>{low}</min_angle><max_angle>{high}</max_angle>"
    return f"<samples>{count}</samples>{given}"


def test_a_lidar_that_says_nothing_looks_all_around() -> None:
    found = one("")
    assert type(found) is LidarSettings
    assert (found.samples, found.angle_min, found.angle_max) == (360, -math.pi, math.pi)
    assert (found.range_min, found.range_max, found.noise) == (0.1, 10.0, 0.0)
    assert (found.link, found.rate, found.topic, found.name) == ("mast", 10.0, "scan", "s")
    noisy = one(ray(samples(90, -0.5, 0.7), "", "<min>0.2</min><max>1e9</max>"))
    assert (noisy.samples, noisy.angle_min, noisy.angle_max) == (90, -0.5, 0.7)
    assert (noisy.range_min, noisy.range_max) == (0.2, 1e4)


@pytest.mark.parametrize("kind", ["ray", "gpu_ray", "lidar", "gpu_lidar"])
def test_those_of_a_graphics_card_see_what_is_drawn(kind: str) -> None:
    for found in read_lidar(element(ROWS, kind)):
        assert isinstance(found, LidarSettings)
        assert found.rendered == kind.startswith("gpu")


@pytest.mark.parametrize("outer", ["{}", "<plugin filename='libmaker.so'>{}</plugin>"])
@pytest.mark.parametrize("tag", ["ray", "lidar"])
def test_rays_have_either_name_and_may_stand_in_a_plugin(outer: str, tag: str) -> None:
    frame = "<ignition_frame_id>/eye</ignition_frame_id>"
    given = ray(samples(30), samples(4, -0.1, 0.1)).replace("ray>", f"{tag}>") + frame
    found = read(outer.format(given))[0]
    assert isinstance(found, LidarSettings)
    assert (found.samples, found.frame) == (30, "eye")
    assert isinstance(found, CloudSettings) == (outer == "{}")  # a plugin's rows are cut to one


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        (ray(samples(0)), "<samples> times <resolution> is 0; valid: 1 to 100000"),
        (ray(samples(100_001)), "<samples> times <resolution> is 100001; valid"),
        (ray(samples(2, 1.0, 1.0)), "<min_angle> 1.0 must be below <max_angle> 1.0"),
        (ray(ranges="<min>-0.1</min>"), "<range> -0.1 to 10.0 must be 0 <= min < max"),
        (ray(ranges="<min>2</min><max>2</max>"), "<range> 2.0 to 2.0 must be"),
        (ray(samples(50_001), samples(2)), "has 50001 x 2 samples; valid: up to 100000"),
        (ray("", samples(2, 0.2, 0.1)), "<vertical> 0.2 to 0.1 must rise within pi / 2"),
        (ray("", samples(2, -1.6, 0.0)), "<vertical> -1.6 to 0.0 must rise"),
        (ray("", samples(2, 0.0, 1.6)), "<vertical> 0.0 to 1.6 must rise"),
    ],
)
def test_what_no_lidar_can_do_is_refused(inside: str, problem: str) -> None:
    with pytest.raises(RobotError, match=problem):
        read(inside)


def test_what_a_lidar_just_can_do_is_taken() -> None:
    assert one(ray(samples(100_000))).samples == 100_000
    assert one(ray(samples(1, 1.0, 1.0))).samples == 1  # one beam needs no fan
    assert one(ray(ranges="<min>0</min>")).range_min == 0.0
    cloud, _ = read(ray(samples(50_000), samples(2, -HALF_PI, HALF_PI)))
    assert isinstance(cloud, CloudSettings)
    assert (cloud.rows, cloud.tilt_min, cloud.tilt_max) == (2, -HALF_PI, HALF_PI)
    assert type(one(ray("", samples(0, 0.1, 0.1)))) is LidarSettings  # one row at least


def test_resolution_multiplies_samples() -> None:
    assert one(ray(f"{samples(181)}<resolution>0.5</resolution>")).samples == 90
    cloud, _ = read(ray(samples(30), f"{samples(4, -0.1, 0.1)}<resolution>2</resolution>"))
    assert isinstance(cloud, CloudSettings)
    assert (cloud.samples, cloud.rows) == (30, 8)


ROWS = ray(samples(30), samples(4, -0.1, 0.1))


def test_a_lidar_of_several_rows_publishes_points_and_its_level_plane() -> None:
    points, level = read(ROWS)
    assert (type(points), type(level)) == (CloudSettings, LidarSettings)
    assert (points.name, points.topic) == ("s", "scan/points")
    assert (level.name, level.topic) == ("s_level", "scan")
    tag = element(f"{ROWS}<plugin filename='libgazebo_ros_laser.so'/>")
    (planar,) = read_lidar(tag)
    assert (type(planar), planar.name) == (LidarSettings, "s")
    assert [note.text for note in tag.xml.notes] == [
        "sensor 's': only the level plane is simulated of its vertical samples"
    ]


def test_each_plugin_of_a_lidar_publishes_what_it_names() -> None:
    plugin = (
        "<plugin filename='libgazebo_ros_ray_sensor.so'><ros><argument>~/out:={0}</argument></ros>"
        "<output_type>sensor_msgs/{0}</output_type></plugin>"
    )
    kinds = ("PointCloud2", "PointCloud", "LaserScan", "Range")
    tag = element(ROWS + "".join(map(plugin.format, kinds)))
    found = {sensor.topic: type(sensor) for sensor in read_lidar(tag)}
    assert found == dict(
        zip(kinds, (CloudSettings, CloudSettings, LidarSettings, RangeSettings), strict=True)
    )
    old = "sensor 's': publishes sensor_msgs/PointCloud2 in place of PointCloud"
    assert [note.text for note in tag.xml.notes].count(old) == 1


@pytest.mark.parametrize(
    ("plugin", "kind"),
    [
        ("<plugin><output_type>sensor_msgs/PointCloud2</output_type></plugin>", CloudSettings),
        ("<plugin filename='libgazebo_ros_velodyne_laser.so'/>", CloudSettings),
        ("<plugin filename='libgazebo_ros_block_laser.so'/>", CloudSettings),
        ("<plugin><output_type>sensor_msgs/LaserScan</output_type></plugin>", LidarSettings),
        ("<plugin><output_type>sensor_msgs/Range</output_type></plugin>", RangeSettings),
        ("<plugin filename='libgazebo_ros_range.so'/>", RangeSettings),
    ],
)
def test_a_plugin_names_what_is_published(plugin: str, kind: type[SensorSettings]) -> None:
    found = one(f"{ROWS}{plugin}")
    assert type(found) is kind
    if isinstance(found, RangeSettings):
        assert found.infrared is ("libgazebo_ros_range" not in plugin)  # ROS 1 says sound
        for radiation in ("INFRARED", "ultrasound"):
            said = one(f"{ROWS}{plugin}<radiation_type>{radiation}</radiation_type>")
            assert isinstance(said, RangeSettings)
            assert said.infrared is (radiation == "INFRARED")


def test_a_velodyne_s_plugin_sees_within_its_sensor_s_range() -> None:
    given = "<plugin><min_range>0.9</min_range><max_range>{}</max_range></plugin>"
    ray = "<ray><range><min>0.3</min><max>100</max></range></ray>"
    for most, seen in ((50, 50.0), (200, 100.0)):
        (found,) = read_lidar(element(ray + given.format(most)))
        assert isinstance(found, LidarSettings)
        assert (found.range_min, found.range_max) == (0.9, seen)


def test_a_sonar_is_a_cone_as_wide_as_its_radius_at_its_reach() -> None:
    def received(inside: str) -> RangeSettings:
        return read_sonar(element(f"<sonar>{inside}</sonar>"))[0]

    found = received("<min>0.2</min><max>4</max><radius>3</radius>")
    half = math.atan(0.75)
    assert (found.angle_min, found.angle_max) == pytest.approx((-half, half))
    assert (found.tilt_min, found.tilt_max) == pytest.approx((-half, half))
    assert (found.range_min, found.range_max) == (0.2, 4.0)
    assert (found.rows, found.samples, found.rate, found.topic) == (9, 9, 10.0, "sonar")
    assert received("<max>1e6</max>").range_max == 1e4
    assert received("").angle_max == pytest.approx(math.atan(0.5))
    for bad in ("<min>-1</min>", "<min>1</min>", "<radius>0</radius>"):
        with pytest.raises(RobotError, match=r"<sonar> .* is none"):
            received(bad)
    bare = element("<range><max>2</max></range>")
    assert (read_sonar(bare)[0].range_min, read_sonar(bare)[0].range_max) == (0.0, 1.0)
    assert "lacks <sonar>" in texts(bare.xml.notes)[0]


def test_the_surroundings_are_shown_by_the_first_lidar_that_sees_much() -> None:
    full, narrow = one(ray(samples(16, -0.53, 0.53))), one(ray(samples(99, -0.52, 0.52)))
    few = one(ray(samples(15, -2.0, 2.0)))
    beam = one(ray(samples(1), more="<plugin filename='libgazebo_ros_laser.so'/>"))
    cloud, level = read(ROWS)
    assert surroundings([narrow, full, one("")], URDF) is full  # a third of pi wide
    assert surroundings([few, narrow], URDF) is narrow  # else the one of most samples
    assert surroundings([beam], URDF) is surroundings([], URDF) is None
    assert surroundings([cloud, few], URDF) is few
    of_rows = surroundings([beam, cloud], URDF)
    assert isinstance(level, LidarSettings)
    assert of_rows == replace(level, topic="scan")
    assert type(of_rows) is LidarSettings


def test_a_lidar_that_looks_down_shows_no_surroundings() -> None:
    def at(pitch: float, name: str) -> LidarSettings:
        return replace(one(""), name=name, pose=Pose3.from_rpy((0.0, 0.0, 0.0), (0.0, pitch, 0.0)))

    down, tilted, level, over = at(0.8, "a"), at(0.7, "b"), at(0.2, "c"), at(math.pi, "d")
    assert surroundings([down, tilted, level, over], URDF) is level
    assert surroundings([down, tilted, over], URDF) is over  # it hangs upside down
    assert surroundings([down, tilted], URDF) is tilted  # for want of a better one
    assert surroundings([down], URDF) is None


def test_beams_in_a_narrow_cone_measure_a_range_unless_the_file_says_otherwise() -> None:
    cone = ray(samples(5, -0.27, 0.27), samples(5, -0.27, 0.27))
    (found,) = read(cone)
    assert isinstance(found, RangeSettings)
    assert (found.topic, found.samples, found.rows) == ("s/range", 5, 5)
    for wide in (ray(samples(5, -0.28, 0.28)), ray(samples(5, -0.2, 0.2), samples(3, -0.3, 0.3))):
        assert not any(isinstance(sensor, RangeSettings) for sensor in read(wide))
    wide = f"{ray(samples(2, -4.7, 1.6))}<plugin filename='libhector_gazebo_ros_sonar.so'/>"
    assert type(one(wide)) is RangeSettings
    assert type(one(f"{cone}<plugin filename='libgazebo_ros_laser.so'/>")) is LidarSettings
    (beam,) = read(ray(samples(1, -3.0, 3.0)))
    assert isinstance(beam, RangeSettings)


def test_a_beam_of_gazebo_sim_is_a_scan_unless_its_plugin_says_otherwise() -> None:
    beam = ray(samples(1, 0.0, 0.0))
    for kind in ("lidar", "gpu_lidar"):
        (found,) = read_lidar(element(f"{beam}<plugin name='p' filename='own'/>", kind))
        assert type(found) is LidarSettings
    sonar = f"{beam}<plugin filename='libhector_gazebo_ros_sonar.so'/>"
    assert isinstance(read_lidar(element(sonar, "gpu_lidar"))[0], RangeSettings)
