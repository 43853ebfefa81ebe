"""`ros2 pkg create`, `list`, `prefix`, `xml`, `executables`."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from ament_index_python import get_package_prefix, get_packages_with_prefixes
from ament_index_python.packages import PackageNotFoundError
from defusedxml import ElementTree

from arjuna_core.files.input_file import read_bytes
from arjuna_core.files.xml_text import parse_xml
from bringup.ros2.errors import Ros2Error
from bringup.ros2.prefix import add_prefix
from bringup.ros2.verbs.forward import PROGRAMS, executables_of

_MANIFEST = """<?xml version="1.0"?>
<?xml-model href="http://download.ros.org/schema/package_format3.xsd"
  schematypens="http://www.w3.org/2001/XMLSchema"?>
<package format="{package_format}">
  <name>{package_name}</name>
  <version>0.0.0</version>
  <description>{description}</description>
  <maintainer email="{maintainer_email}">{maintainer_name}</maintainer>
  <license>{license}</license>

{depends}  <export>
    <build_type>{build_type}</build_type>
  </export>
</package>
"""
_SETUP = """from setuptools import find_packages, setup

package_name = '{package_name}'

setup(
    name=package_name,
    version='0.0.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        ('share/ament_index/resource_index/packages',
            ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='{maintainer_name}',
    maintainer_email='{maintainer_email}',
    description='{description}',
    license='{license}',
    entry_points={{
        'console_scripts': [
{scripts}        ],
    }},
)
"""
_CONFIG = """[develop]
script_dir=$base/lib/{0}
[install]
install_scripts=$base/lib/{0}
"""
_CMAKE = """cmake_minimum_required(VERSION 3.8)
project({0})

find_package(ament_cmake REQUIRED)
{1}
# install(DIRECTORY launch urdf DESTINATION share/${{PROJECT_NAME}})

ament_package()
"""
_NODE = """def main():
    print('Hi from {0}.')


if __name__ == '__main__':
    main()
"""


def create(arguments: argparse.Namespace) -> None:
    """Write the files of a new package: of Python, or of launch files and other data."""
    given, name, node = vars(arguments), arguments.package_name, arguments.node_name
    is_python = arguments.build_type == "ament_python"
    if node and not is_python:
        raise Ros2Error(
            f"'{node}' would be C++, which is not built here; --build-type ament_python"
        )
    if not re.fullmatch(r"[a-z]\w*", name):
        raise Ros2Error(f"'{name}' is no name of a package; valid: small letters, digits and _")
    folder = Path(arguments.destination_directory) / name
    if folder.exists():
        raise Ros2Error(f"Aborted! The directory already exists: {folder.resolve()}")
    depends = "".join(f"  <depend>{one}</depend>\n" for one in arguments.dependencies)
    if is_python:
        files = _python_files(given, name, node)
    else:
        depends = f"  <buildtool_depend>ament_cmake</buildtool_depend>\n\n{depends}"
        needs = "".join(f"find_package({one} REQUIRED)\n" for one in arguments.dependencies)
        files = {"CMakeLists.txt": _CMAKE.format(name, needs)}
    escaped = {key: escape(str(value)) for key, value in given.items()}
    manifest = _MANIFEST.format(**escaped, depends=depends + ("\n" if depends else ""))
    print(f"going to create a new package\npackage name: {name}")
    print(f"destination directory: {folder.parent.resolve()}\nbuild type: {arguments.build_type}")
    print(f"dependencies: {arguments.dependencies}\ncreating folder {folder}")
    for path, text in {"package.xml": manifest, **files}.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
        print(f"creating {folder / path}")


def _python_files(given: dict[str, Any], name: str, node: str | None) -> dict[str, str]:
    quoted = {key: str(value).replace("'", "\\'") for key, value in given.items()}
    scripts = f"            '{node} = {name}.{node}:main',\n" if node else ""
    return {
        "setup.py": _SETUP.format(**quoted, scripts=scripts),
        "setup.cfg": _CONFIG.format(name),
        f"resource/{name}": "",
        f"{name}/__init__.py": "",
        **({f"{name}/{node}.py": _NODE.format(name)} if node else {}),
    }


def list_(arguments: argparse.Namespace) -> None:
    """List the packages."""
    print("\n".join(sorted(_packages())))


def _packages() -> set[str]:
    add_prefix()
    return {*get_packages_with_prefixes(), *(package for package, _ in PROGRAMS)}


def _prefix(package: str) -> Path:
    add_prefix()
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
    root = parse_xml(path, read_bytes(path))
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
    ours = add_prefix() / "lib"
    paths = {(package, name): ours / package / name for package, name in PROGRAMS}
    for package in _packages():
        paths |= {(package, name): path for name, path in executables_of(package).items()}
    for (package, name), path in sorted(paths.items()):
        if wanted in (None, package):
            print(path if arguments.full_path else f"{package} {name}")
