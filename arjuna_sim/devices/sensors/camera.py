"""Cameras: their pictures, and the topics of colours, distances and points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import is_true, plain, remappings, text_of, value
from arjuna_sim.model.look import PIXELS_MAX
from arjuna_sim.model.settings import SensorSettings, chooses, reads
from arjuna_sim.model.urdf import Urdf

_WIDEST = 2.8  # field of view of a flat picture [rad]
_ENCODINGS = {
    **dict.fromkeys(("R8G8B8", "RGB_INT8"), "rgb8"),
    **dict.fromkeys(("B8G8R8", "BGR_INT8"), "bgr8"),
    **dict.fromkeys(("L8", "L_INT8"), "mono8"),
}
"""SDF's formats of colours, by ROS's names of them."""


@dataclass(frozen=True, kw_only=True)
class CameraSettings(SensorSettings):
    """A camera: size [pixels], field of view [rad], clip distances [m].

    Attributes:
        depth: Whether it measures distances rather than colours first.
        depth_topic: Topic of distances; "" for `depth/image_raw` beside the colours.
        cloud_topic: Topic of its points; "" for none.
        info_topic: Topic of its calibration; "" for `camera_info` beside the colours.
        noise: Standard deviation of each colour of a pixel, of 1.
        distortion: k1, k2, p1, p2 and k3 of its lens; none for an ideal one.
        depth_near: It measures no less [m].
        depth_far: And no more [m].
        encoding: How a picture's colours are written: rgb8, bgr8 or mono8.
    """

    TITLE: ClassVar[str] = "camera"
    IS_PRIMARY: ClassVar[bool] = True
    TOPIC: ClassVar[str] = "camera/image_raw"
    IS_OPTICAL: ClassVar[bool] = True
    width: int
    height: int
    horizontal_fov: float
    near: float
    far: float
    topic: str = TOPIC
    depth: bool = False
    depth_topic: str = ""
    cloud_topic: str = ""
    info_topic: str = ""
    noise: float = 0.0
    distortion: tuple[float, ...] = ()
    depth_near: float = 0.0
    depth_far: float = math.inf
    encoding: str = "rgb8"

    @property
    def title(self) -> str:
        """The kind of its first picture."""
        return "depth camera" if self.depth else "camera"

    def details(self) -> str:
        """Return size, field of view and distances."""
        view = math.degrees(self.horizontal_fov)
        near, far = max(self.near, self.depth_near), min(self.far, self.depth_far)
        return f"{self.width} x {self.height}, {view:.1f} deg, {near:g} to {far:g} m"

    def standard(self) -> CameraSettings:
        """Return it with the standard topics."""
        return replace(self, topic=CameraSettings.TOPIC, depth_topic="", info_topic="")


@reads("camera", "wideanglecamera", "multicamera")
def read_camera(tag: SensorTag) -> list[CameraSettings]:
    """Read a camera of colours."""
    return [_camera(tag, depth=False)]


@reads("depth", "depth_camera", "rgbd_camera", "rgbd")
def read_depth_camera(tag: SensorTag) -> list[CameraSettings]:
    """Read a camera of distances."""
    return [_camera(tag, depth=True)]


@chooses(1)
def first_camera(sensors: Sequence[SensorSettings], urdf: Urdf) -> CameraSettings | None:
    """Return the first colour camera, else the first depth camera."""
    cameras = [s for s in sensors if isinstance(s, CameraSettings)]
    return next((s for s in cameras if not s.depth), next(iter(cameras), None))


def _camera(tag: SensorTag, depth: bool) -> CameraSettings:
    xml, label, lens = tag.xml, tag.label, tag.element.find("camera")
    _note_unread(tag)
    frame = tag.text("opticalframeid", default=tag.frame).lstrip("/")
    mount = tag.mount(30.0, CameraSettings.TOPIC) | {"frame": frame}
    settings = CameraSettings(
        **(mount | _topics(tag.element, depth)),
        width=xml.count(lens, "image/width", 640, label),
        height=xml.count(lens, "image/height", 480, label),
        horizontal_fov=_view(tag, lens),
        near=xml.number(lens, "clip/near", 0.05, label),
        far=xml.number(lens, "clip/far", 100.0, label),
        depth=depth,
        noise=tag.deviation("camera/noise") or 0.0,
        distortion=_distortion(tag, depth),
        encoding=_encoding(tag, depth),
        **(_reach(tag, lens) if depth else {}),
    )
    if not (0 < settings.width <= PIXELS_MAX and 0 < settings.height <= PIXELS_MAX):
        size = f"{settings.width} x {settings.height}"
        raise tag.fail(f"image is {size}; valid: 1 to {PIXELS_MAX} pixels")
    if not 0.0 < settings.near < settings.far:
        raise tag.fail(f"<clip> {settings.near} to {settings.far} must be 0 < near < far")
    return settings


def _reach(tag: SensorTag, lens: Element | None) -> dict[str, Any]:
    """Return from where to where distances are measured: SDF's clips of depth, or a plugin's."""
    near = tag.xml.number(lens, "depth_camera/clip/near", 0.0, tag.label)
    far = tag.xml.number(lens, "depth_camera/clip/far", math.inf, tag.label)
    given = tag.xml, tag.element, tag.label
    near = value(*given, near, "mindepth", "pointcloudcutoff")
    return {"depth_near": near, "depth_far": value(*given, far, "maxdepth", "pointcloudcutoffmax")}


def _distortion(tag: SensorTag, depth: bool) -> tuple[float, ...]:
    keys = ("k1", "k2", "p1", "p2", "k3")
    found = tuple(tag.number(f"camera/distortion/{key}", 0.0) for key in keys)
    if not any(found):
        return ()
    if depth:
        tag.note("<distortion>: the distances and points are those of an ideal lens")
    if (tag.element.findtext("camera/distortion/center") or "0.5 0.5").split() != ["0.5", "0.5"]:
        tag.note("<distortion>: its <center> is taken to be the picture's middle")
    return found


def _encoding(tag: SensorTag, depth: bool) -> str:
    """Return how colours are written."""
    given = (tag.element.findtext("camera/image/format") or "R8G8B8").strip()
    encoding = _ENCODINGS.get(given.upper())
    if encoding is None and not depth:  # a format of depths is no colours'
        tag.note(f"<format> {given}: its pictures are rgb8; valid: {', '.join(_ENCODINGS)}")
    return encoding or "rgb8"


def _note_unread(tag: SensorTag) -> None:
    kind = (tag.element.findtext("camera/lens/type") or "gnomonical").strip()
    if kind != "gnomonical" or tag.element.find("camera/lens/intrinsics") is not None:
        tag.note("<lens>: its pictures are flat (gnomonical), as <horizontal_fov> says")
    if is_true(tag.element.findtext("camera/triggered") or ""):
        tag.note("<triggered>: it takes pictures at its rate, without being asked")


def _view(tag: SensorTag, lens: Element | None) -> float:
    angle = tag.xml.number(lens, "horizontal_fov", 1.047, tag.label)
    if not 0.0 < angle <= 2.0 * math.pi:
        raise tag.fail(f"<horizontal_fov> is {angle}; valid: above 0, up to 2 pi")
    if angle > _WIDEST:
        tag.note(f"<horizontal_fov> {angle:g} is cut to {_WIDEST:g}, as it has no lens")
    return min(angle, _WIDEST)


def _topics(sensor: Element, depth: bool) -> dict[str, str]:
    """Return the topics of colours, distances, points and the calibration.

    ROS plugins join `<camera>/<image>`; gz-sim makes all of them of one `<topic>`.
    """
    plugin, given = sensor.find("plugin"), text_of(sensor, "imagetopicname", "cameraname")
    own = next((c.text.strip() for c in sensor if plain(c.tag) == "topic" and c.text), "")
    if own and own != "__default_topic__" and not given and not any(remappings(sensor)):
        info = text_of(sensor, "camerainfotopic") or sensor.findtext("camera/camera_info_topic")
        return _of_gz(sensor, own, depth) | ({"info_topic": info.strip()} if info else {})
    if plugin is None and not given:
        return {"topic": CameraSettings.TOPIC} | ({"cloud_topic": "camera/points"} if depth else {})
    found = {"topic": _of_ros(sensor, "image_raw", "imagetopicname")}
    if depth:
        distances = _of_ros(sensor, "depth/image_raw", "depthimagetopicname")
        points = _of_ros(sensor, "points", "pointcloudtopicname")
        found |= {"depth_topic": distances, "cloud_topic": points}
    info, beside = _of_ros(sensor, "camera_info", ""), found["topic"].rpartition("/")[0]
    if any(remappings(sensor)) and info.rpartition("/") != (beside, "/", "camera_info"):
        found |= {"info_topic": info}
    return found


def _of_ros(sensor: Element, last: str, tag: str) -> str:
    """Return the topic of one of a ROS plugin's pictures: its camera's, its last part or a remap.

    A remapping counts where it names this topic whole, as in ROS: of `camera/image_raw` a bare
    `image_raw:=X` remaps nothing (gazebo_ros_pkgs, gazebo_ros_camera.cpp).

    Args:
        tag: The plain name of its tag in ROS 1's plugin.
    """
    camera, given = text_of(sensor, "cameraname"), text_of(sensor, tag)
    # ROS 2's plugin, which has no such tags, names the camera as its sensor.
    own = camera or ("" if text_of(sensor, "imagetopicname") else sensor.get("name", "").strip())
    space = text_of(sensor, "robotnamespace", "namespace").strip("/")
    plugin = sensor.find("plugin")
    node = "" if plugin is None else plugin.get("name", "")

    def whole(name: str) -> str:
        """Return a name as ROS completes that of a node's topic."""
        name = f"{node}/{name[2:]}" if name.startswith("~/") else name
        return f"/{space}/{name}" if space and not name.startswith("/") else name

    found = whole(f"{own}/{given or last}" if own and not given.startswith("/") else given or last)
    rules = ((whole(source), whole(target)) for source, target in remappings(sensor))
    return next((new for old, new in rules if old.lstrip("/") == found.lstrip("/")), found)


def _of_gz(sensor: Element, own: str, depth: bool) -> dict[str, str]:
    if "rgbd" in plain(sensor.get("type", "")):
        names = {"topic": "image", "depth_topic": "depth_image", "cloud_topic": "points"}
        return {key: f"{own}/{name}" for key, name in names.items()} | {
            "info_topic": f"{own}/camera_info"
        }
    if not depth:
        return {"topic": own}
    return {"topic": f"{own}/image", "depth_topic": own, "cloud_topic": f"{own}/points"}
