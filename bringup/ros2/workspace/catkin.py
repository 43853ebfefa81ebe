"""ROS 1's commands for packages, as far as nothing has to be compiled: see `colcon`."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import NoReturn

from bringup.ros2.main import become_real
from bringup.ros2.workspace.colcon import main
from bringup.ros2.workspace.packages import NAME

_CATKIN = """<package format="2">
  <name>{0}</name>
  <version>0.0.0</version>
  <description>The {0} package</description>
  <maintainer email="user@todo.todo">user</maintainer>
  <license>TODO</license>
  <buildtool_depend>catkin</buildtool_depend>
{1}</package>
"""


def catkin_make() -> NoReturn:
    """Run ROS 1's command of that name: build the packages of `src` into `devel`."""
    become_real("catkin_make")
    sys.exit(main(["build", "--symlink-install", "--base-paths", "src", "--install-base", "devel"]))


def catkin_create_pkg() -> NoReturn:
    """Run ROS 1's command of that name: write a package's manifest and CMakeLists.txt."""
    become_real("catkin_create_pkg")
    name, *depends = [word for word in sys.argv[1:] if word[:1] != "-"] or ["-"]
    folder = Path(name)
    if not re.fullmatch(NAME, name) or folder.exists():
        sys.exit(f"usage: catkin_create_pkg NAME [DEPENDENCY ...]; '{name}' is no new name")
    folder.mkdir()
    needs = "".join(f"  <depend>{one}</depend>\n" for one in depends)
    (folder / "package.xml").write_text(_CATKIN.format(name, needs), encoding="utf-8")
    text = f"project({name})\nfind_package(catkin REQUIRED)\ncatkin_package()\n"
    (folder / "CMakeLists.txt").write_text(text, encoding="utf-8")
    sys.exit(0)
