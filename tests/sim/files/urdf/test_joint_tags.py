"""Joints that follow others: which may, and what becomes of those whose leader is not there."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import RobotError
from arjuna_sim.files.urdf.links_and_joints import read_urdf
from arjuna_sim.files.xml_file import XmlFile
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.urdf import Joint, Mimic


def read(*joints: tuple[str, str, str]) -> tuple[dict[str, Joint], XmlFile]:
    """Return joints from a base to a link each, of a name, a kind and what more is told."""
    told = "".join(
        f"<link name='{name}_link'/><joint name='{name}' type='{kind}'><parent link='base'/>"
        f"<child link='{name}_link'/><limit lower='-1' upper='1'/>{more}</joint>"
        for name, kind, more in joints
    )
    text = f"<robot name='r'><link name='base'/>{told}</robot>".encode()
    xml = XmlFile(Path("r.urdf"), "robot", RobotError, text)
    return read_urdf(xml).joints, xml


def after(name: str, more: str = "") -> str:
    return f"<mimic joint='{name}' {more}/>"


def test_a_joint_follows_another_by_a_factor_and_an_offset() -> None:
    told = after("a", "multiplier='-2' offset='0.5'")
    joints, xml = read(
        ("a", "revolute", ""), ("b", "prismatic", told), ("c", "revolute", after("b"))
    )
    assert joints["a"].mimic is None
    assert joints["b"].mimic == Mimic("a", -2.0, 0.5)
    assert joints["c"].mimic == Mimic("b", 1.0, 0.0)
    assert not xml.notes


@pytest.mark.parametrize(
    ("leader", "follower"), [("fixed", "revolute"), ("revolute", "planar"), ("planar", "revolute")]
)
def test_only_joints_of_one_position_follow_each_other(leader: str, follower: str) -> None:
    with pytest.raises(RobotError, match=r"joint 'b' mimic.*only joints with one position"):
        read(("a", leader, ""), ("b", follower, after("a")))


def test_joints_do_not_follow_each_other_in_a_circle() -> None:
    with pytest.raises(RobotError, match="joints follow each other in a circle"):
        read(("a", "revolute", after("b")), ("b", "revolute", after("a")))
    with pytest.raises(RobotError, match="joints follow each other in a circle"):
        read(("a", "revolute", after("a")))


def test_a_joint_whose_leader_is_not_there_moves_freely() -> None:
    joints, xml = read(("a", "revolute", ""), ("b", "revolute", after("aa")))
    assert joints["b"].mimic is None
    (note,) = xml.notes
    assert note.kind is NoteKind.MISSING
    assert note.text.startswith("joint 'b' mimic: joint 'aa' does not exist; ")
    assert note.text.endswith("; it moves freely")
