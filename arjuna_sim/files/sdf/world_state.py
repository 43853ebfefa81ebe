"""Reading the `<state>` of a world that Gazebo Classic saved: where models are, and how large."""

from __future__ import annotations

from xml.etree.ElementTree import Element, SubElement  # parsing is defusedxml's

from arjuna_core.pose3 import Pose3
from arjuna_sim.files.sdf.frames import raw_pose
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sensor_tag import is_system
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind


def stretch_models(xml: XmlFile, world: Element) -> None:
    """Stretch the shapes of models by the scales of the world's `<state>`.

    Gazebo saves models as they were before somebody stretched them, and their scales beside.

    Source: Gazebo Classic, Model::SetState and the SetScale of its shapes, which leave poses alone.
    """
    for state in _states(world, "state/model[scale]"):
        name = state.get("name", "")
        label = f"state of model '{name}'"
        with leaving_out(xml, label):
            factors = xml.sizes(state.findtext("scale") or "", 3, f"{label} <scale>")
            for model in world.findall("model"):
                if model.get("name", "").strip() == name:
                    for geometry in model.iterfind("link//geometry"):
                        _stretch(xml, geometry, factors, label)


def _states(world: Element, path: str) -> list[Element]:
    """Return the elements at a path below a world; none of one with systems of Gazebo Sim's.

    That knows no `<state>`: one that is left of Gazebo Classic moves nothing there.
    """
    is_sim = any(is_system(plugin) for plugin in world.iterfind("plugin"))
    return [] if is_sim else world.findall(path)


def _stretch(xml: XmlFile, geometry: Element, factors: tuple[float, ...], label: str) -> None:
    x, y, z = factors
    lengths = {
        "box": (("size", factors),),
        "mesh": (("scale", factors),),
        "sphere": (("radius", (max(factors),)),),
        "cylinder": (("radius", (max(x, y),)), ("length", (z,))),
    }
    for item in geometry:
        for tag, by in lengths.get(item.tag, ()):
            found = item.find(tag)
            if found is None:
                found = SubElement(item, tag)
                found.text = "1 1 1"  # a mesh's
            given = xml.numbers(found.text or "", len(by), f"{label} <{tag}>")
            found.text = " ".join(repr(a * b) for a, b in zip(given, by, strict=True))


def moved_models(xml: XmlFile, world: Element) -> dict[str, Pose3]:
    """Return where the world's `<state>` says that models have moved."""
    for tag in ("deletions", "insertions"):
        if _states(world, f"state/{tag}"):
            xml.note(f"<state> <{tag}>: not simulated", NoteKind.IGNORED)
    found: dict[str, Pose3] = {}
    for model in _states(world, "state/model"):
        name = model.get("name", "")
        if model.find("pose") is not None:
            with leaving_out(xml, f"state of model '{name}'"):
                found[name] = raw_pose(xml, model, f"state of model '{name}'")
    return found
