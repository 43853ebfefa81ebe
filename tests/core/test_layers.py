"""Claims: packages and wings import each other, ROS and heavy libraries only as designed."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from tests.helpers.files import write_all
from tests.helpers.imports import Import, circles, file_graph, imports

ROOT = Path(__file__).resolve().parents[2]
CORES = ("arjuna_sim", "arjuna_slam", "arjuna_nav")
PACKAGES = ("arjuna_core", *CORES, "bringup")
# Each package's wings and files, what stands higher first; "" are the top-level files not named.
ORDER = {
    "arjuna_core": ("ros", "bags", "files", ""),
    "arjuna_sim": (
        *("nodes", "learning", "batch", "", "physics", "devices", "fusion", "processing"),
        *("files", "model"),
    ),
    "arjuna_slam": ("nodes", "", "amcl", "mapping", "graph", "matching", "logs"),
    "arjuna_nav": (
        *("nodes", "", "trees", "docking", "behaviors", "exploration", "safety", "routes"),
        *("controllers", "smoothers", "planners", "costmap"),
    ),
    "bringup": (
        *("", "commands", "lessons", "homework", "tuning", "campaign", "doctor", "demo"),
        *("scenarios", "processes"),
        *("offline", "ros2", "lockstep", "parameters", "client"),
        *("viewing", "recording", "stack", "terminal", "interrupts"),
    ),
}
# arjuna_interfaces holds messages, so it counts as ROS
ROS = {
    *("rclpy", "rosidl_runtime_py", "ament_index_python", "arjuna_interfaces", "bond"),
    *("action_msgs", "builtin_interfaces", "diagnostic_msgs", "geographic_msgs", "geometry_msgs"),
    *("dwb_msgs", "nav_2d_msgs", "control_msgs", "controller_manager_msgs", "gazebo_msgs"),
    *("trajectory_msgs",),
    *("lifecycle_msgs", "map_msgs", "nav2_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs"),
    *(
        "robot_localization",
        "rosbag2_interfaces",
        "sensor_msgs",
        "simulation_interfaces",
        "slam_toolbox",
        "std_msgs",
        "std_srvs",
        "tf2_msgs",
    ),
    *("unique_identifier_msgs", "visualization_msgs"),
}
# What a user can ask of bringup on a machine without ROS: help, checks, stacks, reports
BRINGUP_WITHOUT_ROS = tuple(
    f"{folder}{name}"
    for folder, names in {
        "": (
            "__init__.py __main__.py campaign/ cli.py doctor/checks/ lessons/ "
            "interrupts.py offline/ stack.py terminal.py viewing/drawing/"
        ),
        "client/": "avoidance.py endpoint.py keys.py waypoints.py",
        "demo/": "measures.py",
        "homework/": "exercise.py sandbox.py",
        "doctor/": "machine.py report.py snapshot.py table.py",
        "parameters/": "files.py listing.py options.py",
        "parameters/foreign/": "launch_file.py",
        "processes/": "child.py fork.py health.py supervisor.py",
        "recording/": "playback.py selection.py summary.py",
        "scenarios/": "barn.py doors.py drive.py furnished.py people.py scenes.py space.py",
        "ros2/": "completion.py errors.py grammar.py launches.py main.py statistics.py",
        "ros2/verbs/": "forward.py",
        "tuning/": "picture.py plan.py study.py tuner.py",
        "viewing/": "displays/ frame_tree.py pictures.py rviz_file.py snapshot.py",
        "viewing/rerun/": "scene.py shapes.py stream.py",
    }.items()
    for name in names.split()
)
LIBRARIES: dict[str, tuple[str, ...]] = {
    "mujoco": ("arjuna_sim/physics/", "arjuna_sim/devices/"),
    "rerun": ("bringup/viewing/",),
    "viser": ("bringup/viewing/",),
    "websockets": ("bringup/viewing/",),
    "optuna": ("bringup/tuning/",),
    "gymnasium": ("arjuna_sim/learning/",),
    "mujoco_warp": ("arjuna_sim/batch/",),
    "warp": ("arjuna_sim/batch/",),
    "ray": ("bringup/campaign/",),
    "mcap": ("arjuna_core/bags/",),
    "rosbags": ("arjuna_core/bags/",),
}


@cache
def every_import() -> list[Import]:
    """Return what all files import; asked for in tests, as others only collect this file."""
    return list(imports(ROOT, *PACKAGES))


def top(module: str) -> str:
    return module.split(".", maxsplit=1)[0]


def may_use_ros(path: str) -> bool:
    """Return whether a file is a node's, the shared ROS code's or one of bringup's ROS modules."""
    parts = path.split("/")
    if parts[0] == "bringup":
        return not path.removeprefix("bringup/").startswith(BRINGUP_WITHOUT_ROS)
    return "nodes" in parts[1:-1] or parts[:2] == ["arjuna_core", "ros"]


def unit(parts: list[str]) -> str:
    """Return the wing or file of a package's order that a path or module belongs to."""
    name = parts[1].removesuffix(".py") if len(parts) > 1 else ""
    return name if name in ORDER[parts[0]] else ""


def upward(found: list[Import]) -> list[Import]:
    """Return the imports of a wing that stands above the file's own."""
    wrong = []
    for item in found:
        order = ORDER[item.package]
        mine = order.index(unit(item.path.split("/")))
        for target in item.targets:
            parts = target.split(".")
            if parts[0] == item.package and len(parts) > 1 and order.index(unit(parts)) < mine:
                wrong.append(item)
                break
    return wrong


def unknown_wings(root: Path) -> list[str]:
    """Return the folders of packages that the order does not name."""
    return [
        f"{package}/{folder.name}"
        for package in PACKAGES
        for folder in sorted((root / package).glob("*/"))
        if any(folder.glob("*.py")) and folder.name not in ORDER[package]
    ]


def report(wrong: list[Import], rule: str) -> str:
    lines = [f"{item.location} imports {item.module}" for item in wrong]
    return "\n".join([rule, *lines])


def test_there_is_something_to_check() -> None:
    assert {item.package for item in every_import()} == set(PACKAGES)
    assert "arjuna_core/se2.py" in {item.path for item in every_import()}


def test_imports_are_absolute() -> None:
    wrong = [item for item in every_import() if item.module == "(relative)"]
    assert not wrong, report(wrong, "imports name the whole module")


def test_core_imports_no_package_of_ours() -> None:
    others = (*CORES, "bringup", "tests")
    wrong = [i for i in every_import() if i.package == "arjuna_core" and top(i.module) in others]
    assert not wrong, report(wrong, "arjuna_core imports no package of ours")


@pytest.mark.parametrize("package", CORES)
def test_simulation_slam_and_navigation_import_only_the_core(package: str) -> None:
    others = {*CORES, "bringup", "tests", "scripts"} - {package}
    wrong = [
        item for item in every_import() if item.package == package and top(item.module) in others
    ]
    assert not wrong, report(wrong, f"{package} imports only arjuna_core")


def test_wings_import_only_wings_below_them() -> None:
    wrong = upward(every_import())
    assert not wrong, report(wrong, "a wing imports only wings that stand below it in ORDER")


def test_every_wing_stands_in_the_order() -> None:
    assert not unknown_wings(ROOT)


def test_no_files_import_each_other_in_a_circle() -> None:
    assert not circles(file_graph(every_import(), ROOT))
    assert not circles(file_graph(list(imports(ROOT, "scripts")), ROOT))
    others = ROOT / "ros_packages"
    names = sorted(path.name for path in others.iterdir() if path.is_dir())
    graph = file_graph(list(imports(others, *names)), others)
    faces = {path for path in graph if path.endswith("__init__.py")}  # they hand names on
    assert not circles({path: graph[path] - faces for path in graph.keys() - faces})


def test_ros_is_imported_only_by_nodes_and_the_shared_ros_code() -> None:
    wrong = [
        item for item in every_import() if top(item.module) in ROS and not may_use_ros(item.path)
    ]
    assert not wrong, report(wrong, "ROS is for */nodes/, arjuna_core/ros/ and bringup's ROS files")


def test_files_without_ros_do_not_reach_it_through_ours() -> None:
    reaches = {item.path for item in every_import() if top(item.module) in ROS}
    graph = file_graph([item for item in every_import() if not item.typing], ROOT)
    while more := {path for path, targets in graph.items() if targets & reaches} - reaches:
        reaches |= more
    assert not {path for path in reaches if not may_use_ros(path)}


@pytest.mark.parametrize("library", LIBRARIES)
def test_heavy_libraries_stay_where_they_belong(library: str) -> None:
    allowed = LIBRARIES[library]
    wrong = [
        i for i in every_import() if top(i.module) == library and not i.path.startswith(allowed)
    ]
    assert not wrong, report(wrong, f"{library} is imported elsewhere than in {allowed}")


PLANTED = {
    "an upward import": ("matching/planted.py", "from arjuna_slam.slam import Slam\n"),
    "an import in a function": (
        "matching/planted.py",
        "def late():\n    from arjuna_slam import slam\n",
    ),
    "import_module": (
        "graph/planted.py",
        "import importlib\n\nimportlib.import_module('arjuna_slam.mapping.submap')\n",
    ),
    "import_module with a name put together": (
        "graph/planted.py",
        "import importlib\n\nimportlib.import_module(f'arjuna_slam.mapping.{1}')\n",
    ),
}


@pytest.mark.parametrize("case", PLANTED)
def test_what_is_planted_is_found(case: str, tmp_path: Path) -> None:
    path, text = PLANTED[case]
    write_all(tmp_path / "arjuna_slam", {"slam.py": "", "mapping/submap.py": "", path: text})
    assert [item.path for item in upward(list(imports(tmp_path, "arjuna_slam")))] == [
        f"arjuna_slam/{path}"
    ]


def test_a_planted_circle_is_found(tmp_path: Path) -> None:
    files = {
        "graph/a.py": "from arjuna_slam.graph import b\n",
        "graph/b.py": "def late():\n    from arjuna_slam.graph.a import thing\n",
    }
    write_all(tmp_path / "arjuna_slam", files)
    found = circles(file_graph(list(imports(tmp_path, "arjuna_slam")), tmp_path))
    assert found == [["arjuna_slam/graph/a.py", "arjuna_slam/graph/b.py"]]


def test_a_planted_wing_is_found(tmp_path: Path) -> None:
    write_all(tmp_path / "arjuna_slam", {"attic/old.py": "", "graph/a.py": ""})
    assert unknown_wings(tmp_path) == ["arjuna_slam/attic"]
