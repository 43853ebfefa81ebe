"""Which links of a model move as one, and where a pose in any of SDF's spellings puts them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import WorldError
from arjuna_core.pose3 import Pose3
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.world import World

LINK = """<link name="{name}"><pose>{place} 0 0 0</pose><collision name="c"><geometry>
<box><size>0.2 0.2 0.2</size></box></geometry></collision>
<inertial><mass>{mass}</mass></inertial></link>"""
JOINT = """<joint name='{0}{1}' type='{2}'><parent>{0}</parent><child>{1}</child>
<axis><xyz>0 0 1</xyz></axis></joint>"""
APART = tuple(
    LINK.format(name=name, place=f"{x} 0 1", mass=mass)
    for name, x, mass in (("a", 0.0, 1.0), ("b", 1.0, 2.0), ("c", 2.0, 4.0))
)


def world(folder: Path, inside: str) -> World:
    path = folder / "w.world"
    path.write_text(
        f"<sdf version='1.9'><world name='w'><model name='m'>{inside}</model></world></sdf>",
        encoding="utf-8",
    )
    return load_world(path)


@pytest.mark.parametrize(
    ("joints", "masses"),
    [
        ((), [1.0, 2.0, 4.0]),
        ((("a", "b", "fixed"),), [3.0, 4.0]),
        ((("c", "a", "fixed"),), [2.0, 5.0]),
        ((("b", "c", "fixed"),), [1.0, 6.0]),
        ((("b", "c", "fixed"), ("a", "b", "fixed")), [7.0]),
        ((("a", "b", "revolute"),), [3.0, 4.0]),  # hold together: neither stands fast
        ((("a", "b", "fixed"), ("world", "c", "fixed")), [3.0]),
        ((("a", "world", "fixed"), ("b", "c", "fixed")), [6.0]),
        ((("world", "a", "fixed"), ("a", "b", "revolute")), [2.0, 4.0]),  # b swings
        ((("a", "nobody", "fixed"),), [1.0, 2.0, 4.0]),
    ],
)
def test_links_that_a_joint_fixes_move_as_one(
    tmp_path: Path, joints: tuple[tuple[str, str, str], ...], masses: list[float]
) -> None:
    found = world(tmp_path, "".join((*APART, *(JOINT.format(*joint) for joint in joints))))
    assert sorted(found.masses.values()) == pytest.approx(masses)


@pytest.mark.parametrize(("gap", "together"), [(0.19, True), (0.21, False)])
@pytest.mark.parametrize("way", ["{0} 0 1", "0 {0} 1", "0 0 {0}"])
def test_links_that_overlap_move_as_one(
    tmp_path: Path, gap: float, together: bool, way: str
) -> None:
    links = [
        LINK.format(name=name, place=way.format(at), mass=1.0)
        for name, at in (("a", 1.0), ("b", 1.0 + gap))
    ]
    found = world(tmp_path, "".join(links))
    assert sorted(found.masses.values()) == ([2.0] if together else [1.0, 1.0])


HALF = math.sqrt(0.5)


@pytest.mark.parametrize(
    ("attributes", "text", "pose"),
    [
        ("", "1 2 3 0 0 1.5", Pose3.from_rpy((1, 2, 3), (0.0, 0.0, 1.5))),
        ("", "1 2 3 0.1 0.2 0.3", Pose3.from_rpy((1, 2, 3), (0.1, 0.2, 0.3))),
        ("degrees='true'", "1 2 3 0 90 0", Pose3.from_rpy((1, 2, 3), (0.0, math.pi / 2, 0.0))),
        ("degrees='false'", "1 2 3 0 0 1", Pose3.from_rpy((1, 2, 3), (0.0, 0.0, 1.0))),
        ("rotation_format='quat_xyzw'", "1 2 3 0 0 1 1", Pose3((1, 2, 3), (HALF, 0, 0, HALF))),
        ("rotation_format='quat_xyzw'", "1 2 3 2 0 0 0", Pose3((1, 2, 3), (0, 1, 0, 0))),
        ("", "", Pose3()),
    ],
)
def test_a_pose_is_written_in_several_ways(
    tmp_path: Path, attributes: str, text: str, pose: Pose3
) -> None:
    found = world(tmp_path, f"<static>1</static><pose {attributes}>{text}</pose>{APART[1]}")
    (body,) = found.models["m"]
    expected = pose @ Pose3((1.0, 0.0, 1.0))
    np.testing.assert_allclose(body.part.pose.position, expected.position, atol=1e-12)
    np.testing.assert_allclose(body.part.pose.rotation(), expected.rotation(), atol=1e-12)


@pytest.mark.parametrize(
    ("frames", "problem"),
    [
        ("<frame name='f'><pose relative_to='g'/></frame>", "frame 'g' does not exist"),
        (
            "<frame name='f'><pose relative_to='g'/></frame>"
            "<frame name='g'><pose relative_to='f'/></frame>",
            "frame 'f' is relative to itself: f -> g -> f",
        ),
    ],
)
def test_a_frame_that_leads_nowhere_is_named(tmp_path: Path, frames: str, problem: str) -> None:
    link = "<link name='l'><pose relative_to='f'/><collision name='c'><geometry><sphere>\
<radius>1</radius></sphere></geometry></collision></link>"
    try:
        notes = " ".join(note.text for note in world(tmp_path, frames + link).notes)
    except WorldError as error:
        notes = str(error)
    assert problem in notes


def test_a_frame_is_where_what_it_is_attached_to_is(tmp_path: Path) -> None:
    inside = (
        "<static>1</static><frame name='f' attached_to='b'><pose>0 1 0 0 0 0</pose></frame>"
        + APART[1]
        + LINK.format(name="l", place="0 0 5", mass=1).replace("<pose>", "<pose relative_to='f'>")
    )
    places = sorted(body.part.pose.position for body in world(tmp_path, inside).models["m"])
    assert places[1] == pytest.approx((1.0, 1.0, 6.0))
