"""Reading an SDF world: its boxes, cylinders, spheres, planes and meshes."""

from __future__ import annotations

from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import ORIGIN, Pose3
from arjuna_sim.files.sdf.actor_tags import read_actor
from arjuna_sim.files.sdf.frames import Scope, raw_pose
from arjuna_sim.files.sdf.geometry_tags import read_colour, read_shape
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.actors import Actor
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.shapes import Kind, Part
from arjuna_sim.model.world import GROUND, Body, World, ground

BUILT_IN = ("sun", "ground_plane")
_UNLIT = (
    "light",
    "gui",
    "physics",
    "gravity",
    "scene",
    "plugin",
    "state",
    "magnetic_field",
    "frame",
)
_OF_MODEL = (
    *("link", "model", "include", "pose", "static", "frame", "joint", "plugin", "self_collide"),
    *("allow_auto_disable", "enable_wind", "placement_frame"),
)
_OF_LINK = (
    *("collision", "visual", "pose", "inertial", "gravity", "self_collide", "kinematic", "light"),
    *("velocity_decay", "enable_wind", "audio_source", "must_be_base_link"),
)
_BODIES_MAX = 20_000
_INCLUDES_MAX = 2_000
_NESTED_MAX = 32
_TRUE = ("true", "1")
_MASS = 1.0  # SDF's default [kg]
_MASS_MAX = 1e7  # [kg]


def read_world(xml: XmlFile) -> World:
    """Read a parsed SDF file.

    Raises:
        WorldError: It holds values or models that cannot be simulated.
    """
    found = xml.root.find("world")
    world = xml.root if found is None else found
    if found is None and xml.root.find("model") is None and xml.root.find("actor") is None:
        raise WorldError(xml.path, "<sdf> must hold a <world>, a <model> or an <actor>")
    if len(xml.root.findall("world")) > 1:
        xml.note("has more than one <world>: only the first is simulated")
    if sum(1 for e in world.iter() if e.tag in ("collision", "visual")) > _BODIES_MAX:
        raise WorldError(xml.path, f"has too many parts; valid: up to {_BODIES_MAX}")
    reader = _Reader(xml)
    reader.read(world)
    for plugin in world.iter("plugin"):
        xml.note(f"plugin '{plugin.get('name', '?')}': not simulated", NoteKind.IGNORED)
    bodies = reader.bodies
    if not any(body.part.shape.kind is Kind.PLANE and body.collides for body in bodies):
        xml.note("has no ground plane: one is put at height 0")
        bodies.extend(ground())
    name = world.get("name", "world")
    actors, notes = tuple(reader.actors), tuple(xml.notes)
    return World(xml.path, name, tuple(bodies), notes, actors, reader.masses)


class _Reader:
    """Collects a world's parts, from its file and those that it includes."""

    def __init__(self, xml: XmlFile) -> None:
        self._xml = xml
        self._includes = 0
        self._used: set[str] = set()
        self.bodies: list[Body] = []
        self.actors: list[Actor] = []
        self.masses: dict[str, float] = {}

    def read(self, world: Element) -> None:
        """Read a `<world>`, or an `<sdf>` that holds a model."""
        xml = self._xml
        scope, moved = Scope(xml, world, "world"), _states(xml, world)
        for element in world:
            if element.tag == "include":
                self._include(xml, element, scope, ORIGIN, moved)
            elif element.tag == "model":
                name = element.get("name", "")
                pose = moved.get(name) or scope.pose(element, f"model '{name}'")
                self._top(xml, element, pose, placed=name in moved)
            elif element.tag == "actor":
                self.actors.append(read_actor(xml, element, raw_pose(xml, element, "an actor")))
            elif element.tag not in _UNLIT:
                xml.note(f"<{element.tag}>: not simulated", NoteKind.IGNORED)

    def _top(self, xml: XmlFile, model: Element, pose: Pose3, placed: bool = False) -> None:
        """Read a model of the world, under a name of its own; note what it can be pushed as."""
        name = xml.attribute(model, "name", "a model")
        if name in self._used:
            free = next(n for i in range(1, 10_000) if (n := f"{name}_{i}") not in self._used)
            xml.note(f"model '{name}': is there twice; the second is called '{free}'")
            model.set("name", free)
            name = free
        self._used.add(name)
        first = len(self.bodies)
        self._model(xml, model, pose, 0, None, placed)
        new = self.bodies[first:]
        solid = [body.part.shape.kind for body in new if body.collides]
        if not _is_static(model) and solid and Kind.PLANE not in solid:
            self.masses[name] = _mass(xml, model, name)
            if len(list(model.iter("link"))) > 1:
                xml.note(f"model '{name}': its links hold together as one body")

    def _include(
        self,
        xml: XmlFile,
        element: Element,
        scope: Scope,
        T_world: Pose3,
        moved: dict[str, Pose3] | None = None,
        within: str | None = None,
        depth: int = 0,
    ) -> None:
        uri = (element.findtext("uri") or "").strip()
        place = f"include '{uri}'"
        name = uri.strip("/").rpartition("/")[2].lower().replace(" ", "_")
        if name == "sun":
            return
        if name == GROUND:
            self.bodies.extend(ground())
            return
        inner = self._open(xml, uri, place)
        if inner is None:
            return
        model = inner.child(inner.root, "model", "sdf")
        model.set("name", (element.findtext("name") or model.get("name") or name).strip())
        override = element.find("static")
        if override is not None:
            for own in model.findall("static"):
                model.remove(own)
            model.append(override)
        pose = T_world @ (
            raw_pose(inner, model, place)
            if element.find("pose") is None
            else scope.pose(element, place)
        )
        if element.find("placement_frame") is not None:
            model.set("placement_frame", (element.findtext("placement_frame") or "").strip())
        if within is None:
            state = (moved or {}).get(model.get("name", ""))
            self._top(inner, model, state or pose, placed=state is not None)
        else:
            self._model(inner, model, pose, depth, within)
        xml.keep(*inner.notes)

    def _open(self, xml: XmlFile, uri: str, place: str) -> XmlFile | None:
        """Return the file that is included; None (and a note) where there is none."""
        path = xml.find(f"{uri}/model.sdf", place)
        if path is None:
            built_in = ", ".join(BUILT_IN)
            problem = f"model '{uri}' does not exist, so it is left out; built in: {built_in}"
            xml.note(f"include: {problem}", NoteKind.MISSING)
            return None
        if path.resolve() in xml.included:
            raise xml.fail("include", f"model '{uri}' includes itself")
        self._includes += 1
        if self._includes > _INCLUDES_MAX:
            raise xml.fail(place, f"is one of too many; valid: up to {_INCLUDES_MAX} includes")
        inner = XmlFile(path, "sdf", WorldError, search=xml.search)
        inner.included += xml.included
        inner.meshes = xml.meshes
        return inner

    def _model(
        self,
        xml: XmlFile,
        model: Element,
        pose: Pose3,
        depth: int,
        within: str | None = None,
        placed: bool = False,
    ) -> None:
        """Read a model that stands at a pose in the world.

        Args:
            xml: Its file.
            model: The `<model>`.
            pose: Of the model, or of its placement frame.
            depth: How many models it is nested in.
            within: The model of the world that it is a part of; None for itself.
            placed: Whether the pose is surely the model's own.
        """
        name = xml.attribute(model, "name", "a model")
        place = f"model '{name}'"
        if depth > _NESTED_MAX:
            raise xml.fail(place, f"is nested too deeply; valid: up to {_NESTED_MAX} models")
        scope = Scope(xml, model, place)
        frame = model.get("placement_frame", "")
        T_world_model = pose if placed or not frame else pose @ scope.find(frame).inverse()
        owner = name if within is None else within
        for tag in sorted({child.tag for child in model} - set(_OF_MODEL)):
            xml.note(f"{place}: <{tag}>: not simulated", NoteKind.IGNORED)
        for link in model.findall("link"):
            self._link(xml, link, scope, T_world_model, (owner, place))
        for nested in model.findall("model"):
            T_nested = T_world_model @ scope.pose(nested, place)
            self._model(xml, nested, T_nested, depth + 1, owner)
        for include in model.findall("include"):
            self._include(xml, include, scope, T_world_model, None, owner, depth + 1)

    def _link(
        self, xml: XmlFile, link: Element, scope: Scope, T_world: Pose3, names: tuple[str, str]
    ) -> None:
        owner, place = names
        T_model_link = scope.pose(link, f"{place} link")
        for tag in sorted({child.tag for child in link} - set(_OF_LINK)):
            xml.note(f"{place}: <{tag}>: not simulated", NoteKind.IGNORED)
        for tag in ("collision", "visual"):
            for element in link.findall(tag):
                where = f"{place} {tag}"
                shape = read_shape(xml, xml.child(element, "geometry", where), where)
                if shape is None:
                    continue
                pose = T_world @ scope.pose(element, where, T_model_link)
                part = Part(shape, pose, read_colour(xml, element, where))
                self.bodies.append(Body(owner, part, tag == "collision", T_world))
                if len(self.bodies) > _BODIES_MAX:
                    raise xml.fail(where, f"is one of too many; valid: up to {_BODIES_MAX} parts")


def _states(xml: XmlFile, world: Element) -> dict[str, Pose3]:
    """Return where the world's `<state>` says that models have moved."""
    state = world.find("state")
    if state is None:
        return {}
    for tag in sorted({child.tag for child in state} & {"insertions", "deletions"}):
        xml.note(f"<state> <{tag}>: not simulated", NoteKind.IGNORED)
    return {
        model.get("name", ""): raw_pose(xml, model, f"state of model '{model.get('name', '')}'")
        for model in state.findall("model")
        if model.find("pose") is not None
    }


def _is_static(model: Element) -> bool:
    return (model.findtext("static") or "").strip().lower() in _TRUE


def _mass(xml: XmlFile, model: Element, name: str) -> float:
    """Return what a model weighs [kg]."""
    place = f"model '{name}' <mass>"
    total = 0.0
    for link in model.iter("link"):
        text = link.findtext("inertial/mass")
        total += _MASS if text is None else xml.positive(text, 1, place)[0]
    if not 0.0 < total <= _MASS_MAX:
        raise xml.fail(place, f"is {total:g} kg in all; valid: above 0, up to {_MASS_MAX:g}")
    return total
