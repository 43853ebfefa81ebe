"""Reading the joints that SDF 1.10 and later let stand in a world, beside its models."""

from __future__ import annotations

import dataclasses
from xml.etree.ElementTree import Element  # types only; parsing is defusedxml's

from arjuna_core.pose3 import ORIGIN
from arjuna_sim.files.sdf.frames import Scope
from arjuna_sim.files.sdf.includes import leaving_out
from arjuna_sim.files.sdf.model_tags import WORLD, SdfJoint, is_static, read_joint
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind


def world_joints(xml: XmlFile, world: Element, scope: Scope) -> dict[str, list[SdfJoint]]:
    """Return a world's own joints by the model that each holds, as if they were that model's.

    What connects two models that both move is left out, with a note.

    Args:
        xml: The world's file.
        world: The `<world>`, its includes replaced.
        scope: Its frames.
    """
    models = {model.get("name", "").strip(): model for model in world.findall("model")}
    found: dict[str, list[SdfJoint]] = {}
    for element in world.findall("joint"):
        place = f"joint '{element.get('name', '?')}'"
        with leaving_out(xml, place):
            joint = read_joint(xml, element, scope, ORIGIN, "")
            ends = [_end(models, name) for name in (joint.parent, joint.child)]
            held = sorted({model for model, _ in ends if model != WORLD})
            if len(held) != 1:
                problem = "connects no model to what stands fast: not simulated"
                xml.note(f"{place}: {problem}", NoteKind.IGNORED)
                continue
            parent, child = (WORLD if model == WORLD else link for model, link in ends)
            found.setdefault(held[0], []).append(
                dataclasses.replace(joint, parent=parent, child=child)
            )
    return found


def _end(models: dict[str, Element], name: str) -> tuple[str, str]:
    """Return the model and the path of the link that a joint's end names; `WORLD` for what stands.

    A model's name alone stands for its canonical link, its first unless it says otherwise.
    """
    first, _, rest = name.partition("::")
    model = models.get(first)
    if model is None or is_static(model):
        return WORLD, ""
    link = model.find("link")
    canonical = "" if link is None else link.get("name", "")
    return first, rest or model.get("canonical_link", canonical)
