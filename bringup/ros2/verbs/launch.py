"""`ros2 launch`: launch files of one's own, and what starts the same as known packages' files."""

from __future__ import annotations

import argparse
import os
import re
import shlex
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from arjuna_core.errors import nearest
from arjuna_core.files.shipped import shipped_file
from bringup.ros2.errors import Ros2Error
from bringup.ros2.launches import COMPOSED, DESCRIBED, LAUNCHES, PLUGINS, Launch
from bringup.ros2.prefix import add_prefix
from bringup.ros2.roslaunch import commands, commands_of, is_ros1
from bringup.ros2.translation import arguments_of, known_arguments, renamed, translated
from bringup.ros2.verbs.forward import LAUNCHED, arjuna, module_of, remedy
from bringup.ros2.verbs.remedies import remedy_of_module

if TYPE_CHECKING:
    from launch import LaunchDescription, LaunchService

_USAGE = "usage: ros2 launch [-h] [-n] [-d] [-p | -s] [-a] [--launch-prefix PREFIX] \\\n"
_USAGE += "    [--launch-prefix-filter REGEX] package_name|FILE [launch_file] [NAME:=VALUE ...]"


def _parsed(words: list[str]) -> tuple[argparse.Namespace, list[str]]:
    """Return the options of `ros2 launch`, wherever they stand, and the other words."""
    parser = argparse.ArgumentParser("ros2 launch", add_help=False, allow_abbrev=False)
    for name, *others in (
        ("-h", "--help"),
        ("-n", "--noninteractive"),
        ("-d", "--debug"),
        ("-p", "--print", "--print-description"),
        ("-s", "--show-args", "--show-arguments"),
        ("-a", "--show-all-subprocesses-output"),
    ):
        parser.add_argument(name, *others, action="store_true")
    parser.add_argument("--launch-prefix", default="")
    parser.add_argument("--launch-prefix-filter", default="")
    return parser.parse_known_args(words)


def run(words: list[str]) -> int:
    """Start what a launch file describes; say which command that is where one of ours does it."""
    options, rest = _parsed(words)
    if options.help or not rest:
        listed = "\n".join(
            f"  {package} {file}" for package, file in (*COMPOSED, *DESCRIBED, *LAUNCHES)
        )
        print(f"{_USAGE}\n\nof ours, beside those of your own packages:\n{listed}")
        return 0 if options.help else 2
    first, *rest = rest
    if Path(first).is_file():
        return start(Path(first), rest, options)
    if not rest or ":=" in rest[0]:
        raise Ros2Error(f"there is no launch file {first}\n{_USAGE}")
    package, file, *rest = (first, *rest)
    path = _of_package(package, file)
    if path is not None:
        return start(path, rest, options)
    if of_ros1 := commands_of(package, file, rest) if file.endswith(".launch") else []:
        prepare()
        return _launched(_all(of_ros1), options)
    if (package, file) in (*COMPOSED, *DESCRIBED):
        return start(add_prefix() / "share" / package / "launch" / file, rest, options)
    if (package, file) not in LAUNCHES:
        near = nearest(f"{package} {file}", [" ".join(known) for known in LAUNCHES])
        raise Ros2Error(
            f"no launch file '{file}' of '{package}'; {near}\n{remedy(package)}\n"
            "What others start has a command here: 'python -m bringup' lists them all"
        )
    return _known(LAUNCHES[package, file], rest, options)


def _known(found: Launch, words: list[str], options: argparse.Namespace) -> int:
    """Become the command that does the same as a known launch file, or say what it is."""
    if options.show_args:
        print(arguments_of(found))
        return 0
    command, remarks = translated(found, [*words, *["--debug"] * options.debug])
    print("".join(f"{line}\n" for line in remarks), end="")
    print(f"$ python -m {module_of(command[0])} {shlex.join(command)}", flush=True)
    return 0 if options.print else arjuna(command[0], command[1:])


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


def start(path: Path, words: list[str], options: argparse.Namespace) -> int:
    """Launch a file of one's own, or list its arguments, or print what it describes."""
    import launch
    from launch.actions import IncludeLaunchDescription
    from launch.launch_description_sources import AnyLaunchDescriptionSource
    from launch.logging import launch_config

    prepare()
    source = AnyLaunchDescriptionSource(str(path))
    if wrong := [word for word in words if ":=" not in word]:
        raise Ros2Error(f"'{wrong[0]}' is no argument; valid: NAME:=VALUE")
    if options.show_args:
        found = source.get_launch_description(launch.LaunchContext())
        return show(found.get_launch_arguments())
    if options.print and not is_ros1(path):
        return _launched(source.get_launch_description(launch.LaunchContext()), options)
    if not os.environ.get("ROS_LOG_DIR"):
        os.environ["ROS_LOG_DIR"] = launch_config.log_dir
    log = launch.logging.get_logger("launch")
    log.info(f"All log files can be found below {launch_config.log_dir}")
    if is_ros1(path):
        service = _service(options)
        words_of, notes, missing = commands(path, service.context.new_file)
        for line in (*notes, *missing):
            log.error(line)
        service.context.problems += missing
        return _launched(_all(words_of), options, service)
    pairs = [(name, value) for name, _, value in (word.partition(":=") for word in words)]
    included = IncludeLaunchDescription(source, launch_arguments=pairs)
    return _launched(launch.LaunchDescription([included]), options, _service(options, words))


def _service(options: argparse.Namespace, argv: Sequence[str] = ()) -> LaunchService:
    from launch import LaunchService

    service = LaunchService(argv=argv, debug=options.debug)
    for name in ("launch-prefix", "launch-prefix-filter"):
        if value := getattr(options, name.replace("-", "_")):
            service.context.launch_configurations[name] = value
    return service


def _launched(
    description: LaunchDescription,
    options: argparse.Namespace,
    service: LaunchService | None = None,
) -> int:
    if options.print:
        from launch import LaunchIntrospector

        print(LaunchIntrospector().format_launch_description(description))
        return 0
    service = service or _service(options)
    service.include_launch_description(description)
    return service.run()


def _explained(error: Exception) -> str:
    """Return what to do about an error of a launch file."""
    if isinstance(error, ModuleNotFoundError):
        return f"'{error.name}' is not installed here; {remedy_of_module(str(error.name))}"
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
    from launch import LaunchDescriptionSource
    from launch.actions import IncludeLaunchDescription
    from launch.conditions import IfCondition
    from launch.substitutions import LaunchConfiguration

    from bringup.ros2.described import launch_file

    usual = dict.fromkeys(filter(None, parts.values()), "true")
    if any("map" in LAUNCHES[part].options for part in parts):
        usual["map"] = str(shipped_file("maps/pillar_arena.yaml"))
    included = (
        IncludeLaunchDescription(
            LaunchDescriptionSource(description(*part)),
            condition=IfCondition(LaunchConfiguration(flag)) if flag else None,
        )
        for part, flag in parts.items()
    )
    return launch_file(usual, *included)


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
        command, remarks = translated(one, [f"{name}:={value}" for name, value in given.items()])
        command += renamed(command[0], known.get("ros_remaps", ()))
        return [*(LogInfo(msg=line) for line in remarks), process(command)]

    # arguments are not declared: their defaults would be those of what is included next
    return LaunchDescription([OpaqueFunction(function=started)])
