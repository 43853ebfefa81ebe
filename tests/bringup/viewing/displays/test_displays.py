"""Claims: each display's drawing of a message, by its settings; what makes no sense is said."""

from __future__ import annotations

import io
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pillow

from arjuna_core.pose3 import Pose3
from bringup.viewing.displays.base import DISPLAYS, DisplaySpec, Moment, kinds_of, rainbow
from bringup.viewing.displays.standard import STANDARD, usual
from bringup.viewing.drawing.frames import Frames
from bringup.viewing.drawing.values import (
    Arrows,
    Axes,
    Drawing,
    Grid,
    Label,
    Line,
    Picture,
    Points,
    Solids,
    Values,
    Words,
)
from tests.bringup.viewing.drives import (
    grid,
    header,
    image,
    make,
    odometry,
    particles,
    path_of,
    pose,
    scan,
    serialized,
)

GEOMETRY, SENSORS = "geometry_msgs/msg", "sensor_msgs/msg"
RED, GREEN, MAGENTA = [255, 0, 0], [0, 255, 0], [255, 0, 255]


def vector(x: float, y: float = 0.0, z: float = 0.0) -> Any:
    return make(f"{GEOMETRY}/Vector3", x=x, y=y, z=z)


def ranging(distance: float) -> Any:
    limits = {"min_range": 0.1, "max_range": 4.0, "field_of_view": math.pi / 2}
    return make(f"{SENSORS}/Range", header=header("sonar"), range=distance, **limits)


def wrench(force: Any, torque: Any) -> Any:
    both = make(f"{GEOMETRY}/Wrench", force=force, torque=torque)
    return make(f"{GEOMETRY}/WrenchStamped", header=header("wrist"), wrench=both)


def moving(kind: str) -> Any:
    both = make(f"{GEOMETRY}/{kind}", linear=vector(1.0), angular=vector(0.0, 0.0, 2.0))
    return stamped(f"{kind}Stamped", **{kind.lower(): both})


def measured(kind: str, field: str, value: float) -> Any:
    return make(f"{SENSORS}/{kind}", header=header("sensor"), **{field: value})


def cells(size: float) -> Any:
    at = [make(f"{GEOMETRY}/Point", x=x) for x in (0.5, 1.0)]
    kind, sizes = "nav_msgs/msg/GridCells", {"cell_width": size, "cell_height": size}
    return make(kind, header=header("map"), cells=at, **sizes)


def imu(w: float) -> Any:
    turn = make(f"{GEOMETRY}/Quaternion", w=w)
    return make(
        *(f"{SENSORS}/Imu",),
        header=header("imu"),
        orientation=turn,
        linear_acceleration=vector(0.0, 0.0, 10.0),
    )


def stamped(kind: str, **fields: Any) -> Any:
    return make(f"{GEOMETRY}/{kind}", header=header("map"), **fields)


def belief(variance: float) -> Any:
    covariance = np.zeros(36)
    covariance[[0, 7]] = variance
    with_it = make(f"{GEOMETRY}/PoseWithCovariance", pose=pose(1.0), covariance=covariance)
    return stamped("PoseWithCovarianceStamped", pose=with_it)


def cloud(*rows: tuple[float, ...], fields: str = "xyzi", **more: Any) -> Any:
    """Return a cloud of float32 fields; i is the intensity, c the packed colour."""
    names = {"i": "intensity", "c": "rgb"}
    made = [
        make(f"{SENSORS}/PointField", name=names.get(f, f), offset=4 * n, datatype=7, count=1)
        for n, f in enumerate(fields)
    ]
    step, order = 4 * len(fields), ">" if more.get("is_bigendian") else "<"
    size = {"height": 1, "width": len(rows), "point_step": step, "row_step": step * len(rows)}
    data = np.frombuffer(np.array(rows, f"{order}f4").tobytes(), np.uint8)
    given = {"header": header("map"), "fields": made, "data": data} | size | more
    return make(f"{SENSORS}/PointCloud2", **given)


def packed(*rgb: int) -> float:
    return float(np.array([[*reversed(rgb), 0]], np.uint8).view("<f4")[0, 0])


def taken(kind: str, *messages: Any, **settings: Any) -> dict[str, Any]:
    """Return a display's drawings after messages."""
    display = DisplaySpec(kind, kind, settings=settings).make()
    parts: Any = None
    for message in messages:
        parts = display.take(message)
    return dict(parts or {})


CORNERS = [make(f"{GEOMETRY}/Point32", x=x, y=y) for x, y in ((0, 0), (1, 0), (1, 1))]
POLYGON = stamped("PolygonStamped", polygon=make(f"{GEOMETRY}/Polygon", points=CORNERS))
TRAIL = [odometry(x, 0.5) for x in (0.0, 0.05, 0.2, 0.4)]


@pytest.mark.parametrize(
    ("kind", "messages", "settings", "drawing", "values"),
    [
        ("Path", [path_of(0.0, 1.0)], {"line_width": 0.05}, Line, {"width": 5.0, "frame": "map"}),
        ("Path", [path_of()], {}, Line, {"colour": (25, 255, 0)}),
        ("Polygon", [POLYGON], {"color": (1, 2, 3)}, Line, {"colour": (1, 2, 3)}),
        ("Pose", [stamped("PoseStamped", pose=pose(1.0))], {"shaft_length": 2.0}, Arrows, {}),
        ("PoseArray", [stamped("PoseArray", poses=[pose(1.0)] * 7)], {}, Arrows, {"width": 0.025}),
        ("PoseArray", [stamped("PoseArray", poses=[])], {}, Arrows, {}),
        ("PoseWithCovariance", [belief(0.25)], {}, Line, {"colour": (150, 60, 200)}),
        ("PoseWithCovariance", [belief(0.0)], {}, Line, {}),
        ("Odometry", TRAIL, {}, Arrows, {"frame": "odom"}),
        ("Range", [ranging(2.0)], {"alpha": 0.3}, Solids, {"shape": "cone", "frame": "sonar"}),
        ("PointStamped", [stamped("PointStamped")], {}, Solids, {"shape": "sphere"}),
        ("Wrench", [wrench(vector(1), vector(0, 1))], {}, Solids, {"frame": "wrist"}),
        ("TwistStamped", [moving("Twist")], {}, Solids, {"shape": "arrow", "frame": "map"}),
        ("AccelStamped", [moving("Accel")], {}, Solids, {"shape": "arrow", "frame": "map"}),
        *(
            (kind, [measured(kind, field, 1.0)], {}, Solids, {"frame": "sensor"})
            for kind, field in (
                ("Temperature", "temperature"),
                ("RelativeHumidity", "relative_humidity"),
                ("Illuminance", "illuminance"),
                ("FluidPressure", "fluid_pressure"),
            )
        ),
        ("GridCells", [cells(0.5)], {"alpha": 0.5}, Solids, {"shape": "box", "frame": "map"}),
        ("LaserScan", [scan(0.0)], {}, Points, {"frame": "base_link", "floor": True}),
        ("LaserScan", [scan(0.0)], {"on_floor": False, "size_m": 0.1}, Points, {"size": 0.1}),
        ("Map", [grid()], {}, Grid, {"opacity": None, "frame": "map"}),
        ("Map", [grid()], {"color_scheme": "costmap", "alpha": 0.4}, Grid, {"opacity": 0.4}),
        ("Map", [grid()], {"height": 0.5}, Grid, {"pose": Pose3((-1.05, -1.0, 0.5))}),
        ("Image", [image(7)], {}, Picture, {}),
        ("Speed", [odometry(0.0, 0.5)], {}, Values, {}),
    ],
)
def test_each_message_is_drawn(
    kind: str,
    messages: list[Any],
    settings: dict[str, Any],
    drawing: type[Drawing],
    values: dict[str, Any],
) -> None:
    drawn = taken(kind, *messages, **settings)[""]
    assert isinstance(drawn, drawing)
    assert {name: getattr(drawn, name) for name in values} == values


def test_every_display_has_its_types_and_every_standard_one_is_made() -> None:
    kinds = {name: DISPLAYS.resolve(name).types for name in DISPLAYS.types}
    without = {name for name, types in kinds.items() if not types}
    assert without == {"TF", "Axes", "People", "DistanceToGoal"}
    assert kinds_of("nav_msgs/msg/Odometry") == ("Odometry", "Speed")
    wanted = {name: DisplaySpec(name, "").make().wanted() for name in DISPLAYS.types}
    missing_none = {name for name, topics in wanted.items() if any(each.every for each in topics)}
    markers = {"Marker", "MarkerArray", "InteractiveMarkers"}
    assert missing_none == {"Map", "BehaviorTree", *markers}
    assert all(spec.make().name or not spec.make().types for spec in STANDARD)


def test_a_polygon_is_closed_and_a_path_goes_from_pose_to_pose() -> None:
    assert taken("Polygon", POLYGON)[""].points[[0, -1], :2].tolist() == [[0, 0], [0, 0]]
    line = taken("Path", path_of(0.0, 1.0, 3.0))[""]
    assert line.points[:, 0].tolist() == [0, 1, 3]
    assert line.segments[:, :, 0].tolist() == [[0, 1], [1, 3]]
    for count in (0, 1):
        assert taken("Path", path_of(*range(count)))[""].segments.shape == (0, 2, 3)


def test_arrows_are_as_long_as_they_are_told_along_the_heading() -> None:
    turned = stamped("PoseStamped", pose=pose(1.0, 2.0, math.pi / 2))
    (tail, tip) = taken("Pose", turned, shaft_length=2.0)[""].segments[0]
    assert tail[:2] == pytest.approx([1.0, 2.0])
    assert tip[:2] == pytest.approx([1.0, 4.0], abs=1e-6)


def test_particles_are_read_of_their_bytes() -> None:
    drawn = taken("ParticleCloud", serialized(particles(1.0, 2.0)), color=(1, 2, 3))[""]
    assert drawn.segments[:, 0, 0].tolist() == [1.0, 2.0]
    assert drawn.colour == (1, 2, 3)


def test_a_belief_leads_from_the_mean_along_the_heading_to_an_ellipse_of_two_sigmas() -> None:
    message = belief(0.25)
    message.pose.covariance[7] = 0.01
    message.pose.pose = pose(3.0, 0.0, math.pi / 2)
    points = taken("PoseWithCovariance", message)[""].points
    assert points[:2, :2] == pytest.approx(np.array([(3.0, 0.0), (3.0, 0.2)]), abs=1e-6)
    assert points[-1] == pytest.approx(points[1], abs=1e-6)
    assert np.abs(points[:, 0] - 3.0).max() == pytest.approx(1.0, rel=1e-2)


def test_only_beams_that_hit_are_points() -> None:
    message = scan(0.5)
    message.ranges = np.array([1.0, math.inf, math.nan, 2.0, 0.01], dtype=np.float32)
    drawing = taken("LaserScan", message)[""]
    assert drawing.stamp == 0.0
    assert drawing.points == pytest.approx(np.array([[1, 0, 0], [0, -2, 0]]), abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "topic", "settings"),
    [
        ("Map", "/map", {}),
        ("Map", "/a/local_costmap/costmap", {"color_scheme": "costmap", "alpha": 0.65}),
        ("Path", "/local_plan", {"color": (30, 110, 240)}),
        ("Path", "/unsmoothed_plan", {"color": (20, 160, 60)}),
        ("Pose", "/anything", {}),
    ],
)
def test_a_topic_has_the_settings_of_the_usual_one_that_it_ends_like(
    kind: str, topic: str, settings: dict[str, Any]
) -> None:
    spec = usual(kind, topic)
    assert (spec.kind, spec.topic) == (kind, topic)
    assert {name: spec.settings.get(name) for name in settings} == settings
    assert bool(spec.settings) == bool(settings)


def test_odometry_keeps_poses_that_are_apart_and_the_newest() -> None:
    drawn = taken("Odometry", *TRAIL, covariance=True)
    assert drawn[""].segments[:, 0, 0] == pytest.approx([0.0, 0.2, 0.4, 0.4])
    assert isinstance(drawn["covariance"], Line)
    few = taken("Odometry", *TRAIL, keep=1, position_tolerance=0.01)
    assert few[""].segments[:, 0, 0] == pytest.approx([0.4, 0.4])


@pytest.mark.parametrize(("distance", "cones"), [(2.0, 1), (0.05, 0), (5.0, 0), (math.inf, 0)])
def test_a_range_is_a_cone_from_the_sensor_while_it_is_within_its_limits(
    distance: float, cones: int
) -> None:
    drawn = taken("Range", ranging(distance))
    assert len(drawn) == cones
    if cones:
        assert drawn[""].positions.tolist() == [[1.0, 0.0, 0.0]]
        assert drawn[""].sizes[0] == pytest.approx([2.0, 4.0, 4.0])


@pytest.mark.parametrize(("value", "colour"), [(-5.0, [255, 0, 0]), (100.0, [255, 0, 255])])
def test_a_temperature_is_a_ball_as_warm_as_its_colour(value: float, colour: list[int]) -> None:
    drawn = taken("Temperature", measured("Temperature", "temperature", value), size_m=0.4)[""]
    assert drawn.colours.tolist() == [colour]
    assert drawn.sizes.tolist() == [[pytest.approx(0.4)] * 3]
    assert taken("Temperature", measured("Temperature", "temperature", math.nan)) == {}


def test_cells_are_squares_of_their_size() -> None:
    drawn = taken("GridCells", cells(0.5), color=(1, 2, 3))[""]
    assert drawn.positions[:, 0].tolist() == [0.5, 1.0]
    assert drawn.sizes[0, :2].tolist() == [0.5, 0.5]
    assert drawn.colours[0].tolist() == [1, 2, 3]


def test_a_wrench_is_two_arrows_as_long_as_they_are_strong() -> None:
    both = wrench(vector(3.0), vector(0.0, 0.0, 1.0))
    drawn = taken("Wrench", both, force_arrow_scale=0.5, torque_color=(1, 2, 3))[""]
    assert drawn.sizes[:, 0] == pytest.approx([1.5, 2.0])
    assert drawn.colours[1].tolist() == [1, 2, 3]
    assert len(taken("Wrench", wrench(vector(0.0), vector(1.0)))[""].positions) == 1


@pytest.mark.parametrize(("encoding", "kind", "unit"), [("32FC1", "<f4", 1), ("16UC1", "<u2", 1e3)])
def test_a_depth_picture_is_points_by_the_camera_beside_it(
    encoding: str, kind: str, unit: float
) -> None:
    depths = (unit * np.array([[0.0, 2.0], [0.0, 4.0]])).astype(kind)
    data = np.frombuffer(depths.tobytes(), np.uint8)
    size = {"height": 2, "width": 2, "step": len(data) // 2, "encoding": encoding}
    image = make(f"{SENSORS}/Image", header=header("optical"), data=data, **size)
    camera = make(f"{SENSORS}/CameraInfo", k=np.array([2.0, 0, 1, 0, 4, 0, 0, 0, 1]))
    display = DisplaySpec("DepthCloud", "", "front/depth/image").make()
    assert display.wanted()[1].topic == "front/depth/camera_info"
    assert display.take(image) is display.take(camera) is None
    drawn: Any = dict(display.take(image) or {})[""]
    assert drawn.frame == "optical"
    assert drawn.points.tolist() == [[0.0, 0.0, 2.0], [0.0, 1.0, 4.0]]


@pytest.mark.parametrize(("w", "turn"), [(1.0, [1, 0, 0, 0]), (0.0, [1, 0, 0, 0])])
def test_an_imu_is_axes_and_an_arrow_also_where_it_knows_no_orientation(
    w: float, turn: list[float]
) -> None:
    drawn = taken("Imu", imu(w))
    assert isinstance(drawn["axes"], Axes)
    assert drawn["axes"].wxyzs[0].tolist() == turn
    assert drawn["acceleration"].sizes[0, 0] == pytest.approx(0.5)


ROWS = [(0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 2.0, 2.0), (2.0, 0.0, 4.0, 3.0)]
COLOURED = [(0.0, 0.0, 0.0, packed(*RED)), (1.0, 0.0, 0.0, packed(*GREEN))]


@pytest.mark.parametrize(
    ("message", "settings", "colours"),
    [
        (cloud(*ROWS), {}, [RED, [0, 255, 127], MAGENTA]),  # by intensity
        (cloud(*ROWS, is_bigendian=True), {}, [RED, [0, 255, 127], MAGENTA]),
        (cloud(*ROWS), {"channel_name": "z"}, [RED, [0, 255, 127], MAGENTA]),
        (cloud(*ROWS), {"channel_name": "none"}, [255, 255, 255]),
        (cloud(*ROWS), {"color_transformer": "FlatColor", "color": (1, 2, 3)}, [1, 2, 3]),
        (cloud(*ROWS), {"color_transformer": "AxisColor"}, [RED, [0, 255, 127], MAGENTA]),
        (cloud(*ROWS), {"color_transformer": "AxisColor", "axis": "Y"}, [RED] * 3),
        (
            cloud(*ROWS),
            {"autocompute_intensity_bounds": False, "min_intensity": 3.0, "max_intensity": 9.0},
            [RED] * 3,
        ),
        (cloud(*COLOURED, fields="xyzc"), {}, [RED, GREEN]),
        (cloud(*COLOURED, fields="xyzc"), {"color_transformer": "RGB8"}, [RED, GREEN]),
        (cloud(*ROWS), {"color_transformer": "RGB8"}, [255, 255, 255]),  # it has no colours
    ],
)
def test_a_cloud_is_coloured_by_its_transformer(
    message: Any, settings: dict[str, Any], colours: list[Any]
) -> None:
    drawn = taken("PointCloud2", message, **settings)[""]
    assert drawn.points[:, 0].tolist() == [float(n) for n in range(message.width)]
    assert np.asarray(drawn.colour).tolist() == colours


def test_an_older_cloud_is_coloured_by_a_channel() -> None:
    points = [make(f"{GEOMETRY}/Point32", x=x, z=2.0 * x) for x in (0.0, 1.0, math.nan)]
    channel = make(f"{SENSORS}/ChannelFloat32", name="intensity", values=[1.0, 3.0, 2.0])
    given = {"header": header("map"), "points": points}
    drawn = taken("PointCloud", make(f"{SENSORS}/PointCloud", **given, channels=[channel]))[""]
    assert drawn.points.tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, 2.0]]
    assert drawn.colour.tolist() == [RED, MAGENTA]
    short = make(f"{SENSORS}/ChannelFloat32", name="intensity", values=[1.0])
    with pytest.raises(ValueError, match="a cloud of 3 points has channels of another length"):
        taken("PointCloud", make(f"{SENSORS}/PointCloud", **given, channels=[short]))
    empty = make(f"{SENSORS}/PointCloud", header=header("map"))
    assert len(taken("PointCloud", empty)[""].points) == 0


def test_points_that_are_not_finite_are_left_out_with_their_colours() -> None:
    drawn = taken("PointCloud2", cloud(*ROWS, (math.nan, 0.0, 0.0, 9.0)))[""]
    assert (len(drawn.points), len(drawn.colour)) == (3, 3)
    assert len(taken("PointCloud2", cloud(fields="xyz"))[""].points) == 0


def test_a_scan_is_coloured_by_its_intensities_where_it_has_them() -> None:
    message = scan(0.0)
    message.intensities = np.array([0.0, 1.0, 2.0, 3.0], np.float32)
    drawn = taken("LaserScan", message, color_transformer="Intensity")[""]
    assert drawn.colour[[0, -1]].tolist() == [RED, MAGENTA]  # of the beams that met something
    bare = taken("LaserScan", scan(0.0), color_transformer="Intensity")[""]
    assert bare.colour.tolist() == [RED] * 3


def test_colours_span_what_is_finite() -> None:
    assert rainbow([0.0, math.nan, 1.0])[[0, 2]].tolist() == [RED, MAGENTA]
    assert rainbow([]).shape == (0, 3)
    assert rainbow([5.0, 5.0]).tolist() == [RED, RED]


def update(x: int, y: int, width: int, height: int) -> Any:
    cells = np.full(width * height, 100, np.int8)
    return SimpleNamespace(x=x, y=y, width=width, height=height, data=cells)


def test_updates_change_cells_of_the_map_that_came_before() -> None:
    assert not taken("Map", update(0, 0, 1, 1))  # there is no map yet
    drawn = taken("Map", grid(), update(2, 1, 3, 2))[""]
    assert drawn.grid.data[1:3, 2:5].tolist() == [[100] * 3] * 2
    assert np.count_nonzero(drawn.grid.data[:, :30]) == 6
    kind = "map_msgs/msg/OccupancyGridUpdate"
    map_, changes = DisplaySpec("Map", "", "m").make().wanted()
    assert (map_.topic, changes.topic, changes.types, changes.every) == (
        *("m", "m_updates", (kind,), True),
    )


@pytest.mark.parametrize("rectangle", [(30, 0, 2, 1), (0, 19, 1, 2), (-1, 0, 1, 1)])
def test_an_update_beside_the_map_is_refused(rectangle: tuple[int, int, int, int]) -> None:
    with pytest.raises(ValueError, match="does not fit into a grid of 31 x 20"):
        taken("Map", grid(), update(*rectangle))


@pytest.mark.parametrize("kind", ["png", "jpeg"])
def test_a_compressed_picture_is_shown_no_wider_than_told(kind: str) -> None:
    out = io.BytesIO()
    Pillow.new("RGB", (100, 50), (255, 0, 0)).save(out, kind)
    data = np.frombuffer(out.getvalue(), np.uint8)
    message = make(f"{SENSORS}/CompressedImage", header=header("camera"), format=kind, data=data)
    shown = taken("Image", message, widest=20)[""].pixels
    assert shown.shape == (10, 20, 3)
    assert shown[5, 5] == pytest.approx(RED, abs=2)


def test_frames_are_axes_names_and_lines_as_they_are_wanted() -> None:
    frames = Frames("map")
    frames.insert("map", "odom", 1.0, Pose3((1.0, 0.0, 0.0)))
    frames.insert("odom", "base_link", 1.0, Pose3((1.0, 0.0, 0.0)))
    settings = {"show_names": True, "show_arrows": True, "marker_scale": 2.0}
    parts: Any = DisplaySpec("TF", "TF", settings=settings).make().tick(Moment(0.0, frames))
    assert (len(parts["axes"].positions), parts["axes"].length) == (3, 0.5)
    names = {part.text: part.pose.position[0] for part in parts.values() if isinstance(part, Label)}
    assert names == {"map": 0.0, "odom": 1.0, "base_link": 2.0}
    assert parts["arrow base_link"].points[:, 0].tolist() == [2.0, 1.0]
    spec = DisplaySpec("TF", "TF", settings={**settings, "frames": "odom;x"})
    parts = spec.make().tick(Moment(0.0, frames))
    assert set(parts) == {"axes", "name map", "name base_link"}
    moment, own = Moment(0.0, frames), {"reference_frame": "odom", "length": 0.5}
    one: Any = DisplaySpec("Axes", "", settings=own).make().tick(moment)
    axes = one["axes"]
    assert (axes.frame, axes.length, axes.positions.tolist()) == ("odom", 0.5, [[0.0, 0.0, 0.0]])
    one = DisplaySpec("Axes", "").make().tick(moment)
    assert one["axes"].frame == "map"


def test_plots_go_on_without_messages_and_begin_with_the_first() -> None:
    moment = Moment(0.0, Frames("map"))
    quality = DisplaySpec("LocalizationQuality", "").make()
    assert quality.tick(moment) is None
    quality.take(SimpleNamespace(quality=0.7))
    assert quality.tick(moment) == {"": Values(values={"quality": 0.7})}
    left = DisplaySpec("DistanceToGoal", "").make()
    assert left.tick(moment) is None
    moment.distance = 1.5
    assert left.tick(moment) == {"": Values(values={"distance to go [m]": 1.5})}


def test_the_behavior_tree_shows_what_runs_first() -> None:
    events = [("Plan", "SUCCESS"), ("Follow", "RUNNING"), ("Plan", "FAILURE"), ("Back", "IDLE")]
    log = [SimpleNamespace(node_name=n, current_status=s) for n, s in events]
    words = taken("BehaviorTree", SimpleNamespace(event_log=log))[""]
    assert isinstance(words, Words)
    lines = words.text.split("\n\n")
    assert lines == ["▶ Follow: running", "· Back: idle", "✖ Plan: failure"]


@pytest.mark.parametrize(
    ("kind", "message", "problem"),
    [
        ("PointStamped", stamped("PointStamped", point=pose(math.nan).position), "not finite"),
        ("Wrench", wrench(vector(math.inf), vector(0.0)), "a vector is not finite"),
        ("GridCells", cells(0.0), "its cells are 0 x 0 m"),
        ("Pose", stamped("PoseStamped", pose=pose(math.nan)), "is not finite"),
        ("Path", path_of(0.0, math.nan), "a position is not finite"),
        ("PointCloud2", cloud((1.0, 2.0), fields="xy"), "without x, y and z; its fields: x, y"),
        ("PointCloud2", cloud(*ROWS, data=np.zeros(5, np.uint8)), "of 5 bytes is too short"),
        ("ParticleCloud", b"\0\1\0\0", "too short"),
        ("Image", make(f"{SENSORS}/CompressedImage", format="x", data=np.zeros(9, "u1")), "'x'"),
    ],
)
def test_what_makes_no_sense_is_said(kind: str, message: Any, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        taken(kind, message)
