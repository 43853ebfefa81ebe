"""Replacing SDF's includes by what they include, and populations by their models."""

from __future__ import annotations

import copy
import math
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement  # types and copies; parsing is defusedxml's

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import InputFileError, WorldError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.frames import MERGE, raw_pose
from arjuna_sim.files.tag_text import is_true
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.world import GROUND, GROUND_COLOUR

_MODELS_MAX = 5_000
_LINES = {"linear-x": 0, "linear-y": 1, "linear-z": 2}
BUILT_IN = ("sun", "ground_plane")
SUN_TYPE = "sun"
"""Type of the light that `model://sun` becomes."""
_NESTED_MAX = 32
_OVERRIDES = ("pose", "static", "placement_frame")


def populate(xml: XmlFile, element: Element) -> Iterator[Element]:
    """Yield the models of a `<population>`, each with a name and a pose.

    Random positions are drawn from a seed of the population's own name: the same each time.

    Raises:
        WorldError: It has no model, no region, or a value is invalid.
    """
    name = element.get("name", "population")
    label = f"population '{name}'"
    source = element.find("model")
    if source is None:
        source = xml.child(element, "include", label)
    T_world = raw_pose(xml, element, label)
    own = raw_pose(xml, source, label) if source.find("pose") is not None else ORIGIN
    for number, point in enumerate(_points(xml, element, label)):
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


def _points(xml: XmlFile, element: Element, label: str) -> Floats:
    """Return where the copies stand in the population's frame, `(N, 3) float64` [m]."""
    spread = element.find("distribution")
    kind = "random" if spread is None else (spread.findtext("type") or "random").strip()
    if kind == "grid" and spread is not None:
        return _grid(xml, spread, label)
    count = xml.count(element, "model_count", 1, label)
    if not 0 <= count <= _MODELS_MAX:
        raise xml.fail(label, f"<model_count> is {count}; valid: 0 to {_MODELS_MAX}")
    box, cylinder = element.find("box"), element.find("cylinder")
    if box is not None:
        size = np.array(xml.sizes(box.findtext("size") or "", 3, f"{label} <size>"))
        radius = math.inf
    elif cylinder is not None:
        radius = xml.sizes(cylinder.findtext("radius") or "", 1, f"{label} <radius>")[0]
        length = xml.sizes(cylinder.findtext("length") or "1", 1, f"{label} <length>")[0]
        size = np.array([2.0 * radius, 2.0 * radius, length])
    else:
        raise xml.fail(label, "lacks its region; valid: <box>, <cylinder>")
    if kind in _LINES:
        points = np.zeros((count, 3))
        along = _LINES[kind]
        points[:, along] = (np.arange(count) + 0.5) / max(1, count) * size[along] - size[along] / 2
        return points
    return _random(label, kind, count, size, radius)


def _grid(xml: XmlFile, spread: Element, label: str) -> Floats:
    rows, columns = (xml.count(spread, key, 1, label) for key in ("rows", "cols"))
    if not (rows >= 0 and columns >= 0 and rows * columns <= _MODELS_MAX):
        raise xml.fail(label, f"has {rows} x {columns} models; valid: up to {_MODELS_MAX}")
    step = xml.numbers(spread.findtext("step") or "1 1 0", 3, f"{label} <step>")
    row, column = np.divmod(np.arange(rows * columns), max(1, columns))
    middle = (np.array([columns, rows]) - 1) / 2
    x, y = (column - middle[0]) * step[0], (row - middle[1]) * step[1]
    return np.column_stack((x, y, np.zeros(len(x))))


def _random(label: str, kind: str, count: int, size: Floats, radius: float) -> Floats:
    """Draw positions; of `uniform` ones each lies far from those before."""
    rng = np.random.default_rng(zlib.crc32(label.encode()))
    points = np.zeros((0, 3))
    for _ in range(count):
        # Of 20 random positions the one farthest from the others is taken.
        tries = (rng.random((20, 3)) - 0.5) * size
        inside = tries[np.hypot(tries[:, 0], tries[:, 1]) <= radius]
        tries = inside if len(inside) else np.zeros((1, 3))
        best = 0
        if kind == "uniform" and len(points):
            gaps = np.linalg.norm(tries[:, None] - points[None], axis=2).min(axis=1)
            best = int(np.argmax(gaps))
        points = np.vstack((points, tries[best]))
    return points


class ExcessError(WorldError):
    """A world holds more than is read: all of it is refused."""


@contextmanager
def leaving_out(xml: XmlFile, what: str) -> Iterator[None]:
    """Leave out a piece of a world that is broken, with a note."""
    try:
        yield
    except ExcessError:
        raise
    except InputFileError as error:
        origin = "" if error.location is None or error.location == what else f"{error.location}: "
        of = "visual" if what.endswith("visual") else ""
        xml.note(f"{what} is left out: {origin}{error.problem}", NoteKind.BROKEN, of)


class Includes:
    """Replaces the includes of a world by their models, and keeps the file of each model.

    Attributes:
        missing: Where the models should be that are not there.
    """

    def __init__(self, xml: XmlFile) -> None:
        self._root = xml
        self._files: dict[Path, XmlFile] = {}
        self._found: dict[tuple[Path, str], Path | None] = {}
        self._of_model: dict[int, XmlFile] = {}
        self._count = 0
        self.missing: list[str] = []

    def file_of(self, model: Element, default: XmlFile) -> XmlFile:
        """Return the file that an included model is from, else the default."""
        return self._of_model.get(id(model), default)

    def expand(self, xml: XmlFile, parent: Element) -> None:
        """Replace all includes below a `<world>`, `<sdf>` or `<model>`, however deep.

        What cannot be included is left out with a note.

        Raises:
            ExcessError: There are too many, or models are nested too deeply.
        """
        self._expand(xml, parent, (xml.path.resolve(),), 0)

    def _expand(self, xml: XmlFile, parent: Element, chain: tuple[Path, ...], depth: int) -> None:
        if depth > _NESTED_MAX:
            label = f"model '{parent.get('name', '?')}'"
            problem = f"is nested too deeply; valid: up to {_NESTED_MAX} models"
            raise ExcessError(xml.path, problem, label)
        for child in list(parent):
            if child.tag == "population":
                with leaving_out(xml, f"population '{child.get('name', '?')}'"):
                    self._add_population(xml, parent, child)
                parent.remove(child)
        for i, child in enumerate(list(parent)):
            if child.tag == "model":
                self._expand(xml, child, chain, depth + 1)
            elif child.tag == "include":
                parent[i] = self._replacement(xml, child, chain, depth)

    def _add_population(self, xml: XmlFile, parent: Element, element: Element) -> None:
        for model in populate(xml, element):
            self._tally(xml, f"population '{element.get('name', '?')}'")
            parent.append(model)

    def _tally(self, xml: XmlFile, label: str) -> None:
        self._count += 1
        if self._count > _MODELS_MAX:
            problem = f"is one of too many; valid: up to {_MODELS_MAX} includes"
            raise ExcessError(xml.path, problem, label)

    def _replacement(
        self, xml: XmlFile, element: Element, chain: tuple[Path, ...], depth: int
    ) -> Element:
        """Return what an include stands for, or an empty frame where it is left out."""
        uri = "".join((element.findtext("uri") or "").split("\n")).strip()
        with leaving_out(xml, f"include '{uri}'"):
            found = self._included(xml, element, uri, chain, depth)
            if found is not None:
                return found
        return Element("frame", name=(element.findtext("name") or _last(uri)).strip())

    def _included(
        self, xml: XmlFile, element: Element, uri: str, chain: tuple[Path, ...], depth: int
    ) -> Element | None:
        label = f"include '{uri}'"
        if not uri:
            raise xml.fail(label, "lacks its <uri>; valid: as model://ground_plane")
        name = _last(uri).lower().replace(" ", "_")
        if name == "sun":
            return Element("light", name=name, type=SUN_TYPE)
        self._tally(xml, label)
        inner = None
        if name == GROUND:
            model = _ground_model()
        else:
            inner = self._open(xml, uri, label, chain)
            if inner is None:
                return None
            model = copy.deepcopy(_content(inner))
            self._of_model[id(model)] = inner
        _override(model, element, name)
        if inner is not None and model.tag == "model":
            self._expand(inner, model, (*chain, inner.path.resolve()), depth + 1)
        return model

    def _open(self, xml: XmlFile, uri: str, label: str, chain: tuple[Path, ...]) -> XmlFile | None:
        """Return the file that is included; None (and a note) where there is none."""
        if (xml.path, uri) not in self._found:
            self._found[xml.path, uri] = xml.find_model(uri, label)
        path = self._found[xml.path, uri]
        if path is None:
            self.missing.append(uri)
            built_in = ", ".join(BUILT_IN)
            problem = f"model '{uri}' does not exist, so it is left out; built in: {built_in}"
            xml.note(f"include: {problem}", NoteKind.MISSING)
            return None
        path = path.resolve()
        if path in chain:
            raise xml.fail(label, f"model '{uri}' includes itself")
        if path not in self._files:
            self._files[path] = self._root.beside_it(path)
        return self._files[path]


def _last(uri: str) -> str:
    return uri.strip("/").rpartition("/")[2]


def _content(inner: XmlFile) -> Element:
    """Return the model, actor or light of an included file."""
    for tag in ("model", "actor", "light"):
        found = inner.root.find(tag)
        if found is not None:
            return found
    raise inner.fail("sdf", "holds no <model>, <actor> or <light>")


def _override(model: Element, include: Element, name: str) -> None:
    """Let an include's own name, pose and the like win over those of the model; add plug-ins."""
    model.set("name", (include.findtext("name") or model.get("name") or name).strip())
    for tag in _OVERRIDES:
        wanted = include.find(tag)
        if wanted is None:
            continue
        for own in model.findall(tag):
            model.remove(own)
        model.append(wanted)
    model.extend(include.findall("plugin"))
    frame = include.findtext("placement_frame")
    if frame is not None:
        model.set("placement_frame", frame.strip())
    if is_true(include.get(MERGE)):
        model.set(MERGE, "true")


def _ground_model() -> Element:
    model = Element("model", name=GROUND)
    SubElement(model, "static").text = "true"
    link = SubElement(model, "link", name="link")
    for tag in ("collision", "visual"):
        part = SubElement(link, tag, name=tag)
        SubElement(SubElement(part, "geometry"), "plane")
        colour = " ".join(map(str, GROUND_COLOUR))
        SubElement(SubElement(part, "material"), "diffuse").text = colour
    return model
