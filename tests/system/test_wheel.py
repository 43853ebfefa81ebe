"""The wheel, installed and used from an empty folder, has all it needs with it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = [pytest.mark.ros, pytest.mark.system]
ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav", "bringup")
DATA = (
    "urdf",
    "worlds",
    "maps",
    "params",
    "guides",
    "docs/tutorial",
    "behavior_trees",
    "campaigns",
)
DEADLINE = 120.0
CPU = Path("/proc/cpuinfo").read_text()
CHECK = """
import sys
from bringup.cli import run
from bringup.cli import parse
for path in sys.argv[1:]:
    run(parse(["sim", "--check", path]))
"""
RUN_FOR_A_SECOND = """
from bringup.lockstep import LockStep
from bringup.parameters.files import shipped_parameters
from bringup.stack import SIM_GROUP

robot = LockStep(shipped_parameters())
robot.start(SIM_GROUP)
robot.run(1.0)
assert robot.process.transforms.try_lookup("odom", "lidar_link") is not None
robot.close()
"""
_PLAIN = {"NUMBA_DISABLE_JIT": "1"}
"""Runs what is not compiled yet as Python: that is shorter than to compile it for a second."""
LISTED = ["arjuna_core.sweep", "rays_of_sweep", ["int64", *["float64"] * 5, "float64[1C]"]]
LOADS_WHAT_IS_LISTED = """
from numba import types as t
from arjuna_core.sweep import rays_of_sweep
rays_of_sweep.compile((t.int64, *[t.float64] * 5, t.float64[::1]))
assert not rays_of_sweep.stats.cache_misses, "it was compiled again"
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from a copy, since a build leaves its folders behind."""
    folder = tmp_path_factory.mktemp("wheel")
    source = folder / "source"
    for name in (*PACKAGES, *DATA):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in DATA:  # as a checkout has them once its scripts have run
        for folder_of_scripts in {path.parent for path in (source / name).rglob("*.py")}:
            (folder_of_scripts / "__pycache__").mkdir()
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, source)
    (source / "scripts").mkdir()
    for path in (ROOT / "scripts").glob("kernels*.py"):
        shutil.copy(path, source / "scripts")
    (source / "scripts" / "kernels.json").write_text(json.dumps([LISTED]))
    _run(sys.executable, "-m", "scripts.kernels", "ship", cwd=source)  # one, for it takes minutes
    options = ("--no-deps", "--no-build-isolation", "--no-index", "--quiet")
    _run(sys.executable, "-m", "pip", "wheel", *options, "-w", folder, source, cwd=folder)
    return next(folder.glob("*.whl"))


@pytest.fixture(scope="module")
def python(wheel: Path) -> Path:
    """An environment with the wheel, that sees this one's packages but not this checkout."""
    folder = wheel.parent / "environment"
    venv.create(folder)
    python = folder / "bin" / "python"
    install = ("--python", python, "install", "--no-deps", "--no-index", "--quiet")
    _run(sys.executable, "-m", "pip", *install, wheel, cwd=folder)
    # A path file within a folder that a path file names is not read: so no editable install
    others = {sysconfig.get_path("purelib"), sysconfig.get_path("platlib")}
    (packages,) = folder.glob("lib/python*/site-packages")
    (packages / "others.pth").write_text("\n".join(others), encoding="utf-8")
    return python


def _run(*words: str | Path, cwd: Path, **more: str) -> str:
    environment = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    environment |= {"AMENT_PREFIX_PATH": sys.prefix, **more}
    done = subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=DEADLINE,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_every_file_of_the_data_folders_is_in_the_wheel(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        packed = {name.partition("/data/share/arjuna/")[2] for name in archive.namelist()}
    files = (path for name in DATA for path in (ROOT / name).rglob("*") if path.is_file())
    shipped = (path for path in files if path.parent.name != "__pycache__")
    assert {str(path.relative_to(ROOT)) for path in shipped} == packed - {""}


def test_installed_robots_worlds_and_maps_are_understood(python: Path, tmp_path: Path) -> None:
    share = python.parents[1] / "share" / "arjuna"
    names = ("urdf/arjuna.urdf", "worlds/arjuna_room.world", "maps/arjuna_room.yaml")
    report = _run(python, "-c", CHECK, *(share / name for name in names), cwd=tmp_path, **_PLAIN)
    assert report.count(" loads") == len(names)


@pytest.mark.skipif(" avx2 " not in CPU, reason="another level of CPU compiles for itself")
def test_installed_kernels_are_not_compiled_again(python: Path, tmp_path: Path) -> None:
    _run(python, "-c", LOADS_WHAT_IS_LISTED, cwd=tmp_path)


def test_numba_is_the_one_that_compiles_them() -> None:
    lock = (ROOT / "requirements.lock").read_text()
    locked = re.findall(r"^numba==(\S+) ; python_version >= '3.11'", lock, re.MULTILINE)
    assert f"numba=={locked[0]} ; python_version >= '3.11'" in (ROOT / "pyproject.toml").read_text()


def test_installed_robot_runs_from_an_empty_folder(python: Path, tmp_path: Path) -> None:
    location = _run(python, "-c", "import bringup; print(bringup.__file__)", cwd=tmp_path)
    assert Path(location.strip()).is_relative_to(python.parents[1])
    _run(python, "-c", RUN_FOR_A_SECOND, cwd=tmp_path, **_PLAIN)
    assert not list(tmp_path.iterdir())
