"""Installs a package by its setup.py into a prefix, in a process of its own."""

from __future__ import annotations

import configparser
import sys
from distutils.core import run_setup
from pathlib import Path
from typing import Any

import setuptools

from arjuna_core.files.input_file import read_text
from bringup.ros2.workspace.colcon import put

_PROGRAM = """#!{0}
import sys

try:
    from {1} import {2}
except ModuleNotFoundError as error:
    from bringup.ros2.verbs.remedies import missing

    sys.exit(missing(error))

sys.exit({3}())
"""


def main(name: str, prefix: Path, build: Path, linked: bool, site: str) -> None:
    """Install the package of the working folder; links to the sources where wanted."""
    sys.path.insert(0, str(Path.cwd()))
    words = [
        *("-q", "egg_info", "--egg-base", str(build), "build", "--build-base", str(build / "out")),
        *("install_lib", "--install-dir", str(prefix / site), "--skip-build"),
        *("install_egg_info", "--install-dir", str(prefix / site)),
        *("install_data", "--install-dir", str(prefix)),
    ]
    distribution: Any = run_setup("setup.py", script_args=words, stop_after="commandline")
    distribution.data_files = distribution.data_files or []
    distribution.run_commands()
    _write_programs(distribution, name, prefix, build)
    if linked:
        _link(distribution, prefix, prefix / site)


def _write_programs(distribution: Any, name: str, prefix: Path, build: Path) -> None:
    folder = prefix / "lib" / name
    for script in distribution.scripts or ():
        put(Path(script), folder / Path(script).name, False)
    for path in build.glob("*.egg-info/entry_points.txt"):
        points = configparser.ConfigParser(delimiters=("=",))
        points.optionxform = str  # type: ignore[assignment,method-assign]
        points.read_string(read_text(path))
        for program, where in (
            points["console_scripts"].items() if points.has_section("console_scripts") else ()
        ):
            module, _, function = where.partition(":")
            text = _PROGRAM.format(sys.executable, module, function.partition(".")[0], function)
            folder.mkdir(parents=True, exist_ok=True)
            (folder / program).write_text(text, encoding="utf-8")
    for path in folder.glob("*"):
        path.chmod(0o755)


def _link(distribution: Any, prefix: Path, site: Path) -> None:
    """Put links in place of copies of modules and data."""
    folders = distribution.package_dir or {}
    for package in {each.partition(".")[0] for each in distribution.packages or ()}:
        put(Path(folders.get(package, Path(folders.get("", "."), package))), site / package, True)
    for module in distribution.py_modules or ():
        put(Path(folders.get("", "."), f"{module}.py"), site / f"{module}.py", True)
    for item in distribution.data_files or ():
        into, sources = item if not isinstance(item, str) else (".", [item])
        for source in sources:
            put(Path(source), prefix / into / Path(source).name, True)


if __name__ == "__main__":
    assert setuptools  # it replaces distutils
    _name, _prefix, _build, _linked, _site = sys.argv[1:]
    main(_name, Path(_prefix), Path(_build), _linked == "1", _site)
