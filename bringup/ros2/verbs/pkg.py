"""`ros2 pkg list`, `prefix`, `xml`, `executables`."""

from __future__ import annotations

import argparse
from pathlib import Path

from ament_index_python import get_package_prefix, get_packages_with_prefixes
from ament_index_python.packages import PackageNotFoundError
from defusedxml import ElementTree

from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from arjuna_core.ros.context import add_environment_to_ament_index
from bringup.ros2.errors import Ros2Error
from bringup.ros2.verbs.forward import PROGRAMS


def list_(arguments: argparse.Namespace) -> None:
    """List the packages."""
    print("\n".join(sorted(_packages())))


def _packages() -> set[str]:
    add_environment_to_ament_index()
    return {*get_packages_with_prefixes(), *(package for package, _ in PROGRAMS)}


def _prefix(package: str) -> Path:
    add_environment_to_ament_index()
    try:
        return Path(get_package_prefix(package))
    except (PackageNotFoundError, ValueError) as error:
        raise Ros2Error("Package not found") from error


def prefix(arguments: argparse.Namespace) -> None:
    """Print where a package is installed."""
    found = _prefix(arguments.package_name)
    print(found / "share" / arguments.package_name if arguments.share else found)


def xml(arguments: argparse.Namespace) -> None:
    """Print a package's manifest, or the texts of one of its tags."""
    path = _prefix(arguments.package_name) / "share" / arguments.package_name / "package.xml"
    if not path.is_file():
        raise Ros2Error("Package xml manifest not found")
    root = parse_xml(path, read_bytes(path, 2**20))
    if arguments.tag is None:
        print(ElementTree.tostring(root, encoding="unicode"))
        return
    found = root.findall(arguments.tag)
    if not found:
        raise Ros2Error("XML tag not found")
    for element in found:
        print(element.text)


def executables(arguments: argparse.Namespace) -> None:
    """List what `ros2 run` can run."""
    wanted = arguments.package_name
    if wanted is not None and wanted not in _packages():
        raise Ros2Error(f"Package '{wanted}' not found")
    for package, name in sorted(PROGRAMS):
        if wanted in (None, package):
            print(package, name)
