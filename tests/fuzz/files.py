"""Every reader of files, with a file to start from, and changes of its bytes at random."""

from __future__ import annotations

import bz2
import gzip
import hashlib
import lzma
import re
import shutil
import time
import traceback
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np
import yaml

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError, InputFileError, MapError, RobotError, WorldError
from arjuna_core.files.map_image import MapOptions
from arjuna_core.files.maps import load_map, save_map
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_nav.docking.dock_types import read_docks
from arjuna_nav.planners.hybrid import lattice
from arjuna_nav.routes.graph import read_graph
from arjuna_nav.trees.blackboard import TreeError
from arjuna_nav.trees.xml_file import read_tree
from arjuna_sim.files.meshes import MeshError, read_skinned
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.sdf.solids import read_heights
from arjuna_sim.files.world_file import load_world
from arjuna_slam.logs.log import open_log
from arjuna_slam.logs.recording import RecordingTopics
from arjuna_slam.mapping.session import SessionFileError, load_session
from arjuna_slam.offline import read_relations
from bringup.campaign.plan import load_campaign
from bringup.client.waypoints import load_waypoints
from bringup.homework.exercise import ExerciseError, load_exercise, sheet
from bringup.lessons.runner import load_page
from bringup.parameters.files import load_parameters
from bringup.parameters.foreign.conversion import converted
from bringup.parameters.foreign.launch_file import LaunchFile
from bringup.ros2.workspace.cmake import read_cmake
from bringup.tuning.plan import Known, known_parameters, load_tuning
from bringup.viewing.drawing import visual_model
from bringup.viewing.drawing.visual_model import VisualError
from bringup.viewing.rviz_file import read_rviz
from tests.core.bags.recordings import (
    ODOMETRY,
    SCAN,
    TF,
    odometry_bytes,
    scan_bytes,
    transform_bytes,
    write,
    write_humble,
    write_ros1,
)
from tests.helpers.nav import lattices, routes

WORDS = (
    *("nan", "inf", "-1", "0", "1e9", "1e308", "-1e-308", "1000000000", "", "../../../etc/passwd"),
    *("__model__", "base", "true", "%s", "1 2", "\N{SNOWMAN}", "package://", "0x10", "--", "]]>"),
)
NUMBER = re.compile(rb"-?\d+(\.\d+)?(e-?\d+)?")
TAG = re.compile(rb"<(\w+)[^<>]*/>|<(\w+)[^<>]*>[^<]*</\2>")


def _flip(text: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(text)
    for index in rng.integers(len(text), size=rng.integers(1, 6)):
        changed[index] = rng.integers(256)
    return bytes(changed)


def _cut(text: bytes, rng: np.random.Generator) -> bytes:
    first, last = np.sort(rng.integers(len(text) + 1, size=2))
    return text[:last] if rng.random() < 0.5 else text[:first] + text[last:]


def _replace(pattern: re.Pattern[bytes], text: bytes, rng: np.random.Generator) -> bytes:
    found = list(pattern.finditer(text))
    if not found:
        return _flip(text, rng)
    hit = found[rng.integers(len(found))]
    if pattern is NUMBER:
        new = WORDS[rng.integers(len(WORDS))].encode()
    else:
        new = b"" if rng.random() < 0.5 else found[rng.integers(len(found))].group() * 2
    return text[: hit.start()] + new + text[hit.end() :]


def _number(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(NUMBER, text, rng)


def _tag(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(TAG, text, rng)


MUTATIONS: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    *(_flip, _cut, _number, _number, _number, _tag, _tag),
)


def mutated(text: bytes, rng: np.random.Generator, most: int = 3) -> bytes:
    """Return a text after a few changes."""
    for _ in range(int(rng.integers(1, most + 1))):
        text = MUTATIONS[int(rng.integers(len(MUTATIONS)))](text or b" ", rng)
    return text


SLOW = 2.0
"""How long a file of some kilobytes may take a core [s]."""
LONGEST = 500
"""How many characters an error may have."""
CORPUS = Path(__file__).parent / "corpus"
_OUTER = """<?xml version="1.0"?>
<launch>
  <arg name="particles" default="80"/>
  <arg name="laser" value="robot/$(arg particles)"/>
  <node pkg="map_server" type="map_server" name="map_server" args="/home/me/map.yaml"/>
  <node pkg="amcl" type="amcl" name="localizer" args="scan:=/laser _kld_err:=0.02">
    <remap from="scan" to="robot/laser/scan"/>
    <param name="max_particles" value="$(arg particles)"/>
    <param name="~kld_err" type="double" value="0.01"/>
    <rosparam>odom_alpha1: 0.2</rosparam>
  </node>
  <include file="$(dirname)/inner.launch"><arg name="speed" value="0.3"/></include>
  <include file="inner.launch" pass_all_args="true"/>
</launch>
"""
_INNER = """<launch>
  <arg name="speed" default="0.9"/>
  <group ns="robot1" unless="false">
    <node pkg="move_base" type="move_base" name="move_base">
      <rosparam file="$(dirname)/common.yaml" command="load" ns="global_costmap"/>
      <rosparam subst_value="true">DWAPlannerROS: {max_vel_x: $(arg speed)}</rosparam>
      <param name="DWAPlannerROS/acc_lim_x" value="1.5" if="$(optenv SLOW 1)"/>
    </node>
  </group>
</launch>
"""
_LAUNCH = """launch:
- arg: {name: world, default: x, description: the world}
- let: {name: speed, value: "0.3"}
- group:
  - push_ros_namespace: {namespace: "$(var world)"}
  - node:
      pkg: demo_nodes_cpp
      exec: talker
      param: [{name: a, value: 1.5}, {name: b, param: [{name: c, value: [1, 2, 3]}]}]
      remap: [{from: chatter, to: /x}]
      env: [{name: A, value: "$(eval '1 + 1')"}]
- include: {file: $(dirname)/inner.launch.xml, arg: [{name: x, value: "1"}]}
- timer: {period: 3.0, children: [{log: {message: late}}]}
"""
_LAUNCH_XML = """<launch>
  <arg name="world" default="x"><choice value="x"/></arg>
  <group if="$(eval '1 == 1')"><push_ros_namespace namespace="robot1"/>
    <node pkg="demo_nodes_cpp" exec="talker" respawn="true" respawn_delay="2.0">
      <param name="b"><param name="c" value="[1, 2, 3]"/></param>
      <param from="$(dirname)/nav2_params.yaml" allow_substs="true"/>
      <remap from="chatter" to="/x"/><env name="A" value="$(env HOME)"/>
    </node>
  </group>
  <include file="$(dirname)/inner.launch.xml"><arg name="x" value="1"/></include>
</launch>
"""
_CMAKE = """project(my_robot)
set(FOLDERS launch params)
file(GLOB MODELS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} "urdf/*.urdf")
foreach(one ${FOLDERS} worlds)
  install(DIRECTORY ${one} DESTINATION share/${PROJECT_NAME} PATTERN "*.bak" EXCLUDE)
endforeach()
install(PROGRAMS scripts/a.py DESTINATION lib/${PROJECT_NAME} RENAME a)
ament_add_pytest_test(unit test/test_a.py TIMEOUT 60 ENV A=1)
"""
_WARNINGS: deque[str] = deque(maxlen=1)
_DOCKS = "docks:\n  home: {type: simple, frame: map, pose: [1.0, 2.0, 0.5], id: a}\n"
_RVIZ = """Visualization Manager:
  Displays:
    - {Class: rviz_default_plugins/LaserScan, Enabled: true, Topic: {Depth: 5, Value: /scan}}
    - Class: rviz_common/Group
      Enabled: true
      Displays:
        - {Class: rviz_default_plugins/Map, Enabled: true, Topic: {Value: /local_costmap/costmap}}
  Global Options: {Fixed Frame: odom}
"""
_RELATIONS = "1.0 2.0 0.1 0.2 0.0 0.0 0.0 0.05\n2.0 3.5 0.1 -0.2 0.0 0.0 0.0 -0.05\n"
_PAGE = "# Title\n\n## Part\n\nwords\n\n```sh\npython -m bringup sim --seed 1\n```\n"
_DRAWN = (
    '<robot name="r"><link name="l"><visual><geometry><mesh filename="{}"/></geometry></visual>'
    "</link></robot>"
)
_DIGEST = hashlib.sha256().digest_size


@dataclass(frozen=True)
class Reader:
    """A reader of one kind of file.

    Attributes:
        name: What it reads.
        read: Reads a file to its end.
        error: The one error that it may raise.
        make: Writes a good file into a folder and returns it; what is changed.
        mend: Makes good what only says that a file was changed, such as a checksum.
    """

    name: str
    read: Callable[[Path], object]
    error: type[ArjunaError]
    make: Callable[[Path], Path]
    mend: Callable[[bytes], bytes] = field(default=lambda data: data)


def _map(folder: Path, image_format: str = "pgm", mode: str = "trinary") -> Path:
    rng = np.random.default_rng(0)
    data = rng.choice(np.array([0, 100], dtype=np.int8), (12, 17))
    grid = OccupancyGrid(GridFrame(0.05, 17, 12, SE2(-1.0, 2.0, 0.1)), data, 0.0)
    return save_map(grid, folder / "room", image_format, MapOptions(mode))[0]


def _image(image_format: str) -> Callable[[Path], Path]:
    return lambda folder: _map(folder, image_format).with_suffix(f".{image_format}")


def _parameters(folder: Path) -> Path:
    path = folder / "nav.yaml"
    lines = shipped_file("params/arjuna_nav.yaml").read_bytes().splitlines(keepends=True)
    last = lines.index(b"planner_server:\n")
    path.write_bytes(b"".join(lines[:last]))
    return path


def _waypoints(folder: Path) -> Path:
    path = folder / "tour.yaml"
    rows = [{"x": 1.0, "y": 2.0, "yaw": 0.5}, [3.0, 4.0, 0.1]]
    path.write_text(yaml.safe_dump({"waypoints": rows}), encoding="utf-8")
    return path


def _carmen(folder: Path) -> Path:
    path = folder / "room.clf"
    beams = " ".join(f"{1.0 + k % 7}" for k in range(180))
    lines = [
        f"FLASER 180 {beams} {t} 0.1 0.2 {t} 0.1 0.2 {t} host {t}\n"
        "ROBOTLASER1 4 -1.57 3.14 0.785 10.0 0.1 0 4 1.0 2.0 3.0 4.0 0 "
        f"{t} 0.1 0.2 {t} 0.1 0.2 0.1 0.1 0.5 0.5 1.0 {t} host {t}\n"
        for t in (1.0, 2.0, 3.0)
    ]
    path.write_text("".join(lines), encoding="ascii")
    return path


def log_entries() -> list[tuple[str, str, float, bytes]]:
    found = []
    for k in range(6):
        stamp, pose = 1.0 + 0.1 * k, SE2(0.1 * k, 0.0)
        scan = Scan(np.full(30, 2.0), -1.0, 0.07, 0.1, 10.0, stamp)
        found.append(("/odom", ODOMETRY, stamp, odometry_bytes(pose, stamp)))
        tree = ("odom", "base_footprint", pose, stamp)
        found.append(("/tf", TF, stamp, transform_bytes(tree)))
        found.append(("/scan", SCAN, stamp, scan_bytes(scan)))
    return found


def _db3(folder: Path) -> Path:
    return next(write_humble(folder / "bag", log_entries()).glob("*.db3"))


def _session(folder: Path) -> Path:
    from arjuna_slam.mapping.session import save_session
    from arjuna_slam.slam import Slam  # compiles the matcher: only where sessions are read

    slam = Slam()
    for k in range(4):
        scan = Scan(np.full(60, 2.0 + 0.1 * k), -3.0, 0.1, 0.1, 10.0, float(k))
        slam.process(scan, SE2(0.6 * k, 0.0))
    session = slam.session()
    assert session is not None
    save_session(folder / "room.posegraph", session)
    return folder / "room.posegraph"


def _signed(data: bytes) -> bytes:
    """Return a session with the checksum that its content has."""
    body = data[:-_DIGEST]
    return body + hashlib.sha256(body).digest()


def _drained(path: Path) -> None:
    deque(open_log(path, RecordingTopics()), maxlen=0)


def _bag(path: Path) -> None:
    deque(Bag(path).messages(), maxlen=0)


def _recorded(folder: Path) -> Path:
    return write(folder / "run.mcap", log_entries())


def _packed_log(suffix: str, pack: Callable[[bytes], bytes]) -> Callable[[Path], Path]:
    def made(folder: Path) -> Path:
        path = folder / f"room.clf{suffix}"
        path.write_bytes(pack(_carmen(folder).read_bytes()))
        return path

    return made


def _mixed(folder: Path) -> Path:
    """Write an mcap file of small packed chunks that overlap in time."""
    entries = log_entries()
    return write(folder / "run.mcap", [*entries[1::2], *entries[::2]], chunk=400)


def _packed_bag(folder: Path) -> Path:
    return next(write_humble(folder / "bag", log_entries(), "MCAP", "FILE").glob("*.zstd"))


def _metadata(folder: Path) -> Path:
    return write_humble(folder / "bag", log_entries()) / "metadata.yaml"


def _text(name: str, content: str) -> Callable[[Path], Path]:
    def made(folder: Path) -> Path:
        path = folder / name
        path.write_text(content, encoding="utf-8")
        return path

    return made


def _shipped(name: str) -> Callable[[Path], Path]:
    return _text(Path(name).name, shipped_file(name).read_text(encoding="utf-8"))


def _from_corpus(name: str) -> Callable[[Path], Path]:
    return lambda folder: Path(shutil.copytree(CORPUS, folder, dirs_exist_ok=True), name)


def _launch(folder: Path) -> Path:
    (folder / "inner.launch").write_text(_INNER, encoding="utf-8")
    (folder / "common.yaml").write_text("{robot_radius: 0.2}", encoding="utf-8")
    return _text("outer.launch", _OUTER)(folder)


def _drawn(path: Path) -> None:
    notes = visual_model.read(_DRAWN.format(path), Path).notes
    if notes:  # which say what is not drawn
        raise VisualError(notes[0])


def _described(path: Path) -> None:
    from launch.launch_description_source import description_of  # which needs ROS's index

    description_of(path).get_launch_arguments()


def _cmake(folder: Path) -> Path:
    (folder / "urdf").mkdir()
    (folder / "urdf" / "a.urdf").write_text("<robot/>", encoding="utf-8")
    return _text("CMakeLists.txt", _CMAKE)(folder)


@cache
def _parameters_now() -> Known:
    return known_parameters([])


READERS = (
    Reader("map YAML", load_map, MapError, _map),
    Reader("map PGM", lambda path: load_map(path.with_suffix(".yaml")), MapError, _image("pgm")),
    Reader("map PNG", lambda path: load_map(path.with_suffix(".yaml")), MapError, _image("png")),
    Reader("parameters", lambda path: load_parameters([path]), InputFileError, _parameters),
    Reader("foreign parameters", converted, InputFileError, _parameters),
    Reader("launch", LaunchFile, InputFileError, _launch),
    Reader("launch YAML", _described, ArjunaError, _text("a.launch.yaml", _LAUNCH)),
    Reader("launch XML", _described, ArjunaError, _text("a.launch.xml", _LAUNCH_XML)),
    Reader("CMake", lambda path: read_cmake(path.parent, "a", "lib"), InputFileError, _cmake),
    Reader(
        "homework",
        lambda path: sheet(load_exercise(str(path))),
        ExerciseError,
        _shipped("homework/waypoints.yaml"),
    ),
    Reader("campaign", load_campaign, InputFileError, _shipped("campaigns/goals.yaml")),
    Reader(
        "tuning",
        lambda path: load_tuning(path, lambda _: _parameters_now()),
        InputFileError,
        _shipped("campaigns/tuning/race_track.yaml"),
    ),
    Reader("waypoints", load_waypoints, InputFileError, _waypoints),
    Reader(
        "docks",
        lambda path: read_docks(path, _WARNINGS.append),
        InputFileError,
        _text("docks.yaml", _DOCKS),
    ),
    Reader("route graph", lambda path: read_graph(path, "map"), InputFileError, routes.written),
    Reader("lattice", lattice.read, InputFileError, lattices.written),
    Reader(
        "tree",
        read_tree,
        TreeError,
        _shipped("behavior_trees/navigate_to_pose_w_replanning_and_recovery.xml"),
    ),
    Reader("RViz", read_rviz, InputFileError, _text("view.rviz", _RVIZ)),
    Reader("relations", read_relations, InputFileError, _text("a.relations", _RELATIONS)),
    Reader("page", load_page, InputFileError, _text("page.md", _PAGE)),
    Reader("CARMEN", _drained, InputFileError, _carmen),
    Reader("CARMEN gz", _drained, InputFileError, _packed_log(".gz", gzip.compress)),
    Reader("CARMEN xz", _drained, InputFileError, _packed_log(".xz", lzma.compress)),
    Reader("CARMEN bz2", _drained, InputFileError, _packed_log(".bz2", bz2.compress)),
    Reader("mcap as log", _drained, InputFileError, _recorded),
    Reader("mcap as bag", _bag, InputFileError, _recorded),
    Reader("mcap that overlaps", _bag, InputFileError, _mixed),
    Reader("mcap packed", _bag, InputFileError, _packed_bag),
    Reader("bag metadata", lambda path: _bag(path.parent), InputFileError, _metadata),
    Reader("db3 as log", _drained, InputFileError, _db3),
    Reader("db3 as bag", _bag, InputFileError, _db3),
    Reader(
        "ROS 1 bag",
        _drained,
        InputFileError,
        lambda folder: write_ros1(folder / "run.bag", log_entries()),
    ),
    Reader("session", load_session, SessionFileError, _session, _signed),
    Reader("URDF", load_robot, RobotError, _from_corpus("robot.urdf")),
    Reader("xacro", load_robot, RobotError, _from_corpus("macros.xacro")),
    Reader("world", load_world, WorldError, _from_corpus("world.world")),
    Reader("map as world", load_world, WorldError, _from_corpus("hall.yaml")),
    Reader("mesh stl", read_skinned, MeshError, _from_corpus("cube.stl")),
    Reader("mesh obj", read_skinned, MeshError, _from_corpus("wheel.obj")),
    Reader("mesh dae", read_skinned, MeshError, _from_corpus("room.dae")),
    Reader("drawn mesh obj", _drawn, VisualError, _from_corpus("wheel.obj")),
    Reader("drawn mesh dae", _drawn, VisualError, _from_corpus("room.dae")),
    Reader("terrain", read_heights, WorldError, _image("png")),
)
"""Every reader of files that a user or a client may name."""


@dataclass(frozen=True)
class Finding:
    """An input that a reader fails on.

    Attributes:
        reader: Its name.
        problem: What it raised, or how long it took.
        data: The input.
    """

    reader: str
    problem: str
    data: bytes


class Fuzzer:
    """Changes one reader's file and has it read, again and again.

    Args:
        reader: The reader.
        folder: Where its file is.
        seed: Of all changes.
    """

    def __init__(self, reader: Reader, folder: Path, seed: int) -> None:
        self.reader = reader
        self._rng = np.random.default_rng(seed)
        self._path = reader.make(folder)
        self._good = self._path.read_bytes()
        reader.read(self._path)

    def once(self) -> Finding | None:
        """Read the file after a few changes; return what was wrong with that."""
        data = self.reader.mend(mutated(self._good, self._rng, 4))
        self._path.write_bytes(data)
        started = time.process_time()
        problem = ""
        try:
            self.reader.read(self._path)
        except self.reader.error as error:
            is_long = "\n" in str(error) or len(str(error)) > LONGEST
            problem = "an error of many lines or letters" if is_long else ""
        except Exception as error:  # noqa: BLE001 - what is looked for
            frame = traceback.extract_tb(error.__traceback__)[-1]
            where = f"{Path(frame.filename).name}:{frame.lineno}"
            problem = f"{type(error).__name__} at {where}: {str(error)[:200]}"
        spent = time.process_time() - started
        if spent > SLOW:
            problem = f"took {spent:.1f} s"
        return Finding(self.reader.name, problem, data) if problem else None
