"""`ros2 launch`: launch files of one's own, and what starts the same as known packages' files."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arjuna_core.errors import nearest
from arjuna_core.files.shipped import shipped_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.launches import COMPOSED, DESCRIBED, LAUNCHES, PLUGINS
from bringup.ros2.prefix import add_prefix
from bringup.ros2.roslaunch import commands, commands_of, is_ros1
from bringup.ros2.translation import arguments_of, known_arguments, renamed, translated
from bringup.ros2.verbs.forward import LAUNCHED, arjuna, module_of, remedy

if TYPE_CHECKING:
    from launch import LaunchDescription, LaunchService

_USAGE = "usage: ros2 launch [-h] [-s] [-d] package_name|FILE [launch_file] [NAME:=VALUE ...]"
_SHOW = ("-s", "--show-args", "--show-arguments")
_SILENT = ("-n", "--noninteractive", "-a", "--show-all-subprocesses-output")


def run(words: list[str]) -> int:
    """Start what a launch file describes; say which command that is where one of ours does it."""
    debug = bool({"-d", "--debug"} & set(words))
    shows = bool(set(_SHOW) & set(words))
    first, *rest = [word for word in words if word not in (*_SHOW, *_SILENT)] or ["-h"]
    own = [word for word in rest if word not in ("-d", "--debug")]
    if first in ("-h", "--help"):
        listed = "\n".join(
            f"  {package} {file}" for package, file in (*COMPOSED, *DESCRIBED, *LAUNCHES)
        )
        print(f"{_USAGE}\n\nof ours, beside those of your own packages:\n{listed}")
        return 0 if words else 2
    if Path(first).is_file():
        return start(Path(first), own, shows, debug)
    if not rest or ":=" in rest[0]:
        raise Ros2Error(f"there is no launch file {first}\n{_USAGE}")
    package, file, *rest = (first, *rest)
    path = _of_package(package, file)
    if path is not None:
        return start(path, own[1:], shows, debug)
    if of_ros1 := commands_of(package, file, own[1:]) if file.endswith(".launch") else []:
        return _launched(_service(), _all(of_ros1))
    if (package, file) in (*COMPOSED, *DESCRIBED):
        return start(add_prefix() / "share" / package / "launch" / file, own[1:], shows, debug)
    if (package, file) not in LAUNCHES:
        near = nearest(f"{package} {file}", [" ".join(known) for known in LAUNCHES])
        raise Ros2Error(
            f"no launch file '{file}' of '{package}'; {near}\n{remedy(package)}\n"
            "What others start has a command here: 'python -m bringup' lists them all"
        )
    if shows:
        print(arguments_of(LAUNCHES[package, file]))
        return 0
    translation = translated(LAUNCHES[package, file], rest)
    print("".join(f"{line}\n" for line in translation.remarks), end="")
    command = translation.command
    print(f"$ python -m {module_of(command[0])} {shlex.join(command)}", flush=True)
    return arjuna(command[0], command[1:])


def _of_package(package: str, file: str) -> Path | None:
    """Return a launch file of a package of one's own; None where it has none of that name."""
    from ament_index_python import get_package_share_directory
    from ament_index_python.packages import PackageNotFoundError

    folder = add_prefix()
    try:
        share = Path(get_package_share_directory(package))
    except (PackageNotFoundError, ValueError):
        return None
    found = sorted(share.rglob(file)) if not share.is_relative_to(folder) else []
    if not found and not share.is_relative_to(folder):
        there = sorted(path.name for path in share.rglob("*launch*") if path.is_file())
        raise Ros2Error(f"'{file}' is not in {share}; {nearest(file, there)}")
    return found[0] if found else None


def prepare() -> None:
    """Have launch files find what they refer to: packages, programs and a sourced ROS's names."""
    from launch import LaunchService
    from launch_ros.actions import LoadComposableNodes, Missing

    programs = add_prefix() / "bin"
    LaunchService.explain = staticmethod(_explained)
    Missing.remedy = staticmethod(remedy)
    LoadComposableNodes.plugins = PLUGINS
    folder = str(Path(sys.executable).parent)
    path_of_user = os.environ.get("PATH", os.defpath)
    if str(programs) not in path_of_user.split(os.pathsep):
        os.environ["PATH"] = os.pathsep.join([folder, path_of_user, str(programs)])
    known = {"ROS_DISTRO": "jazzy", "ROS_VERSION": "2", "GZ_SIM_RESOURCE_PATH": "", LAUNCHED: "1"}
    for name, value in known.items():
        os.environ.setdefault(name, value)


def start(path: Path, words: list[str], shows: bool = False, debug: bool = False) -> int:
    """Launch a file of one's own, or list its arguments."""
    import launch
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource
    from launch.logging import launch_config

    prepare()
    source = AnyLaunchDescriptionSource(str(path))
    if wrong := [word for word in words if ":=" not in word]:
        raise Ros2Error(f"'{wrong[0]}' is no argument; valid: NAME:=VALUE")
    if shows:
        found = source.get_launch_description(launch.LaunchContext())
        return show(found.get_launch_arguments())
    if not os.environ.get("ROS_LOG_DIR"):
        os.environ["ROS_LOG_DIR"] = launch_config.log_dir
    log = launch.logging.get_logger("launch")
    log.info(f"All log files can be found below {launch_config.log_dir}")
    service = _service(debug)
    if is_ros1(path):
        words_of, problems = commands(path, service.context.new_file)
        for line in problems:
            log.error(line)
        return _launched(service, _all(words_of))
    pairs = [(name, value) for name, _, value in (word.partition(":=") for word in words)]
    included = IncludeLaunchDescription(source, launch_arguments=pairs)
    return _launched(service, launch.LaunchDescription([included]))


def _service(debug: bool = False) -> LaunchService:
    from launch import LaunchService

    prepare()
    return LaunchService(debug=debug)


def _launched(service: LaunchService, description: LaunchDescription) -> int:
    service.include_launch_description(description)
    return service.run()


def _explained(error: Exception) -> str:
    """Return what to do about an error of a launch file."""
    if isinstance(error, ModuleNotFoundError):
        return f"'{error.name}' is not installed here; {remedy(str(error.name))}"
    if isinstance(error, KeyError) and str(error.args[0]).isupper():
        return f"export {error.args[0]}=VALUE: it is read from the environment"
    package = re.search(r"package '(\w+)' not found", str(error))
    return remedy(package[1]) if package else ""


def _all(found: list[list[str]]) -> LaunchDescription:
    """Return commands of ours as a description."""
    from launch import LaunchDescription
    from launch.actions import LogInfo

    from bringup.ros2.described import process

    lines = (f"$ python -m {module_of(one[0])} {shlex.join(one)}" for one in found)
    return LaunchDescription([*(LogInfo(msg=one) for one in lines), *map(process, found)])


def show(arguments: Iterable[Any]) -> int:
    """List launch arguments; return 0."""
    print("Arguments (pass arguments as '<name>:=<value>'):\n")
    for one in arguments:
        default = "".join(
            getattr(part, "text", part.describe()) for part in one.default_value or ()
        )
        print(f"    '{one.name}':\n        {one.description}")
        if one.choices:
            print(f"        one of: {', '.join(one.choices)}")
        print(f"        (default: '{default}')\n" if one.default_value is not None else "")
    return 0


def _composed(parts: Mapping[tuple[str, str], str]) -> LaunchDescription:
    """Return a launch file that includes others, with the arguments of all."""
    from launch import LaunchDescription, LaunchDescriptionSource
    from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
    from launch.conditions import IfCondition
    from launch.substitutions import LaunchConfiguration

    usual = dict.fromkeys(parts.values(), "true")
    if any("map" in LAUNCHES[part].options for part in parts):
        usual["map"] = str(shipped_file("maps/pillar_arena.yaml"))
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value)
                for name, value in usual.items()
                if name
            ),
            *(
                IncludeLaunchDescription(
                    LaunchDescriptionSource(description(*part)),
                    condition=IfCondition(LaunchConfiguration(flag)) if flag else None,
                )
                for part, flag in parts.items()
            ),
        ]
    )


def description(package: str, file: str) -> LaunchDescription:
    """Return what a launch file of a known package is, as an action that starts ours."""
    if (package, file) in DESCRIBED:
        module = import_module("bringup.ros2.described")
        found: LaunchDescription = getattr(module, DESCRIBED[package, file])()
        return found
    if (package, file) in COMPOSED:
        return _composed(COMPOSED[package, file])
    from launch import LaunchDescription
    from launch.actions import LogInfo, OpaqueFunction

    from bringup.ros2.described import process

    one = LAUNCHES[package, file]

    def started(context: Any) -> list[Any]:
        known = context.launch_configurations
        given = {name: known[name] for name in sorted(known_arguments(one)) if known.get(name)}
        if "namespace" in one.options and (outer := known.get("ros_namespace", "")):
            given.setdefault("namespace", outer.strip("/"))
        found = translated(one, [f"{name}:={value}" for name, value in given.items()])
        command = [*found.command, *renamed(found.command[0], known.get("ros_remaps", ()))]
        return [*(LogInfo(msg=line) for line in found.remarks), process(command)]

    # arguments are not declared: their defaults would be those of what is included next
    return LaunchDescription([OpaqueFunction(function=started)])
