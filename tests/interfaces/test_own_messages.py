"""A user's own packages of definitions, built as `messages FOLDER` does."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2] / "arjuna_interfaces"


@pytest.fixture
def environment(monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """The module that builds, of this tree."""
    monkeypatch.syspath_prepend(str(ROOT))
    if sys.modules.get("rosidl_generator_py.generate_py_impl", ...) is None:
        for name in [n for n in sys.modules if n.partition(".")[0] == "rosidl_generator_py"]:
            monkeypatch.delitem(sys.modules, name)  # a context in this process holds a part back
    loaded = set(sys.modules)
    import rosidl_build.environment

    yield rosidl_build.environment
    for name in {name for name in sys.modules if name.startswith("rosidl_build")} - loaded:
        del sys.modules[name]


def _write(folder: Path, **texts: str) -> None:
    for name, text in texts.items():
        kind = "srv" if "---" in text else "msg"
        (folder / kind).mkdir(parents=True, exist_ok=True)
        (folder / kind / f"{name}.{kind}").write_text(text)


def test_packages_of_a_workspace_come_by_their_needs(environment: Any, tmp_path: Path) -> None:
    _write(tmp_path / "src" / "a_msgs", Pair="b_msgs/Level first\n")
    _write(tmp_path / "src" / "folder", Level="float32 level\n", Ask="---\nbool ok\n")
    _write(tmp_path / "install" / "b_msgs" / "share", Level="float32 old\n")
    (tmp_path / "src" / "folder" / "package.xml").write_text(
        "<package><name>b_msgs</name></package>"
    )
    packages = environment.packages_below(tmp_path)
    assert [package.name for package in packages] == ["b_msgs", "a_msgs"]
    assert [str(file) for file in packages[0].files] == ["msg/Level.msg", "srv/Ask.srv"]


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("", "no msg/NAME.msg"),
        ("My-Msgs", "'My-Msgs' is no name"),
        ("std_msgs", "of the environment"),
    ],
)
def test_what_cannot_be_built_is_refused(
    environment: Any, tmp_path: Path, name: str, message: str
) -> None:
    if name:
        _write(tmp_path / name, Level="float32 level\n")
    with pytest.raises(ValueError, match=message):
        environment.build(tmp_path)


@pytest.mark.ros
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("uint8 MOST=999", "msg/Level.msg: value '999' can not be converted"),
        ("float64 Level", "msg/Level.msg: 'Level' is an invalid field name"),
        ('float64 level # """ \\', "msg/Level.msg: UnicodeDecodeError processing"),
        ("geometry_msgs/Pse at", "there is no type 'Pse'"),
    ],
)
def test_a_definition_that_is_wrong_is_refused_by_its_name(
    tmp_path: Path, text: str, expected: str
) -> None:
    _write(tmp_path / "tank_msgs", Level=f"{text}\n")
    done = _built(tmp_path, tmp_path / "env")
    assert f"ValueError: {tmp_path}/tank_msgs" in done.stderr
    assert expected in done.stderr


def _built(*folders: Path) -> subprocess.CompletedProcess[str]:
    """Build the packages of a folder into a prefix: it forks, which threads do not survive."""
    build = (
        f"import sys; from pathlib import Path; sys.path.insert(0, {str(ROOT)!r})\n"
        "from rosidl_build.environment import build\n"
        "print(build(*map(Path, sys.argv[1:])))"
    )
    command = [sys.executable, "-c", build, *map(str, folders)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)


@pytest.mark.ros
def test_a_package_is_built_and_its_messages_are_sent_as_bytes(tmp_path: Path) -> None:
    text = "builtin_interfaces/Time stamp\nfloat32[] levels\n"
    _write(tmp_path / "src" / "tank_msgs", Level=text)
    done = _built(tmp_path / "src", tmp_path / "env")
    assert done.stdout == "['tank_msgs']\n", done.stderr
    script = (
        "from rclpy.serialization import deserialize_message, serialize_message as s\n"
        "from tank_msgs.msg import Level\n"
        "print(deserialize_message(s(Level(levels=[0.5, 2.0])), Level).levels.tolist())"
    )
    path = str(tmp_path / "env" / "site-packages")
    command = [sys.executable, "-c", f"import sys; sys.path.insert(0, {path!r})\n{script}"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.stdout == "[0.5, 2.0]\n", done.stderr
    share = tmp_path / "env" / "share"
    assert (share / "tank_msgs" / "msg" / "Level.msg").read_text() == text
    index = share / "ament_index" / "resource_index" / "rosidl_interfaces"
    assert [path.name for path in index.iterdir()] == ["tank_msgs"]
