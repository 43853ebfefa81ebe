"""Files that are broken in one way each: what is said names the cause and what to do about it."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_sim.check import check
from arjuna_sim.files.search_path import SearchPath

pytestmark = pytest.mark.usefixtures("without_sills")

INERTIA = "ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'"
BASE = f"""<link name='base'><inertial><mass value='5'/><inertia {INERTIA}/></inertial>
<collision><geometry><box size='0.4 0.3 0.1'/></geometry></collision></link>"""
WHEEL = """<link name='{0}'><collision><geometry><cylinder radius='0.07' length='0.03'/></geometry>
</collision></link><joint name='{0}_joint' type='continuous'><parent link='base'/>
<child link='{0}'/><origin xyz='0 {1} 0' rpy='-1.57 0 0'/><axis xyz='0 0 1'/></joint>"""
DRIVE = """<gazebo><plugin name='d' filename='libgazebo_ros_diff_drive.so'>
<left_joint>l_joint</left_joint><right_joint>r_joint</right_joint></plugin></gazebo>"""
PLANAR = "<gazebo><plugin name='d' filename='libgazebo_ros_planar_move.so'/></gazebo>"
PARTS = BASE + WHEEL.format("l", 0.2) + WHEEL.format("r", -0.2) + DRIVE
STEER = """<link name='s'/><joint name='steer' type='revolute'><parent link='base'/>
<child link='s'/><axis xyz='0 0 1'/>{}</joint>"""
FIXED = "<joint name='j' type='fixed'><parent link='{}'/><child link='{}'/></joint>"
FUEL = "https://fuel.gazebosim.org/1.0/OpenRobotics/models/"
INCLUDE = "<include><uri>{}</uri></include>"
MODEL = """<model name='m'><static>1</static>{}<link name='l'><collision name='c'><geometry>{}
</geometry></collision></link></model>"""
BOX = "<box><size>1 1 1</size></box>"


def macros(inside: str) -> str:
    return f"<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>{inside}</robot>"


def robot(inside: str = PARTS, old: str = "", new: str = "") -> str:
    assert old in inside
    return f"<robot name='r'>{inside.replace(old, new, 1) if old else inside}</robot>"


def world(inside: str) -> str:
    return f"<sdf version='1.9'><world name='w'>{inside}</world></sdf>"


FETCH = "<xacro:include filename='$(find fetch_description)/urdf/base.xacro'/>"
UR = "<xacro:include filename='$(find ur_description)/urdf/ur.xacro'/><xacro:ur name='u'/>"
REFUSED: dict[str, tuple[str, str]] = {
    "package.xacro": (
        macros(FETCH + "<link name='a'/>" + FIXED.format("base_link", "a")),
        r"package 'fetch_description' does not exist; --package-path .* so joint 'j': parent link",
    ),
    "macro_of_package.xacro": (
        macros(UR + "<link name='tool'/>" + FIXED.format("tool0", "tool")),
        r"package 'ur_description' does not exist; --package-path .*'tool0' does not exist",
    ),
    "only_includes.xacro": (
        macros(FETCH),
        r"package 'fetch_description' does not exist; --package-path .* so has no links",
    ),
    "beside.xacro": (
        macros("<xacro:include filename='w.xacro'/><link name='a'/>" + FIXED.format("a", "b")),
        r"include: '.*w\.xacro' does not exist.*so joint 'j': child link 'b' does not exist",
    ),
    "bodiless.urdf": (
        robot(BASE + PLANAR, "<box size='0.4 0.3 0.1'/>", "<mesh filename='package://p/b.stl'/>"),
        r"stand below what is not there: link '.*' collision: mesh 'package://p/b.stl' .*; --pack",
    ),
    "macros_only.xacro": (
        macros("<xacro:macro name='a200' params='p'><link name='${p}'/></xacro:macro>"),
        r"only defines macros \(a200\) .* give a file that calls <xacro:a200 \.\.\./>",
    ),
    "unknown_macro.xacro": (
        macros("<link name='a'/><xacro:whel name='l'/>"),
        r"unknown macro name: xacro:whel; <xacro:include> a file that defines it",
    ),
    "unknown_property.xacro": (
        macros("<link name='${named}'/>"),
        r"'named' is not defined .*; <xacro:property> or <xacro:arg> defines it",
    ),
    "parameter.xacro": (
        macros("<xacro:macro name='m' params='a'><link name='${a}'/></xacro:macro><xacro:m/>"),
        r"Undefined parameters \[a\]; a call of its macro must give it a value",
    ),
    "expression.xacro": (macros("<link name='${1 +}'/>"), r"invalid syntax.*in \$\{\} is Python"),
    "no_limit.urdf": (
        robot(PARTS + STEER.format("")),
        "joint 'steer': lacks <limit>; valid: its lower and upper, or type 'continuous'",
    ),
    "crossed.urdf": (
        robot(PARTS + STEER.format("<limit lower='1' upper='-1'/>")),
        r"joint 'steer': limit lower 1\.0 is above upper -1\.0; swap them",
    ),
    "limit_of_words.urdf": (
        robot(PARTS + STEER.format("<limit lower='-pi' upper='1'/>")),
        r"joint 'steer' lower: '-pi' is no number; valid: as 1\.57, or inf",
    ),
    "typo.urdf": (
        robot(old="<parent link='base'/>", new="<parent link='bass'/>"),
        "joint 'l_joint': parent link 'bass' does not exist; did you mean 'base'",
    ),
    "two_roots.urdf": (
        robot(PARTS + "<link name='alone'/>"),
        "one root link; it has: base, alone; a fixed joint ties each to 'base'",
    ),
    "loop.urdf": (
        robot("<link name='a'/>" + FIXED.format("a", "a")),
        "one root link; it has: none, the joints form a loop: one must go",
    ),
    "two_parents.urdf": (
        robot(PARTS + FIXED.format("l", "r")),
        "joint 'j': link 'r' has two parents, 'base' and 'l'; one is valid",
    ),
    "twice.urdf": (robot(PARTS + "<link name='l'/>"), "link 'l': is there twice; each .* once"),
    "joint_twice.urdf": (
        robot(old="name='r_joint'", new="name='l_joint'"),
        "joint 'l_joint': is there twice",
    ),
    "kind.urdf": (
        robot(old="'continuous'", new="'rotational'"),
        "joint 'l_joint': type 'rotational' is not simulated; valid: .*continuous",
    ),
    "axis.urdf": (
        robot(old="<axis xyz='0 0 1'/>", new="<axis xyz='0 0 0'/>"),
        "joint 'l_joint': axis must not be zero; valid: as 0 0 1",
    ),
    "nan.urdf": (robot(old="value='5'", new="value='nan'"), "'base' inertial mass: 'nan' must be"),
    "heavy.urdf": (robot(old="value='5'", new="value='1e9'"), "inertial mass.*valid: 0 to 1e.07"),
    "inertia.urdf": (robot(old="ixx='0.01'", new="ixx='nan'"), "'base' inertial ixx.*finite"),
    "light.urdf": (robot(old="value='5'", new="value='-5'"), "mass: weighs -5 kg; valid: 0 to"),
    "word.urdf": (robot(old="0 0.2 0", new="0 left 0"), "'0 left 0' is not 3 numbers"),
    "two.urdf": (robot(old="0 0.2 0", new="0 0.2"), r"has 2 numbers \('0 0\.2'\); valid: 3"),
    "no_child.urdf": (robot(old="<child link='l'/>"), "joint 'l_joint': <joint> lacks <child>"),
    "shape.urdf": (robot(old="<cylinder ", new="<cilinder "), "<cilinder> is unknown; did you mea"),
    "wheel.urdf": (
        robot(old="<left_joint>l_joint", new="<left_joint>left_joint"),
        "plugin 'd': joint 'left_joint' does not exist; did you mean 'l_joint'",
    ),
    "no_links.urdf": (robot("<material name='m'/>"), "has no links; valid: one or more"),
    "cut_off.urdf": (robot()[:-40], "is broken XML: .* it ends too early: fetch or save it again"),
    "empty.urdf": (" ", "is empty; valid: XML"),
    "page.urdf": ("<!DOCTYPE html><html>404</html>", "is a web page .*; download the file itself"),
    "stage.urdf": (
        "# a world of Stage\n",
        r"line 1: is no XML: it begins with '# a world of Stage",
    ),
    "binary.urdf": ("".join(map(chr, range(128))), "is no XML: it begins with"),
    "pointer.urdf": (
        "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 1234\n",
        "is a pointer of Git LFS; 'git lfs pull' .* fetches the file",
    ),
    "w.world.erb": (
        world("\n<% 3.times do |i| %><% end %>"),
        "line .*: is a template: load what ERB makes",
    ),
    "w.sdf.jinja": (
        world("{%- for i in range(3) %}{% endfor %}"),
        "is a template: load what Jinja makes",
    ),
    "w.world.em": (world("@[for i in range(3)]@[end for]"), "is a template: load what EmPy makes"),
    "cut_off.world": (world("")[:-4], "is broken XML: .* it ends too early"),
    "light.sdf": ("<sdf version='1.9'><light name='s'/></sdf>", "must hold a <world>, a <model>"),
}
NOTED: dict[str, tuple[str, str]] = {
    "fuel.sdf": (
        world("".join(INCLUDE.format(FUEL + name) for name in ("Depot", "Chair"))),
        "is an empty world now: 2 models of Fuel are not on this machine; 'gz fuel download -u",
    ),
    "models.world": (
        world(INCLUDE.format("model://house") + INCLUDE.format("model://ground_plane")),
        "is an empty world now: 1 model is not on this machine; --model-path DIR finds",
    ),
    "no_uri.world": (world("<include/>"), "lacks its <uri>; valid: as model://ground_plane"),
    "pose.world": (world(MODEL.format("<pose>1 2</pose>", BOX)), r"pose: has 2 numbers .*valid: 6"),
    "frame.world": (
        world(MODEL.format("<pose relative_to='dock'>0 0 0 0 0 0</pose>", BOX)),
        "model 'm' is left out: .*frame 'dock' does not exist; valid: m",
    ),
    "flat.world": (
        world(MODEL.format("", BOX.replace("1 1 1", "1 0 1"))),
        "model 'm' collision <size>: '1 0 1' must be above zero",
    ),
    "nan.world": (world(MODEL.format("<pose>nan 0 0 0 0 0</pose>", BOX)), "'m' pose.*finite"),
    "no_size.world": (world(MODEL.format("", "<box/>")), "<box> lacks <size>"),
    "blink.world": (world(MODEL.format("<blink/>", BOX)), "model 'm': <blink>: not simulated"),
    "mesh.world": (
        world(MODEL.format("", "<mesh><uri>model://house/wall.dae</uri></mesh>")),
        "mesh 'model://house/wall.dae' does not exist.*; --model-path DIR finds it below DIR",
    ),
    "mesh.urdf": (
        robot(old="<box size='0.4 0.3 0.1'/>", new="<mesh filename='package://p/base.stl'/>"),
        "mesh 'package://p/base.stl' does not exist.*; --package-path DIR finds it below DIR",
    ),
    "plugin.sdf": (world("<plugin name='lift' filename='liblift.so'/>"), "'lift': not simulated"),
}


def checked(folder: Path, name: str, text: str) -> str:
    path = folder / name
    path.write_text(text)
    found = check(path, SearchPath(), {})
    return "\n".join(note.text for note in found.notes)


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_names_its_cause_and_remedy(name: str, tmp_path: Path) -> None:
    text, said = REFUSED[name]
    with pytest.raises(InputFileError, match=said) as refusal:
        checked(tmp_path, name, text)
    assert name in str(refusal.value)


@pytest.mark.parametrize("name", NOTED)
def test_what_is_left_out_is_noted_with_its_cause_and_remedy(name: str, tmp_path: Path) -> None:
    text, said = NOTED[name]
    assert re.search(said, checked(tmp_path, name, text))


@pytest.mark.parametrize("start", ["gz-sim-{0}-system", "ignition-gazebo-{0}-system"])
def test_what_the_simulator_does_by_itself_is_not_noted(start: str, tmp_path: Path) -> None:
    systems = "physics", "sensors", "imu", "navsat", "contact", "user-commands", "scene-broadcaster"
    files = [*(start.format(name) for name in systems), "libgazebo_ros_init.so"]
    inside = "".join(f"<plugin name='p{i}' filename='{name}'/>" for i, name in enumerate(files))
    inside += INCLUDE.format("model://ground_plane")
    assert checked(tmp_path, "systems.sdf", world(inside)) == ""


@pytest.mark.parametrize("limit", ["lower='-inf' upper='inf'", "lower='-INFINITY' upper='1e16'"])
@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_a_joint_may_have_infinite_limits(limit: str, kind: str, tmp_path: Path) -> None:
    steer = STEER.format(f"<limit {limit}/>").replace("revolute", kind)
    assert "steer" not in checked(tmp_path, "r.urdf", robot(PARTS + steer))
