"""Packages of one's own: created, built, sourced, run; what cannot be built is named."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import Mock

import pytest
from rosidl_build import environment, generate

from bringup.ros2.main import main as ros2
from bringup.ros2.workspace.catkin import catkin_create_pkg
from bringup.ros2.workspace.colcon import main as colcon

pytestmark = pytest.mark.ros
_SPEED = "<launch><arg name='speed'/></launch>"
_SAY = "#!/bin/sh\necho said\n"
_INTERFACES = 'rosidl_generate_interfaces(${PROJECT_NAME}\n  "msg/Num.msg")\n'
MANIFEST = """<package format="3"><name>{0}</name>{1}
<export><build_type>{2}</build_type></export></package>"""


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "src").mkdir()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / ".cache"))
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    return tmp_path / "src"


def _write(folder: Path, files: dict[str, str]) -> None:
    """Write files below a folder, those that begin with `#!` as programs."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755 if text.startswith("#!") else 0o644)


def _create(source: Path, name: str, *words: str) -> Path:
    assert ros2(["pkg", "create", name, "--destination-directory", str(source), *words]) == 0
    return source / name


def _sourced(command: str, shell: str = "bash") -> str:
    """Return what a command prints in a shell that has sourced the workspace."""
    environment = {"PATH": "/usr/bin:/bin", "HOME": os.environ["HOME"]}
    environment["XDG_CACHE_HOME"] = os.environ["XDG_CACHE_HOME"]
    words = [shell, "-c", f". install/setup.{shell} && {command}"]
    done = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def _manifest(source: Path, name: str, kind: str = "ament_python", depends: str = "") -> Path:
    needs = "".join(f"<depend>{one}</depend>" for one in depends.split())
    _write(source, {f"{name}/package.xml": MANIFEST.format(name, needs, kind)})
    return source / name


def test_packages_are_created_and_run(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--build-type", "ament_python", "--node-name", "hello", "--license", "MIT"]
    _create(source, "my_robot", *words, "--dependencies", "rclpy", "std_msgs")
    assert colcon(["build", "--symlink-install", "--cmake-args", "-DX=1"]) == 0
    assert "Starting >>> my_robot\nFinished <<< my_robot [" in capsys.readouterr().out
    assert _sourced("ros2 run my_robot hello") == "Hi from my_robot.\n"
    assert _sourced("ros2 pkg xml my_robot -t depend", "sh") == "rclpy\nstd_msgs\n"
    printed = _sourced("ros2 pkg prefix my_robot; ros2 pkg executables my_robot; ros2 pkg list")
    assert printed.startswith(f"{source.parent}/install/my_robot\nmy_robot hello\n")
    assert {"my_robot", "slam_toolbox", "gazebo_ros", "rclpy"} <= set(printed.split())


@pytest.mark.parametrize("linked", [True, False])
def test_only_a_linked_package_follows_its_source(source: Path, linked: bool) -> None:
    folder = _create(source, "my_robot", "--node-name", "hello")
    setup = (folder / "setup.py").read_text()
    data = "('share/my_robot/launch', ['launch/a.launch.xml']),\n        ('share/' + package_name,"
    setup = setup.replace("('share/' + package_name,", data)
    _write(folder, {"launch/a.launch.xml": "<launch/>", "setup.py": setup})
    assert colcon(["build", *(["--symlink-install"] if linked else [])]) == 0
    hello, launch = "def main():\n    print('new')\n", "<launch>\n</launch>"
    _write(folder, {"my_robot/hello.py": hello, "launch/a.launch.xml": launch})
    assert _sourced("ros2 run my_robot hello") == ("new\n" if linked else "Hi from my_robot.\n")
    installed = source.parent / "install/my_robot/share/my_robot/launch/a.launch.xml"
    assert installed.read_text() == ("<launch>\n</launch>" if linked else "<launch/>")


def test_a_package_of_launch_files_is_created(source: Path) -> None:
    folder = _create(source, "my_bot", "--build-type", "ament_cmake", "--dependencies", "xacro")
    text = (folder / "CMakeLists.txt").read_text()
    assert "find_package(xacro REQUIRED)\n" in text
    line = "install(DIRECTORY launch DESTINATION share/${PROJECT_NAME})\nament_package()"
    text = text.replace("ament_package()", line)
    _write(folder, {"launch/a.launch.xml": _SPEED, "CMakeLists.txt": text})
    assert colcon(["build"]) == 0
    assert "'speed':" in _sourced("ros2 launch my_bot a.launch.xml --show-args")
    assert _sourced("ros2 pkg xml my_bot -t depend") == "xacro\n"


def test_the_guide_s_shortest_setup_py_will_do(source: Path) -> None:
    folder = _create(source, "my_robot")
    (folder / "my_robot" / "minimal_node.py").write_text("def main():\n    print('alive')\n")
    (folder / "setup.py").write_text(
        "from setuptools import setup\nsetup(name='my_robot', version='0.0.1',"
        " packages=['my_robot'], entry_points={'console_scripts':"
        " ['minimal_node = my_robot.minimal_node:main']})"
    )
    assert colcon(["build"]) == 0
    assert _sourced("ros2 run my_robot minimal_node") == "alive\n"


def test_packages_are_built_in_order(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, depends in (("a", "b"), ("b", "c"), ("c", ""), ("d", "")):
        _manifest(source, name, depends=depends)
    (_manifest(source, "ignored") / "COLCON_IGNORE").touch()
    assert colcon(["list"]) == 0
    names = [line.split("\t")[0] for line in capsys.readouterr().out.splitlines()]
    assert sorted(names) == ["a", "b", "c", "d"]
    assert names.index("c") < names.index("b") < names.index("a")
    assert colcon(["list", "--packages-up-to", "b", "--packages-skip", "d"]) == 0
    assert [line[0] for line in capsys.readouterr().out.splitlines()] == ["c", "b"]
    assert colcon(["list", "--packages-select", "bb"]) == 1
    assert "there is no package 'bb'; did you mean 'b'?" in capsys.readouterr().err


@pytest.mark.parametrize(("linked", "interfaces"), [(True, ""), (False, ""), (True, _INTERFACES)])
def test_a_package_of_data_is_built_from_its_cmake_file(
    source: Path, linked: bool, interfaces: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[Path] = []
    monkeypatch.setattr(environment, "build", built.append)
    monkeypatch.setattr(generate, "find_prefix", lambda: source.parent / "environment")
    definition = "share/my_description/msg/Num.msg"
    _write(source.parent / "environment", {definition: "int64 num\n"})
    folder = _manifest(source, "my_description", "ament_cmake")
    cmake = (
        "project(my_description)\nfind_package(ament_cmake REQUIRED)  # as ever\n"
        f"{interfaces}"
        "install(DIRECTORY urdf launch\n  DESTINATION share/${PROJECT_NAME}/)\n"
        "install(PROGRAMS scripts/say DESTINATION lib/${PROJECT_NAME})\nament_package()\n"
    )
    files = {"urdf/robot.urdf": "<robot/>", "launch/a.launch.xml": _SPEED}
    _write(folder, {**files, "CMakeLists.txt": cmake})
    (folder / "scripts").mkdir()
    (folder / "scripts" / "say").write_text(_SAY)  # no program yet
    assert colcon(["build", *(["--symlink-install"] if linked else [])]) == 0
    share = Path(_sourced("ros2 pkg prefix --share my_description").strip())
    assert "'speed':" in _sourced("ros2 launch my_description a.launch.xml --show-args")
    assert (share / "urdf" / "robot.urdf").read_text() == "<robot/>"
    assert _sourced("ros2 run my_description say") == "said\n"
    assert len(built) == bool(interfaces)
    if interfaces:
        assert _sourced("ros2 interface show my_description/msg/Num") == "int64 num\n"


def test_a_package_s_environment_hooks_are_sourced(source: Path) -> None:
    folder = _manifest(source, "my_worlds", "ament_cmake")
    models = "@CMAKE_INSTALL_PREFIX@/share/@PROJECT_NAME@/models"
    hooks = {
        "hooks/one.dsv.in": f"prepend-non-duplicate;GZ_SIM_RESOURCE_PATH;{models}\n",
        "hooks/two.sh": 'ament_prepend_unique_value OWN_PATH "$AMENT_CURRENT_PREFIX/share"\n',
    }
    named = "".join(f'ament_environment_hooks("${{PROJECT_SOURCE_DIR}}/{n}")\n' for n in hooks)
    _write(folder, {**hooks, "CMakeLists.txt": f"project(my_worlds)\n{named}ament_package()\n"})
    assert colcon(["build"]) == 0
    prefix = _sourced("ros2 pkg prefix my_worlds").strip()
    models, own = _sourced('echo "$GZ_SIM_RESOURCE_PATH" "$OWN_PATH"').split()
    assert models.split(":")[0] == f"{prefix}/share/my_worlds/models"
    assert own == f"{prefix}/share"


def test_a_package_of_ros_1_is_linked(source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(source)
    monkeypatch.setattr(sys, "argv", ["catkin_create_pkg", "udacity_bot", "rospy"])
    with pytest.raises(SystemExit, match="0"):
        catkin_create_pkg()
    monkeypatch.chdir(source.parent)
    _write(source / "udacity_bot", {"launch/world.launch": "<launch/>", "say.sh": _SAY})
    assert colcon(["build", "--base-paths", "src"]) == 0
    printed = _sourced("cat $(ros2 pkg prefix --share udacity_bot)/launch/world.launch")
    assert printed == "<launch/>"
    assert _sourced("ros2 run udacity_bot say.sh") == "said\n"
    monkeypatch.setattr(sys, "argv", ["catkin_create_pkg", "src"])
    with pytest.raises(SystemExit, match="'src' is no new name"):
        catkin_create_pkg()


def test_broken_packages_are_named_alone(source: Path, capsys: pytest.CaptureFixture[str]) -> None:
    compiled = _manifest(source, "compiled", "ament_cmake")
    (compiled / "say").write_text(_SAY)  # no program yet
    (compiled / "CMakeLists.txt").write_text(
        "add_executable(node src/node.cpp)\ninstall(FILES no.xml DESTINATION share/compiled)\n"
        "install(PROGRAMS say DESTINATION lib/${PROJECT_NAME})\n"
    )
    broken = _create(source, "broken")
    (broken / "setup.py").write_text("from setuptools import setup\nsetup(name='broken'\n")
    _manifest(source, "bare")
    _create(source, "good")
    assert colcon(["build"]) == 1
    given = capsys.readouterr()
    assert "compiled: node is C++, not built; ROS's own tools build it" in given.err
    assert "install() of compiled: there is no " in given.err
    assert "setup.py of broken failed" in given.err
    assert "SyntaxError" in given.err
    assert "bare has no setup.py; 'ros2 pkg create' writes one" in given.err
    assert "Summary: 1 package finished" in given.out
    assert "  3 packages failed: " in given.out
    assert "good" in _sourced("ros2 pkg list").split()
    assert _sourced("ros2 run compiled say") == "said\n"


@pytest.mark.parametrize(
    ("depends", "problem"),
    [(("b", "a"), "packages need each other: "), (("", ""), "two packages are called 'a'")],
)
def test_a_workspace_that_makes_no_sense_is_refused(
    depends: tuple[str, str],
    problem: str,
    source: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    _manifest(source, "a", depends=depends[0])
    folder = _manifest(source, "b", depends=depends[1])
    if not depends[0]:
        (folder / "package.xml").write_text(MANIFEST.format("a", "", "ament_python"))
    assert colcon(["build"]) == 1
    assert problem in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (["pkg", "create", "My-Robot"], "'My-Robot' is no name of a package"),
        (["pkg", "create", "src"], "The directory already exists"),
        (
            ["pkg", "create", "--build-type", "ament_cmake", "--node-name", "drive", "a"],
            "'drive' would be C++, which is not built here; --build-type ament_python",
        ),
        (["run", "my_robot", "hello"], "'source install/setup.bash' of its workspace first"),
        (["run", "cartographer_ros", "x"], "online_async_launch.py' maps"),
    ],
)
def test_a_mistake_is_named_with_its_remedy(
    words: list[str], problem: str, source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ros2(words) == 1
    assert problem in capsys.readouterr().err


def test_a_script_of_ros_1_is_named(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    _write(source, {"lib/first_pkg/old.py": "#!/usr/bin/env python3\nimport rospy\n"})
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(source))
    assert ros2(["run", "first_pkg", "old.py"]) == 1
    assert "is of ROS 1 (it imports rospy); docs/coming-from-ros1.md" in capsys.readouterr().err


def test_a_packages_own_executable_is_first(source: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program = source / "lib" / "tf2_ros" / "tf2_echo"
    _write(source, {"lib/tf2_ros/tf2_echo": "#!/bin/sh\n"})
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(source))
    execv = Mock(side_effect=KeyboardInterrupt)
    monkeypatch.setattr(os, "execv", execv)
    assert ros2(["run", "tf2_ros", "tf2_echo", "a"]) == 0
    assert execv.call_args.args[1] == [str(program), "a"]


def test_the_build_runs_as_a_program(source: Path) -> None:
    program = Path(sys.executable).parent / "colcon"
    if not program.exists():
        pytest.skip("installed without its commands; 'make setup' brings them")
    done = subprocess.run([program, "list"], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "")


_TESTED = """project(tested)
if(BUILD_TESTING)
  set(WHERE ${CMAKE_CURRENT_SOURCE_DIR}/test)
  ament_add_pytest_test(unit test/test_unit.py TIMEOUT 60)
  ament_add_test(program GENERATE_RESULT_FOR_RETURN_CODE_ZERO COMMAND "${WHERE}/program.py"
    TIMEOUT 30 ENV WORD=said)
  add_launch_test(test/test_launch.py TIMEOUT 60 ARGS "word:=launched")
  ament_add_gtest(compiled test/test.cpp)
endif()
"""
_LAUNCHED = """import unittest, launch, launch_testing.actions

def generate_test_description():
    return launch.LaunchDescription([launch_testing.actions.ReadyToTest()])

class TestArguments(unittest.TestCase):
    def test_word(self, test_args):
        self.assertEqual(test_args, {"word": "launched"})
"""


def test_tests_are_run_and_their_results_listed(
    source: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    files = {
        "own/setup.py": "from setuptools import setup\nsetup(name='own', packages=['own'])",
        "own/own/__init__.py": "NUMBER = 3",
        "own/test/test_number.py": "import own\ndef test_number():\n    assert own.NUMBER == 4\n",
        "own/test/test_flake8.py": "from ament_flake8.main import main_with_errors\n",
        "tested/CMakeLists.txt": _TESTED,
        "tested/test/test_unit.py": "def test_one():\n    pass\n",
        "tested/test/program.py": "import os\nraise SystemExit(os.environ['WORD'] != 'said')",
        "tested/test/test_launch.py": _LAUNCHED,
    }
    for name, kind in (("own", "ament_python"), ("tested", "ament_cmake")):
        _manifest(source, name, kind)
    _write(source, files)
    assert colcon(["build"]) == 0
    assert colcon(["test", "--event-handlers", "console_direct+"]) == 0
    said = capfd.readouterr().out
    assert "own: test_flake8.py is left out, for ament_flake8 is not installed" in said
    assert "tested: test 'compiled' is C++, and is not run" in said
    assert "1 package had test failures: own" in said
    Path("build/own/odd.xml").write_text("<testsuite tests='many'/>")  # of no test's own
    assert colcon(["test-result", "--verbose"]) == 1
    listed = capfd.readouterr().out
    assert "build/own/pytest.xml: 1 test, 0 errors, 1 failure, 0 skipped" in listed
    assert "assert 3 == 4" in listed
    assert "Summary: 3 tests, 0 errors, 1 failure, 0 skipped" in listed
    failing = ["test", "--return-code-on-test-failure", "--packages-select"]
    assert colcon([*failing, "own"]) == 1
    (source / "tested/test/program.py").write_text("raise SystemExit(3)")
    assert colcon([*failing, "tested"]) == 1
    assert "1 package had test failures: tested" in capfd.readouterr().out


def test_programs_find_the_packages_that_pkg_prefix_finds(
    source: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """By `ros2 run` of a package or a file, and as Python runs a file in a sourced workspace."""
    folder = _create(source, "my_robot", "--node-name", "hello")
    text = (
        "from ament_index_python.packages import get_package_share_directory\n"
        "def main():\n"
        "    for name in ('my_robot', 'nav2_bringup', 'nav_msgs'):\n"
        "        print(get_package_share_directory(name))\n"
    )
    _write(folder, {"my_robot/hello.py": text})
    _write(source.parent, {"hello.py": f"{text}main()\n"})
    assert colcon(["build"]) == 0
    installed = _sourced("ros2 run my_robot hello")
    assert installed.splitlines()[0] == f"{source.parent}/install/my_robot/share/my_robot"
    assert "/share/nav2_bringup\n" in installed
    assert _sourced("python hello.py") == installed
    (source.parent / "hello.py").write_text(text.replace("my_robot", "rclpy"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", "")
    capsys.readouterr()
    assert ros2(["run", "hello.py"]) == 0
    assert "/share/nav2_bringup\n" in capsys.readouterr().out
