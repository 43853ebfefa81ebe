"""Tags of sensors and their text."""

from __future__ import annotations

import math
from typing import Any

import pytest

from arjuna_core.errors import RobotError
from arjuna_core.geodesy import GeoPoint
from arjuna_core.pose3 import ORIGIN
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import gazebo_colour
from arjuna_sim.model.settings import sensor_kinds
from tests.sim.builders import texts, urdf_file

DEFAULTS = {
    "imu": (50.0, "imu/data"),
    "navsat": (5.0, "gps/fix"),
    "magnetometer": (20.0, "imu/mag"),
    "altimeter": (20.0, "altimeter"),
    "contact": (50.0, "s/contacts"),
}


def tag(inside: str = "", name: str = "name='s'", element: str = "sensor") -> SensorTag:
    xml = urdf_file(f"<{element} {name} type='t'>{inside}</{element}>")
    return SensorTag(xml, xml.root[0], "head")


def read(kind: str, inside: str = "", name: str = "name='s'", element: str = "sensor") -> Any:
    (found,) = sensor_kinds().readers[kind](tag(inside, name, element))
    return found


@pytest.mark.parametrize("kind", DEFAULTS)
def test_what_no_tag_says_is_as_in_gazebo(kind: str) -> None:
    found = read(kind)
    rate, topic = DEFAULTS[kind]
    assert (found.link, found.frame, found.rate, found.topic) == ("head", "head", rate, topic)
    assert (found.name, found.pose) == ("s", ORIGIN)
    assert read(kind, name="").name == "t"


@pytest.mark.parametrize("kind", ["imu", "navsat", "ray"])
def test_plugins_of_ros_2_publish_on_out_and_read_no_names_of_ros_1(kind: str) -> None:
    """As in gazebo_ros; a remapping of it counts."""
    file = {"imu": "imu", "navsat": "gps", "ray": "ray"}[kind]
    plugin = f"<plugin name='p' filename='libgazebo_ros_{file}_sensor.so'>{{}}</plugin>"
    beams = "<ray><scan><horizontal><samples>90</samples></horizontal></scan></ray>" * (
        kind == "ray"
    )
    old = "<topicName>old</topicName><frameName>lens</frameName>"
    found = read(kind, beams + plugin.format(old))
    assert (found.topic, found.frame) == ("p/out", "head")
    remap = "<ros><remapping>~/out:=new</remapping></ros><frame_name>lens</frame_name>"
    found = read(kind, beams + plugin.format(old + remap))
    assert (found.topic, found.frame) == ("new", "lens")


@pytest.mark.parametrize("kind", DEFAULTS)
def test_tags_say_rate_topic_frame_and_pose(kind: str) -> None:
    point = "<pose>1 2 3 0 0 0.5</pose><camera><pose>1 0 0 0 0 0</pose></camera>"
    given = "<update_rate>12</update_rate><topic>/here</topic><gz_frame_id>/eye</gz_frame_id>"
    found = read(kind, point + given)
    assert (found.rate, found.topic, found.frame) == (12.0, "/here", "eye")
    assert found.pose.position == pytest.approx((1.8775826, 2.4794255, 3.0))  # 1 m at 0.5 rad
    assert found.pose.rpy() == pytest.approx((0.0, 0.0, 0.5))


@pytest.mark.parametrize(
    ("given", "rate", "note"),
    [
        ("1000", 1000.0, ()),
        ("0.1", 0.1, ()),
        ("0", 50.0, ("sensor 's': <update_rate> 0 is taken as 50 Hz",)),
        ("1500", 1000.0, ("sensor 's': <update_rate> 1500 is taken as 1000 Hz",)),
        ("-1", None, r"<update_rate> is -1.0; valid: above 0 Hz"),
    ],
)
def test_rates_end_at_a_thousand_hertz(given: str, rate: float | None, note: Any) -> None:
    sensor = tag(f"<update_rate>{given}</update_rate>")
    if rate is None:
        with pytest.raises(RobotError, match=note):
            sensor.mount(50.0, "topic")
        return
    assert sensor.mount(50.0, "topic")["rate"] == rate
    assert texts(sensor.xml.notes) == note


@pytest.mark.parametrize(
    ("inside", "rate"),
    [
        ("<plugin><updateRate>5</updateRate></plugin>", 5.0),
        ("<plugin/><plugin><updateRateHZ>8</updateRateHZ></plugin>", 8.0),
        ("<update_rate>0</update_rate><plugin><updateRate>5</updateRate></plugin>", 5.0),
        ("<update_rate>20</update_rate><plugin><updateRate>5</updateRate></plugin>", 20.0),
        ("<plugin><updateRate>0.0</updateRate></plugin>", 50.0),
    ],
)
def test_a_sensor_without_a_rate_has_its_plugins(inside: str, rate: float) -> None:
    """As gazebo_ros_range paces its messages."""
    sensor = tag(inside)
    assert sensor.mount(50.0, "topic")["rate"] == rate
    assert texts(sensor.xml.notes) == ()


def nested(path: str, value: str) -> str:
    """Return a value inside tags."""
    tags = path.split("/")
    return "".join(f"<{t}>" for t in tags) + value + "".join(f"</{t}>" for t in reversed(tags))


@pytest.mark.parametrize(
    ("kind", "path", "field"),
    [
        ("imu", "imu/angular_velocity/x/noise/stddev", "gyro_noise"),
        ("imu", "imu/angular_velocity/z/noise/stddev", "gyro_noise"),
        ("imu", "imu/noise/rate/stddev", "gyro_noise"),
        ("imu", "imu/noise/rates/stddev", "gyro_noise"),
        ("imu", "imu/linear_acceleration/x/noise/stddev", "accel_noise"),
        ("imu", "imu/noise/accel/stddev", "accel_noise"),
        ("navsat", "navsat/position_sensing/horizontal/noise/stddev", "noise"),
        ("navsat", "gps/position_sensing/horizontal/noise/stddev", "noise"),
        ("navsat", "navsat/position_sensing/vertical/noise/stddev", "height_noise"),
        ("navsat", "gps/position_sensing/vertical/noise/stddev", "height_noise"),
        ("magnetometer", "magnetometer/x/noise/stddev", "noise"),
        ("altimeter", "altimeter/vertical_position/noise/stddev", "noise"),
    ],
)
def test_each_noise_is_that_of_its_own_tag(kind: str, path: str, field: str) -> None:
    silent, given = vars(read(kind)), vars(read(kind, nested(path, "0.25")))
    assert silent[field] == (None if kind == "imu" else 0.0)
    assert given == silent | {field: 0.25}
    assert vars(read(kind, nested(path, "0")))[field] == 0.0
    with pytest.raises(RobotError, match=r"<stddev> is -1.0; it must not be negative"):
        read(kind, nested(path, "-1"))


@pytest.mark.parametrize(
    ("mean", "noted"), [("0.0", False), ("-0.1", True), ("none", False), ("", False)]
)
def test_noise_about_another_mean_is_noted(mean: str, noted: bool) -> None:
    given = tag(nested("altimeter/vertical_position/noise/mean", mean))
    given.deviation("altimeter/vertical_position/noise")
    said = ("sensor 's': <noise>: its <mean> is taken to be 0",)
    assert texts(given.xml.notes) == said * noted


@pytest.mark.parametrize(
    ("grows", "keeps", "found"),
    [("1e-4", "400", (1e-4, 400.0)), ("1e-4", "0", None), ("0", "4", None)],
)
@pytest.mark.parametrize("axis", ["x", "z"])
def test_bias_of_an_imu_drifts_where_both_its_numbers_are_there(
    axis: str, grows: str, keeps: str, found: tuple[float, float] | None
) -> None:
    noise = f"<dynamic_bias_stddev>{grows}</dynamic_bias_stddev>"
    noise += f"<dynamic_bias_correlation_time>{keeps}</dynamic_bias_correlation_time>"
    assert read("imu", nested(f"imu/angular_velocity/{axis}/noise", noise)).gyro_drift == found
    assert read("imu", nested(f"imu/linear_acceleration/{axis}/noise", noise)).accel_drift == found
    assert read("imu").gyro_drift is None


FRAME = "imu/orientation_reference_frame/localization"
PLUGIN = "<plugin name='p'><initial_orientation_as_reference>{}</initial_orientation_as_reference>"


@pytest.mark.parametrize(
    ("inside", "named"),
    [
        (nested("imu/enable_orientation", "false"), "<enable_orientation> false"),
        (nested("imu/enable_orientation", "1"), None),
        (nested(FRAME, "NED"), "<localization> NED"),
        (nested(FRAME, " ENU "), None),
        (PLUGIN.format("true") + "</plugin>", "<initial_orientation_as_reference> true"),
        (PLUGIN.format("false") + "</plugin>", None),
    ],
)
def test_an_orientation_that_is_not_the_worlds_is_noted(inside: str, named: str | None) -> None:
    given = tag(inside)
    sensor_kinds().readers["imu"](given)
    said = () if named is None else (f"sensor 's': {named}: its orientation is the world's",)
    assert tuple(text.removesuffix(" all the same") for text in texts(given.xml.notes)) == said


def test_one_noise_of_a_plugin_is_all_of_an_imus() -> None:
    found = read("imu", "<plugin name='p'><gaussianNoise>0.1</gaussianNoise></plugin>")
    assert (found.gyro_noise, found.accel_noise) == (0.1, 0.1)


def test_a_bumper_publishes_where_its_tag_says() -> None:
    assert read("contact", nested("contact/topic", " hit ")).topic == "hit"
    plugin = "<plugin name='p'><bumperTopicName>bump</bumperTopicName></plugin>"
    assert read("contact", plugin + nested("contact/topic", "hit")).topic == "bump"


@pytest.mark.parametrize(
    ("inside", "expected"),
    [
        ("<bodyName>head</bodyName>", ("head", "head", 50.0, "imu/data")),
        ("<bodyId>head</bodyId><frameId>/eye</frameId>", ("head", "eye", 50.0, "imu/data")),
        (
            "<bodyName>head</bodyName><updateRate>1000</updateRate><topicName>imu</topicName>",
            ("head", "head", 1000.0, "imu"),
        ),
    ],
)
def test_an_imu_may_be_a_plugin(inside: str, expected: tuple[object, ...]) -> None:
    found = read("imu", inside, element="plugin")
    assert (found.link, found.frame, found.rate, found.topic) == expected
    assert found.name == "s"
    assert read("imu", "<updateRate>1001</updateRate>", element="plugin").rate == 1000.0


def test_a_gps_and_a_compass_may_be_plugins() -> None:
    given = "<updateRate>4</updateRate><topicName>/fix</topicName><frameId>antenna</frameId>"
    given += "<gaussianNoise>0.5 0.5 0.5</gaussianNoise>"
    for kind in ("gps", "magnetometer"):
        found = read(kind, given, element="plugin")
        assert (found.rate, found.topic, found.frame) == (4.0, "/fix", "antenna")
        assert found.noise == 0.5
    assert read("gps", given, element="plugin").reference is None
    place = "<referenceLatitude>{}</referenceLatitude><referenceHeading>{}</referenceHeading>"
    # Its heading is of the world's x axis from north to east, ours from east to north.
    for heading, turned in ((0, math.pi / 2), (90, 0.0)):
        found = read("gps", place.format(47.5, heading), element="plugin")
        assert found.reference == (GeoPoint(47.5, 0.0, 0.0), pytest.approx(turned))
    with pytest.raises(RobotError, match=r"its reference is no point on Earth: .*latitude"):
        read("gps", place.format(91, 0), element="plugin")


@pytest.mark.parametrize(
    ("inside", "gyro", "accel"),
    [
        ("<rateGaussianNoise>0.1 0.2 0.3</rateGaussianNoise>", 0.1, None),
        ("<accelGaussianNoise>0.1 0.1 0.1</accelGaussianNoise>", None, 0.1),
        ("<gaussianNoise>0.3</gaussianNoise>", 0.3, 0.3),
    ],
)
def test_noise_of_a_plugin_that_is_an_imu(
    inside: str, gyro: float | None, accel: float | None
) -> None:
    found = read("imu", inside, element="plugin")
    assert (found.gyro_noise, found.accel_noise) == (gyro, accel)


@pytest.mark.parametrize(
    ("plugin", "topic"),
    [("gz::sim::systems::Sensors", "beams"), ("libgazebo_ros_ray_sensor", "scan")],
)
def test_a_system_in_a_sensor_remaps_nothing(plugin: str, topic: str) -> None:
    ray = "<scan><horizontal><samples>9</samples></horizontal></scan>"
    ray += "<range><min>0.1</min><max>9</max></range>"
    remapped = "<ros><argument>~/out:=scan</argument></ros>"
    system = f"<plugin name='{plugin}' filename='f'>{remapped}</plugin>"
    assert read("gpu_lidar", f"<topic>beams</topic><ray>{ray}</ray>{system}").topic == topic


def test_sensors_are_called_by_name_or_type() -> None:
    labels = [tag(name=name).label for name in ("name='s'", "")]
    assert labels == ["sensor 's'", "sensor 't'"]


NAMES = (
    *("Red", "Green", "Blue", "Yellow", "Orange", "Purple", "Turquoise", "Indigo", "Gold"),
    *("Silver", "White", "Black", "Grey", "Gray", "Road", "Wood"),
)


@pytest.mark.parametrize("name", NAMES)
def test_a_colour_can_be_drawn_and_has_variants(name: str) -> None:
    colour = gazebo_colour(f"Gazebo/{name}")
    assert colour is not None
    assert len(colour) == 4
    assert all(0.0 <= part <= 1.0 for part in colour)
    for other in (name.lower(), f"Gazebo/Dark{name}", f"a/b/{name}Glow", f" {name}_Transparent "):
        assert gazebo_colour(other) == colour


def test_colours_look_as_they_are_called() -> None:
    for k, name in enumerate(("Red", "Green", "Blue")):
        colour = gazebo_colour(name)
        assert colour is not None
        assert colour.index(max(colour[:3])) == k
    black, white = gazebo_colour("Black"), gazebo_colour("White")
    assert black is not None
    assert white is not None
    assert max(black[:3]) < 0.2 < 0.8 < min(white[:3])
    assert gazebo_colour("Gazebo/Plaid") is None
