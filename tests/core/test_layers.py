"""Claims: the packages import each other, ROS and heavy libraries only where the design allows."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[2]
CORES = ("arjuna_sim", "arjuna_slam", "arjuna_nav")
PACKAGES = ("arjuna_core", *CORES, "bringup")
# arjuna_interfaces holds messages, so it counts as ROS
ROS = {
    *("rclpy", "rosidl_runtime_py", "ament_index_python", "arjuna_interfaces", "bond"),
    *("action_msgs", "builtin_interfaces", "diagnostic_msgs", "geographic_msgs", "geometry_msgs"),
    *("lifecycle_msgs", "map_msgs", "nav2_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs"),
    *("sensor_msgs", "simulation_interfaces", "slam_toolbox", "std_msgs", "std_srvs", "tf2_msgs"),
    *("unique_identifier_msgs", "visualization_msgs"),
}
# What a user can ask of bringup on a machine without ROS: help, checks, stacks, reports
BRINGUP_WITHOUT_ROS = (
    *("__init__", "__main__", "cli_parser", "stack", "parameters", "measures", "pictures"),
    *("demo_report", "progress", "restart", "child", "supervisor", "lifecycle_plan"),
    *("offline_slam", "offline_amcl", "offline_files", "calibration"),
)


class Import(NamedTuple):
    """One import statement: where it stands, and the modules it names."""

    place: str
    package: str
    path: str
    module: str


def imports() -> Iterator[Import]:
    """Every import of the packages, at any depth of the code."""
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            path = file.relative_to(ROOT).as_posix()
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                for module in _modules(node):
                    yield Import(f"{path}:{getattr(node, 'lineno', 0)}", package, path, module)


def _modules(node: ast.AST) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        return ["(relative)" if node.level else str(node.module)]
    return []


IMPORTS = list(imports())


def top(module: str) -> str:
    return module.split(".", maxsplit=1)[0]


def may_use_ros(path: str) -> bool:
    """Whether a file is a node's, the shared ROS code's or one of bringup's ROS modules."""
    parts = path.split("/")
    if parts[0] == "bringup":
        return Path(path).stem not in BRINGUP_WITHOUT_ROS
    return "nodes" in parts[1:-1] or parts[:2] == ["arjuna_core", "ros"]


def report(wrong: list[Import], rule: str) -> str:
    lines = [f"{item.place} imports {item.module}" for item in wrong]
    return "\n".join([rule, *lines])


def test_there_is_something_to_check() -> None:
    assert {item.package for item in IMPORTS} >= {"arjuna_core", "arjuna_slam"}
    assert all(path in {item.path for item in IMPORTS} for path in ("arjuna_core/se2.py",))


def test_imports_are_absolute() -> None:
    wrong = [item for item in IMPORTS if item.module == "(relative)"]
    assert not wrong, report(wrong, "imports name the whole module")


def test_core_imports_no_package_of_ours() -> None:
    wrong = [
        item
        for item in IMPORTS
        if item.package == "arjuna_core" and top(item.module) in (*CORES, "bringup", "tests")
    ]
    assert not wrong, report(wrong, "arjuna_core imports no package of ours")


@pytest.mark.parametrize("package", CORES)
def test_simulation_slam_and_navigation_import_only_the_core(package: str) -> None:
    others = {*CORES, "bringup", "tests", "scripts"} - {package}
    wrong = [item for item in IMPORTS if item.package == package and top(item.module) in others]
    assert not wrong, report(wrong, f"{package} imports only arjuna_core")


def test_ros_is_imported_only_by_nodes_and_the_shared_ros_code() -> None:
    wrong = [item for item in IMPORTS if top(item.module) in ROS and not may_use_ros(item.path)]
    assert not wrong, report(wrong, "ROS is for */nodes/, arjuna_core/ros/ and bringup's ROS files")


def test_algorithms_import_neither_nodes_nor_the_shared_ros_code() -> None:
    wrong = [
        item
        for item in IMPORTS
        if not may_use_ros(item.path)
        and (item.module.startswith("arjuna_core.ros") or ".nodes" in item.module)
    ]
    assert not wrong, report(wrong, "ROS-free files import no ROS file of ours")


@pytest.mark.parametrize(
    ("library", "allowed"),
    [
        ("mujoco", lambda path: path.startswith("arjuna_sim/")),
        ("rerun", lambda path: path.startswith("bringup/viewing")),
        ("mcap", lambda path: Path(path).stem.startswith(("recording", "offline"))),
    ],
    ids=["mujoco", "rerun", "mcap"],
)
def test_heavy_libraries_stay_where_they_belong(library: str, allowed: object) -> None:
    assert callable(allowed)
    wrong = [item for item in IMPORTS if top(item.module) == library and not allowed(item.path)]
    assert not wrong, report(wrong, f"{library} is imported elsewhere")


def test_bringup_starts_modules_by_name() -> None:
    wrong = [item for item in IMPORTS if item.package == "bringup" and top(item.module) in CORES]
    assert not wrong, report(wrong, "bringup imports no algorithm and no node")
