"""Broken and hostile files: each loads, or is refused by an error of ours in a moment."""

from __future__ import annotations

import gc
import re
import resource
import shutil
import struct
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from arjuna_core.errors import ArjunaError, RobotError, WorldError
from arjuna_sim.files.robots.robot_file import load_robot
from arjuna_sim.files.search_path import SearchPath
from arjuna_sim.files.world_file import load_world
from arjuna_sim.model.notes import NoteKind
from arjuna_sim.model.robot import SOLO
from arjuna_sim.physics.scene import build_scene
from arjuna_sim.physics.wheels.servo import ServoConfig
from tests.fuzz.files import MUTATIONS
from tests.sim.builders import EMPTY, ROBOT, ROOM, edited

CORPUS = Path(__file__).parent / "corpus"
NOWHERE = SearchPath()
SECONDS = 2.0
BYTES = 500_000_000


def _load(path: Path) -> str:
    """Load a file as the simulator does; return what of it is left out because it is broken."""
    if path.suffix in (".urdf", ".xacro"):
        robot, world = load_robot(path, NOWHERE), load_world(EMPTY, NOWHERE)
    else:
        robot, world = load_robot(ROBOT, NOWHERE), load_world(path, NOWHERE)
    build_scene({SOLO: robot}, world, ServoConfig(), 0.004)
    return "; ".join(note.text for note in world.notes if note.kind is NoteKind.BROKEN)


def _problem(path: Path) -> str:
    """Return why a file or a piece of it does not load, "" where it does."""
    try:
        return _load(path)
    except ArjunaError as error:
        return str(error)


@pytest.mark.parametrize(
    ("changed", "loaded", "count"),
    [
        ("robot.urdf", "robot.urdf", 75),
        ("world.world", "world.world", 40),
        ("hall.yaml", "hall.yaml", 30),
        ("hall.pgm", "hall.yaml", 20),
        ("cube.stl", "robot.urdf", 20),
        ("wheel.obj", "robot.urdf", 20),
        ("room.dae", "world.world", 20),
        ("macros.xacro", "macros.xacro", 8),
    ],
)
def test_mutated_file_loads_or_is_refused_in_a_moment(
    tmp_path: Path, changed: str, loaded: str, count: int
) -> None:
    rng = np.random.default_rng(20)
    shutil.copytree(CORPUS, tmp_path, dirs_exist_ok=True)
    original, refused = (CORPUS / changed).read_bytes(), 0
    _load(tmp_path / loaded)
    for number in range(count):
        text = original
        for _ in range(rng.integers(1, 3)):
            text = MUTATIONS[rng.integers(len(MUTATIONS))](text or b" ", rng)
        (tmp_path / changed).write_bytes(text)
        start = time.process_time()
        problem = _problem(tmp_path / loaded)
        refused += problem != ""
        assert "\n" not in problem, f"case {number}"
        assert time.process_time() - start < SECONDS, f"case {number}"
    assert refused > 0


XACRO = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{}</robot>'
LAUGHS = "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10 if i else "ha"}">' for i in range(10))
DOUBLING = '<xacro:macro name="m0"><link name="l"/></xacro:macro>' + "".join(
    f'<xacro:macro name="m{i}"><xacro:m{i - 1}/><xacro:m{i - 1}/></xacro:macro>'
    for i in range(1, 40)
)
CHAIN = "".join(
    f'<link name="l{i}"/><joint name="j{i}" type="fixed"><parent link="l{i}"/>'
    f'<child link="l{i + 1}"/></joint>'
    for i in range(1000)
)
MESH = '<robot name="r"><link name="b"><collision><geometry><mesh filename="{}"/></geometry>\
</collision></link></robot>'
MODEL = "<sdf version='1.6'><world name='w'>{}</world></sdf>"
NESTED = "<model name='m'>" * 60 + "</model>" * 60
HOSTILE = {
    "laughs.urdf": (f'<!DOCTYPE r [{LAUGHS}]><robot name="&a9;"/>', "declares a DTD"),
    "laughs.xacro": (f'<!DOCTYPE r [{LAUGHS}]><robot name="&a9;"/>', "declares a DTD"),
    "file.urdf": ('<!DOCTYPE r [<!ENTITY x SYSTEM "file:///etc/passwd">]><robot/>', "DTD"),
    "deep.urdf": ("<robot>" + "<a>" * 100_000, "nested"),
    "many.urdf": ("<robot>" + "<a/>" * 400_000 + "</robot>", "elements"),
    "links.urdf": ("<robot>" + '<link name="l"/>' * 50_000 + "</robot>", "too many parts"),
    "chain.urdf": (f'<robot name="r">{CHAIN}<link name="l1000"/></robot>', "one after the other"),
    "name.urdf": (f'<robot name="{"x" * 1_000_000}"/>', "name of more than"),
    "climb.urdf": (MESH.format("/etc/hostname"), "leads out of"),
    "lie.urdf": (MESH.format("lie.stl"), "cut off"),
    "large.urdf": (MESH.format("large.obj"), "bytes of text"),
    "itself.xacro": (XACRO.format('<xacro:include filename="itself.xacro"/>'), "includes itself"),
    "forever.xacro": (
        XACRO.format('<xacro:macro name="m"><xacro:m/></xacro:macro><xacro:m/>'),
        "without end",
    ),
    "doubling.xacro": (XACRO.format(DOUBLING + "<xacro:m39/>"), "more than 1 s"),
    "memory.xacro": (XACRO.format("<link name=\"${'a' * 10**9}\"/>"), "cannot expand"),
    "power.xacro": (XACRO.format('<link name="${9**9**9}"/>'), "more than 1 s"),
    "escape.xacro": (XACRO.format('<link name="${().__class__}"/>'), "invalid name"),
    "zero.xacro": (XACRO.format('<xacro:include filename="/dev/zero"/>'), "is no file"),
    "yaml.xacro": (XACRO.format("<link name=\"${load_yaml('/etc/passwd')}\"/>"), "leads out"),
    "nested.world": (MODEL.format(NESTED), "nested too deeply"),
    "far.world": (MODEL.format("<model name='m'><pose>1e9 0 0 0 0 0</pose></model>"), "too far"),
    "climb.world": (MODEL.format("<include><uri>model://m/../..</uri></include>"), "leads out"),
    "parts.world": (
        MODEL.format("<model name='m'><link name='l'>" + "<visual/>" * 60_001 + "</link></model>"),
        "too many parts",
    ),
    "frames.world": (
        MODEL.format(
            "".join(f"<frame name='f{i}' attached_to='f{i + 1}'/>" for i in range(5000))
            + "<model name='m'><pose relative_to='f0'>0 0 0 0 0 0</pose></model>"
        ),
        "chain of more than",
    ),
    "wide.yaml": ("image: wide.pgm\nresolution: 0.05\norigin: [0, 0, 0]\n", "no readable PGM"),
}


@pytest.fixture
def half_a_gigabyte() -> Iterator[None]:
    """Let this process, whatever ran in it before, take no more than so much memory."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
    _, hard = limits = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + BYTES, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, limits)


@pytest.mark.usefixtures("half_a_gigabyte")
@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_file_is_refused_or_left_out_in_a_moment(tmp_path: Path, name: str) -> None:
    text, problem = HOSTILE[name]
    (tmp_path / "model.sdf").write_text(MODEL.format(""), encoding="utf-8")
    folder = tmp_path / "a" / "m"
    folder.mkdir(parents=True)
    (folder / "lie.stl").write_bytes(bytes(80) + struct.pack("<I", 10**9) + bytes(500))
    if name == "large.urdf":
        (folder / "large.obj").write_bytes(b"v 0 0 0\n" * 3 + b"f 1 2 3\n" * 3_000_000)
    (folder / "wide.pgm").write_bytes(b"P5 1000000000 1000000000 255 " + bytes(16))
    path = folder / name
    path.write_text(text, encoding="utf-8")
    gc.freeze()  # what other tests left behind is not looked through while this file is read
    before = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) + time.process_time()
    found = _problem(path)
    after = sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2]) + time.process_time()
    assert re.search(problem, found)
    assert "\n" not in found
    assert after - before < SECONDS


def test_models_that_include_ever_more_are_refused(tmp_path: Path) -> None:
    for i in range(8):
        (tmp_path / f"m{i}").mkdir()
        inside = f"<include><uri>model://m{i + 1}</uri></include>" * 10 if i < 7 else ""
        text = f"<sdf version='1.6'><model name='x'>{inside}</model></sdf>"
        (tmp_path / f"m{i}" / "model.sdf").write_text(text, encoding="utf-8")
    start = time.process_time()
    with pytest.raises(WorldError, match="one of too many"):
        load_world(tmp_path / "m0" / "model.sdf")
    assert time.process_time() - start < SECONDS


@pytest.mark.parametrize("value", ["1e9 1 1", "1e308 1 1", "nan 1 1", "-1 1 1", "1 1", "1 1 x"])
def test_size_beyond_reason_is_refused_or_left_out(tmp_path: Path, value: str) -> None:
    world = load_world(edited(ROOM, tmp_path, "10.2 0.2 1.0", value))
    assert re.search("left out: .*<size>", " ".join(note.text for note in world.notes))
    seen = edited(ROBOT, tmp_path, "0.45 0.30 0.10", value)  # the first is the visual
    assert re.search("size: .*left out", " ".join(note.text for note in load_robot(seen).notes))
    with pytest.raises(RobotError, match="size"):
        load_robot(edited(seen, tmp_path, "0.45 0.30 0.10", value))
