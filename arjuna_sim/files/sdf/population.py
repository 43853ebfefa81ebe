"""Reading SDF's populations: many copies of one model, spread over a region."""

from __future__ import annotations

import copy
import math
import zlib
from collections.abc import Iterator
from xml.etree.ElementTree import Element, SubElement  # types and copies; parsing is defusedxml's

import numpy as np
from numpy.typing import NDArray

from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.xml_file import XmlFile

_MODELS_MAX = 5_000
_LINES = {"linear-x": 0, "linear-y": 1, "linear-z": 2}
_TRIES = 20  # random places of which the one farthest from the others is taken


def populate(xml: XmlFile, element: Element) -> Iterator[Element]:
    """Yield the models of a `<population>`, each with a name and a pose.

    Random places are drawn from a seed of the population's own name: the same each time.

    Raises:
        WorldError: It has no model, no region, or a value is invalid.
    """
    name = element.get("name", "population")
    place = f"population '{name}'"
    source = element.find("model")
    if source is None:
        source = xml.child(element, "include", place)
    T_world = raw_pose(xml, element, place)
    own = raw_pose(xml, source, place) if source.find("pose") is not None else ORIGIN
    for number, point in enumerate(_points(xml, element, place)):
        model = copy.deepcopy(source)
        _rename(model, f"{(source.get('name') or source.findtext('name') or name)}_clone_{number}")
        x, y, z = point.tolist()
        placed = T_world @ Pose3((x, y, z)) @ own
        for old in model.findall("pose"):
            model.remove(old)
        numbers = (*placed.position, *placed.rpy())
        SubElement(model, "pose").text = " ".join(repr(value) for value in numbers)
        yield model


def _rename(model: Element, name: str) -> None:
    if model.tag == "model":
        model.set("name", name)
        return
    for old in model.findall("name"):
        model.remove(old)
    SubElement(model, "name").text = name


def _points(xml: XmlFile, element: Element, place: str) -> NDArray[np.float64]:
    """Return where the copies stand in the population's frame, `(N, 3) float64` [m]."""
    spread = element.find("distribution")
    kind = "random" if spread is None else (spread.findtext("type") or "random").strip()
    if kind == "grid" and spread is not None:
        return _grid(xml, spread, place)
    count = xml.count(element, "model_count", 1, place)
    if not 0 <= count <= _MODELS_MAX:
        raise xml.fail(place, f"<model_count> is {count}; valid: 0 to {_MODELS_MAX}")
    box, cylinder = element.find("box"), element.find("cylinder")
    if box is not None:
        size = np.array(xml.sizes(box.findtext("size") or "", 3, f"{place} <size>"))
        radius = math.inf
    elif cylinder is not None:
        radius = xml.sizes(cylinder.findtext("radius") or "", 1, f"{place} <radius>")[0]
        length = xml.sizes(cylinder.findtext("length") or "1", 1, f"{place} <length>")[0]
        size = np.array([2.0 * radius, 2.0 * radius, length])
    else:
        raise xml.fail(place, "lacks its region; valid: <box>, <cylinder>")
    if kind in _LINES:
        points = np.zeros((count, 3))
        along = _LINES[kind]
        points[:, along] = (np.arange(count) + 0.5) / max(1, count) * size[along] - size[along] / 2
        return points
    return _random(place, kind, count, size, radius)


def _grid(xml: XmlFile, spread: Element, place: str) -> NDArray[np.float64]:
    rows, columns = (xml.count(spread, key, 1, place) for key in ("rows", "cols"))
    if not (rows >= 0 and columns >= 0 and rows * columns <= _MODELS_MAX):
        raise xml.fail(place, f"has {rows} x {columns} models; valid: up to {_MODELS_MAX}")
    step = xml.numbers(spread.findtext("step") or "1 1 0", 3, f"{place} <step>")
    row, column = np.divmod(np.arange(rows * columns), max(1, columns))
    middle = (np.array([columns, rows]) - 1) / 2
    x, y = (column - middle[0]) * step[0], (row - middle[1]) * step[1]
    return np.column_stack((x, y, np.zeros(len(x))))


def _random(
    place: str, kind: str, count: int, size: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Draw places; of `uniform` ones each lies far from those before."""
    rng = np.random.default_rng(zlib.crc32(place.encode()))
    points = np.zeros((0, 3))
    for _ in range(count):
        tries = (rng.random((_TRIES, 3)) - 0.5) * size
        inside = tries[np.hypot(tries[:, 0], tries[:, 1]) <= radius]
        tries = inside if len(inside) else np.zeros((1, 3))
        best = 0
        if kind == "uniform" and len(points):
            gaps = np.linalg.norm(tries[:, None] - points[None], axis=2).min(axis=1)
            best = int(np.argmax(gaps))
        points = np.vstack((points, tries[best]))
    return points
