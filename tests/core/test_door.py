"""Claims: files are opened for reading by one function, `open_file`, and nowhere else."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("arjuna", "arjuna_core", "arjuna_sim", "arjuna_slam", "arjuna_nav", "bringup")
FOLDERS = (*PACKAGES, "ros_packages")
DOOR = "arjuna_core/files/input_file.py"
MODULES = {
    "bz2", "configparser", "fileinput", "gzip", "io", "linecache", "lzma", "mmap", "os", "pickle",
    "runpy", "shelve", "shutil", "sqlite3", "tarfile", "tokenize", "tomllib", "zipfile",
    "ElementTree", "Image", "MjModel", "MjSpec", "np", "pd", "pq", "trimesh", "xacro", "yourdfpy",
}  # fmt: skip
"""Modules and classes that open files by name."""
OPENERS = {
    "open", "open_code", "FileIO", "copy", "copy2", "copyfile", "copytree", "fromfile",
    "from_file", "from_xml_path", "genfromtxt", "getline", "getlines", "input", "iterparse",
    "load_mesh", "load_path", "load_scene", "loadtxt", "memmap", "mmap", "parse", "read_csv",
    "read_parquet", "read_table", "run_path", "connect", "TarFile", "ZipFile",
}  # fmt: skip
"""Their functions that do so."""
METHODS = {"open", "read_text", "read_bytes"}
"""Those of a path."""
NAMES = {"open", "AnyReader", "JournalFileBackend"}
"""Names that open files without a module before them."""
ANY = re.compile(rf"\b({'|'.join(OPENERS | METHODS | NAMES)})\b")
KNOWN = {
    # A file object or bytes that the door gave.
    "arjuna_core/files/map_image.py: Image.open": "of an open file",
    "arjuna_sim/files/sdf/solids.py: Image.open": "of an open file",
    "arjuna_sim/files/pictures.py: Image.open": "of an open file",
    "bringup/viewing/displays/panels.py: Pillow.open": "of bytes",
    "arjuna_sim/files/meshes.py: trimesh.load_scene": "of bytes",
    "arjuna_slam/offline.py: np.loadtxt": "of text",
    "arjuna_slam/mapping/session.py: zipfile.ZipFile": "of bytes",
    "bringup/viewing/drawing/visual_model.py: trimesh.load_scene": "of an open file",
    "arjuna_core/bags/mcap_file.py: frame.open": "of bytes",
    "arjuna_core/bags/ros1_file.py: frame.open": "of bytes",
    # Libraries that open what the door has opened before.
    "arjuna_core/bags/ros1_file.py: super().open": "calls `_Source.open`",
    "arjuna_core/bags/ros1_file.py: path.open": "is `_Source.open`",
    "arjuna_core/bags/sqlite_file.py: sqlite3.connect": "checked in `_open`; a new file of our own",
    "ros_packages/rosbag2_py/reader.py: self.open": "is `SequentialReader.open`",
    "ros_packages/rosbag2_py/reader.py: reader.open": "is `SequentialReader.open`",
    "ros_packages/cv_bridge/core.py: Picture.open": "of bytes",
    "bringup/tuning/study.py: JournalFileBackend": "checked before",
    "bringup/homework/student.py: runpy.run_path": "runs a submission, in its sandbox",
    "bringup/ros2/programs/python_file.py: runpy.run_path": "runs what the user names as a program",
    "bringup/ros2/workspace/colcon.py: shutil.copy2": "installs what the user's package names",
    "bringup/ros2/workspace/colcon.py: shutil.copytree": "installs what the user's package names",
    "ros_packages/launch/launch_description_source.py: runpy.run_path": "as `python_file.py`",
    "arjuna_sim/files/urdf/xacro_child.py: xacro.open": "takes the place of xacro's own",
    # Folders, for their names to be forced to disk.
    "arjuna_core/files/whole_file.py: os.open": "a folder",
    "arjuna_sim/processing/joystick.py: os.open": "a gamepad",
    "bringup/ros2/main.py: os.open": "/dev/null",
    # The kernel's files.
    "bringup/doctor/machine.py: .read_text": "/proc",
    "bringup/doctor/machine.py: .read_bytes": "/proc",
    "bringup/homework/program.py: .read_text": "/proc",
    "bringup/homework/sandbox.py: os.open": "/proc, and paths whose files are not read",
    "bringup/processes/fork.py: .read_text": "/proc",
    "bringup/processes/health.py: .read_text": "/proc",
    "bringup/ros2/discovery.py: _TABLE.read_text": "/proc",
    "ros_packages/nav2_simple_commander/utils.py: .read_bytes": "/proc",
    "arjuna_core/ros/shared_memory.py: lock.open": "locks of /dev/shm, which are not read",
    "arjuna_core/ros/shared_memory.py: port.open": "a word of what lies in /dev/shm",
    # What is installed with us.
    "arjuna_core/files/array_cache.py: .read_bytes": "our own modules",
    "arjuna_core/shipped_kernels.py: cpus.open": "/proc/cpuinfo",
    "arjuna_core/shipped_kernels.py: shutil.copytree": "our own kernels",
    "bringup/commands/__init__.py: path.open": "the commands' own files",
    "bringup/recording/message_definitions.py: .read_text": "definitions of installed messages",
    "bringup/ros2/types.py: .read_text": "definitions of installed messages",
}
"""What opens files all the same, or opens no file, each with its reason."""


def openers(source: str) -> Iterator[str]:
    """Yield what in a source opens files for reading."""
    if not ANY.search(source):
        return
    tree = ast.parse(source)
    calls = {call.func: call for call in ast.walk(tree) if isinstance(call, ast.Call)}
    for node in ast.walk(tree):
        if node in calls and written(calls[node]):
            continue
        if isinstance(node, ast.Name) and node.id in NAMES and isinstance(node.ctx, ast.Load):
            yield node.id
        elif isinstance(node, ast.Attribute) and node.attr in METHODS | OPENERS:
            owner = ast.unparse(node.value).rpartition(".")[2]
            is_path = node.attr in METHODS and (node in calls or owner == "Path")
            if is_path or (owner in MODULES and node.attr in OPENERS):
                yield f"{owner if owner.isidentifier() or 'super' in owner else ''}.{node.attr}"
        elif isinstance(node, ast.ImportFrom) and node.module in MODULES:
            yield from (f"{node.module}.{n.name}" for n in node.names if n.name in OPENERS)


def written(call: ast.Call) -> bool:
    """Return whether a call opens a file to write it."""
    first = isinstance(call.func, ast.Name)  # open(path, mode), or path.open(mode)
    modes = [*call.args[int(first) : int(first) + 1], *(k.value for k in call.keywords)]
    texts = [mode.value for mode in modes if isinstance(mode, ast.Constant)]
    return any(isinstance(text, str) and text.strip("bt+") in ("w", "x", "a") for text in texts)


def test_files_are_opened_by_the_one_door() -> None:
    found = {
        f"{path.relative_to(ROOT)}: {what}"
        for folder in FOLDERS
        for path in (ROOT / folder).rglob("*.py")
        if str(path.relative_to(ROOT)) != DOOR
        for what in openers(path.read_text(encoding="utf-8"))
    }
    assert sorted(found - KNOWN.keys()) == []
    assert sorted(KNOWN.keys() - found) == [], "the list names what is no longer there"


def test_every_kind_of_opening_is_found() -> None:
    sources = (
        "open(p)", "open(p, 'rb')", "Path(p).open()", "p.open('r')", "p.read_text()",
        "gzip.open(p)", "lzma.open", "sqlite3.connect(p)", "np.loadtxt(p)",
        "PIL.Image.open(p)", "os.open(p, 0)", "zipfile.ZipFile(p)", "ElementTree.parse(p)",
        "from gzip import open", "map(open, p)",
        "Path.read_bytes(p)", "shutil.copyfile(p, q)", "mujoco.MjModel.from_xml_path(p)",
    )  # fmt: skip
    assert [source for source in sources if not list(openers(source))] == []
    assert not list(openers("open(p, 'w')\np.open('xb')\nopen_file(p)\nnp.array(p)"))
