"""The report of `sim --check` on a whole robot and a whole world, line by line."""

from __future__ import annotations

from pathlib import Path

import pytest

from arjuna_core.errors import InputFileError
from arjuna_sim.check import Found, check
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.inputs import turning_radius_of
from arjuna_sim.model.notes import Note, NoteKind
from tests.sim import drive_cases as cases
from tests.sim.builders import ROOM

_INERTIAL = '<inertial><mass value="{}"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial>'
_WHEEL = """<link name="{side}_wheel"><inertial><mass value="0.2"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4"/></inertial><collision><geometry>
<cylinder radius="0.08" length="0.03"/></geometry></collision></link>
<joint name="{side}_joint" type="continuous"><parent link="base"/><child link="{side}_wheel"/>
<origin xyz="0 {y} 0" rpy="-1.5707963 0 0"/><axis xyz="0 0 1"/></joint>"""
_SENSORS = """<gazebo reference="eye"><sensor name="front" type="ray"><update_rate>5</update_rate>
<pose>0.1 0 0.05 0 0 0</pose><ray><scan><horizontal><samples>180</samples>
<min_angle>-1.5707963</min_angle><max_angle>1.5707963</max_angle></horizontal></scan>
<range><min>0.1</min><max>8</max></range></ray></sensor>
<sensor name="imu" type="imu"><update_rate>100</update_rate></sensor>
<sensor name="cam" type="camera"><update_rate>15</update_rate><camera>
<horizontal_fov>1.0471976</horizontal_fov><image><width>320</width><height>240</height></image>
<clip><near>0.1</near><far>20</far></clip></camera></sensor></gazebo>"""
_PLUGIN = """<gazebo><plugin name="diff" filename="libgazebo_ros_diff_drive.so">
<left_joint>left_joint</left_joint><right_joint>right_joint</right_joint>
<wheel_separation>0.3</wheel_separation><wheel_diameter>0.16</wheel_diameter>
<max_wheel_torque>5</max_wheel_torque><max_wheel_acceleration>1.5</max_wheel_acceleration>
<command_topic>drive</command_topic><odometry_topic>wheel_odom</odometry_topic>
<odometry_frame>odo</odometry_frame><robot_base_frame>footprint</robot_base_frame>
<max_speed>0.75</max_speed><publish_odom>true</publish_odom>
<update_rate>25</update_rate></plugin></gazebo>"""
_ROBOT = f"""<robot name="r"><link name="base">{_INERTIAL.format(4)}
<collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision>
<visual><geometry><box size="0.4 0.2 0.1"/></geometry></visual>
<visual><geometry><sphere radius="0.05"/></geometry></visual></link>
<link name="eye"/><joint name="neck" type="fixed"><parent link="base"/><child link="eye"/>
<origin xyz="0.1 0 0.2"/></joint>
{_WHEEL.format(side="left", y=0.15)}{_WHEEL.format(side="right", y=-0.15)}
<link name="ball"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
<joint name="b" type="fixed"><parent link="base"/><child link="ball"/>
<origin xyz="-0.15 0 -0.05"/></joint>
<link name="arm">{_INERTIAL.format(0.5)}</link>
<joint name="lift" type="prismatic"><parent link="base"/><child link="arm"/>
<origin xyz="0 0 0.2"/><axis xyz="0 0 1"/><limit lower="-0.1" upper="0.25"/></joint>
<link name="jaw">{_INERTIAL.format(0.1)}</link>
<joint name="grip" type="revolute"><parent link="arm"/><child link="jaw"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1"/><mimic joint="lift"/></joint>
<gazebo reference="base"><mu1>0.7</mu1><kp>1e5</kp></gazebo>{_SENSORS}{{plugin}}</robot>"""

_SAID = """{path}: loads
robot 'r', root link 'base'
  links (7):
    base: 4 kg; solid: box 0.4 x 0.2 x 0.1; drawn: box 0.4 x 0.2 x 0.1, sphere 0.05
    eye: massless; solid: nothing; drawn: nothing
    left_wheel: 0.2 kg; solid: cylinder 0.08 x 0.03; drawn: nothing
    right_wheel: 0.2 kg; solid: cylinder 0.08 x 0.03; drawn: nothing
    ball: massless; solid: sphere 0.03; drawn: nothing
    arm: 0.5 kg; solid: nothing; drawn: nothing
    jaw: 0.1 kg; solid: nothing; drawn: nothing
  joints (6): 2 continuous, 2 fixed, 1 prismatic, 1 revolute
    left_joint: continuous, base -> left_wheel
    right_joint: continuous, base -> right_wheel
    lift: prismatic -0.1 to 0.25, base -> arm
    grip: revolute -1 to 1, arm -> jaw, follows lift
  outline from above, a costmap's footprint: {outline}
{drive}
  lidar: topic scan, frame eye_front (eye in the file), 5 Hz, on eye + (0.1, 0, 0.05)
    180 samples, -90.0 to 90.0 deg, 0.1 to 8 m, noise 0 m
  camera: topic camera/image_raw, frame eye_optical_frame (eye in the file), 15 Hz, on eye
    320 x 240, 60.0 deg, 0.1 to 20 m
  imu: topic imu/data, frame eye, 100 Hz, on eye
  friction of base: 0.7
  friction of ball: 0.01
  contact of base: kp 100000 (the simulator's own tyres hold instead)
  stands with 'base' 0.08 m above the ground
not simulated, or otherwise than the file says ({count}):{notes}
  - leans by {degrees} degrees soon: it tips over, or would have to balance"""
_OUTLINE = "[[-0.2, 0.1], [-0.2, -0.1], [-0.08, -0.165], [0.08, -0.165],"
_OUTLINE += " [0.2, -0.1], [0.2, 0.1], [0.08, 0.165], [-0.08, 0.165]]"
_NAMED = """  drive: plugin 'diff'
    left: left_joint; right: right_joint
    wheel separation 0.3 m, diameter 0.16 m
    turns as a track of 0.3 m, rolls as a radius of 0.08 m
    torque 5 N m, acceleration 1.5 m/s^2, unlimited rad/s^2
    speed 0.75 m/s, unlimited rad/s, rate 25 Hz
    commands on drive, odometry on wheel_odom
    odometry of the encoders, odo -> base (its root link; the file says footprint)
    in launch files it begins at the pose in the world, as Gazebo Classic's there
    publishes: odom, odom_tf"""
_GUESSED = """  drive: guessed (--save-guess FILE keeps it)
    left: left_joint; right: right_joint
    wheel separation 0.3 m, diameter 0.16 m
    turns as a track of 0.3 m, rolls as a radius of 0.08 m
    torque 5 N m, acceleration unlimited m/s^2, unlimited rad/s^2
    speed unlimited m/s, unlimited rad/s, rate unlimited Hz
    commands on cmd_vel, odometry on odom
    odometry of the encoders, odom -> base
    publishes: odom, odom_tf"""
_NOTE = """
  - no drive plugin: guessed are the wheels left_joint (left) and right_joint (right),\
 separation 0.3 m, radius 0.08 m"""


def _found(folder: Path, name: str, text: str) -> Found:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return check(path, SearchPath(), {})


@pytest.mark.parametrize(
    ("plugin", "drive", "notes", "degrees"),
    [(_PLUGIN, _NAMED, "", 7), ("", _GUESSED, _NOTE, 6)],  # which speeds up at once
)
def test_a_robot_is_reported_link_by_link(
    tmp_path: Path, plugin: str, drive: str, notes: str, degrees: int
) -> None:
    found = _found(tmp_path, "r.urdf", _ROBOT.format(plugin=plugin))
    expected = _SAID.format(
        path=tmp_path / "r.urdf",
        outline=_OUTLINE,
        drive=drive,
        count=1 + bool(notes),
        notes=notes,
        degrees=degrees,
    )
    lines = found.text().splitlines()
    sill = [line for line in lines if line.startswith("  crosses sills of ")]
    assert [line for line in lines if line not in sill] == expected.splitlines()
    assert len(sill) == 1
    assert sill[0].endswith(" mm at 0.3 m/s; a higher one stops base")


def test_links_of_one_friction_share_a_line(tmp_path: Path) -> None:
    """Thirty-six rollers were seventy-two lines."""
    grip = "<gazebo reference='{}'><mu1>{}</mu1><kp>5e4</kp></gazebo>"
    given = (("left_wheel", 0.5), ("base", 0.7), ("right_wheel", 0.5))
    text = _ROBOT.format(plugin="").replace("<mu1>0.7</mu1>", "")
    text = text.replace("</robot>", "".join(grip.format(*each) for each in given) + "</robot>")
    said = _found(tmp_path, "r.urdf", text).lines
    assert "  friction of left_wheel, right_wheel: 0.5" in said
    (contact,) = (line for line in said if line.startswith("  contact of ") and "50000" in line)
    assert contact.startswith("  contact of base, left_wheel, right_wheel: kp 50000")


_POST = f"""<robot name="post"><link name="world"/><link name="pole">{_INERTIAL.format(9)}</link>
<joint name="j" type="fixed"><parent link="world"/><child link="pole"/></joint>{{}}</robot>"""
_ROWS = """<gazebo reference="pole"><sensor name="rows" type="gpu_ray"><ray><scan><horizontal>
<samples>32</samples><min_angle>-1</min_angle><max_angle>1</max_angle></horizontal><vertical>
<samples>4</samples><min_angle>-0.2</min_angle><max_angle>0.2</max_angle></vertical></scan><range>
<min>0.5</min><max>30</max></range><noise><stddev>0.02</stddev></noise></ray></sensor>
<sensor name="deep" type="depth"><camera/></sensor><sensor name="g" type="gps"/>
<sensor name="m" type="magnetometer"/><sensor name="alt" type="altimeter"/>
<sensor name="sonar" type="sonar"/><sensor name="bump" type="contact"/></gazebo>"""


@pytest.mark.usefixtures("without_sills")
def test_what_stands_fast_has_no_drive_and_maybe_no_sensors(tmp_path: Path) -> None:
    bare = _found(tmp_path, "bare.urdf", _POST.format("")).lines[-4:]
    assert bare[0] == "  joints (1): 1 fixed"
    assert bare[1:3] == ("  drive: none, fixed to the world", "  sensors: none")
    assert bare[3] == "  stands with 'world' 0 m above the ground"


@pytest.mark.usefixtures("without_sills")
@pytest.mark.parametrize(("at", "height"), [(2.0, "0"), (-2.0, "2.1")])
def test_what_hangs_from_the_world_hangs_on(tmp_path: Path, at: float, height: str) -> None:
    box = '<link name="box"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>'
    hung = f"""{box}</link><joint name="k" type="fixed"><parent link="world"/><child link="box"/>
<origin xyz="0 0 {at}"/></joint>"""
    line = _found(tmp_path, "hung.urdf", _POST.format(hung)).lines[-1]
    assert line == f"  stands with 'world' {height} m above the ground"


@pytest.mark.usefixtures("without_sills")
def test_every_kind_of_sensor_has_its_name(tmp_path: Path) -> None:
    lines = _found(tmp_path, "post.urdf", _POST.format(_ROWS)).lines
    said = "\n".join(line for line in lines if ": topic " in line or " samples" in line)
    assert said == (
        "  lidar: topic scan, frame pole, 10 Hz, on pole\n"
        "    32 samples, -57.3 to 57.3 deg, 0.5 to 30 m, noise 0.02 m, sees what is drawn\n"
        "  depth camera: topic camera/image_raw, frame pole_optical_frame (pole in the file),"
        " 30 Hz, on pole\n"
        "  lidar of several rows: topic scan/points, frame pole, 10 Hz, on pole\n"
        "    32 x 4 samples, -57.3 to 57.3 deg, 0.5 to 30 m, noise 0.02 m, sees what is drawn\n"
        "  GPS: topic gps/fix, frame pole, 5 Hz, on pole\n"
        "  magnetometer: topic imu/mag, frame pole, 20 Hz, on pole\n"
        "  altimeter: topic altimeter, frame pole, 20 Hz, on pole\n"
        "  range sensor: topic sonar, frame pole, 10 Hz, on pole\n"
        "    9 x 9 samples, -26.6 to 26.6 deg, 0 to 1 m, noise 0 m\n"
        "  contact sensor: topic bump/contacts, frame pole, 50 Hz, on pole"
    )


@pytest.mark.usefixtures("without_sills")
def test_a_drive_of_another_kind_says_which(tmp_path: Path) -> None:
    (tmp_path / "mecanum").mkdir()
    path = cases.car("gz").write(tmp_path)
    car = check(path, SearchPath(), {}).lines
    bends = f"bends of {turning_radius_of(load_robot(path)):.3g} m and wider"
    assert any(bends in line for line in car)
    assert not any("wheel separation" in line for line in car)
    assert any(line.startswith("    by steer") for line in car)
    assert any(line.startswith("    steers by ") and line.endswith(" deg") for line in car)
    rolling = check(cases.mecanum().write(tmp_path / "mecanum"), SearchPath(), {}).lines
    assert any(line.startswith("    by mecanum") for line in rolling)
    assert "    rolls as a radius of 0.06 m" in rolling
    assert not any("steers by" in line for line in rolling)


_WORLD = """<sdf version='1.6'><world name='yard'><model name='a'><static>1</static>
<pose>1 2 0.5 0 0 0</pose><link name='l'>
<collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision>
<collision name='d'><geometry><sphere><radius>1</radius></sphere></geometry></collision>
<collision name='e'><geometry><box><size>1 1 1</size></box></geometry></collision>
<visual name='c'><geometry><box><size>1 1 1</size></box></geometry></visual></link></model>
<model name='sign'><static>1</static><link name='l'><visual name='c'><geometry><box>
<size>1 1 1</size></box></geometry></visual></link></model>
<actor name='bob'><pose>3 3 0 0 0 0</pose></actor></world></sdf>"""


def test_a_world_is_reported_model_by_model(tmp_path: Path) -> None:
    assert _found(tmp_path, "w.world", _WORLD).text().splitlines() == [
        f"{tmp_path / 'w.world'}: loads",
        "world 'yard': 3 models, 1 actors",
        "  a at 1 2 0.5: solid: 2 box, 1 sphere; drawn: 1",
        "  sign at 0 0 0: solid: nothing; drawn: 1",
        "  ground_plane at 0 0 0: solid: 1 plane; drawn: 1",
        "  actor bob",
        "not simulated, or otherwise than the file says (2):",
        "  - actor 'bob': an upright cylinder stands for its skin",
        "  - has no ground plane: one is put at height 0",
    ]
    assert Found(("a", "b"), ()).text() == "a\nb\nall understood"
    noted = Found(("a",), (Note(NoteKind.CHANGED, "so"),)).text()
    assert noted == "a\nnot simulated, or otherwise than the file says (1):\n  - so"


@pytest.mark.usefixtures("without_sills")
def test_only_a_guess_of_two_sides_is_saved(tmp_path: Path) -> None:
    def save(path: Path) -> None:
        check(path, SearchPath(), {}, tmp_path / "guess.xacro")

    with pytest.raises(InputFileError, match="is a world: only of a robot the drive is guessed"):
        save(ROOM)
    post = tmp_path / "post.urdf"
    post.write_text(_POST.format(""), encoding="utf-8")
    with pytest.raises(InputFileError, match="has no wheels, so there is no guess to save"):
        save(post)
    given = tmp_path / "told.urdf"
    given.write_text(_ROBOT.format(plugin=_PLUGIN), encoding="utf-8")
    with pytest.raises(InputFileError, match="has a drive plugin, so there is no guess to save"):
        save(given)
    with pytest.raises(InputFileError, match=r"drives by .*, which is found again"):
        save(cases.car("").write(tmp_path))
