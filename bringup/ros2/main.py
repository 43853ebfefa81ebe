"""`ros2`: a real ros2cli if there is one, else Arjuna's own with the same grammar."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NoReturn

from arjuna_core.errors import ArjunaError, interrupted
from bringup.interrupts import ignore_interrupts, was_interrupted, watch_interrupts
from bringup.ros2 import completion
from bringup.ros2.grammar import BUFFERED, FORWARDED, build_parser, load

FAILED, INTERRUPTED = 1, int(signal.SIGINT)  # as ros2cli ends
_HANDED_ON = "ARJUNA_ROS2_HANDED_ON"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    if argv is not None:
        return _guarded(list(argv))
    if real := real_ros2(os.environ, Path(sys.argv[0])):
        os.environ[_HANDED_ON] = "1"
        _become(real)
    code = _guarded(sys.argv[1:])
    ignore_interrupts()  # one would end the interpreter in order, below the middleware's threads
    with contextlib.suppress(BrokenPipeError):
        sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)  # all is closed; taking the modules apart costs a fifth of a command


def roslaunch() -> NoReturn:
    """Run ROS 1's command of that name as `ros2 launch`."""
    _instead("roslaunch", "launch")


def rosrun() -> NoReturn:
    """Run ROS 1's command of that name as `ros2 run`."""
    _instead("rosrun", "run")


def gazebo() -> NoReturn:
    """Run `gz sim WORLD` or Classic's `gazebo WORLD` as a launch file's."""
    _instead(Path(sys.argv[0]).name, "run", "gazebo_ros", "gzserver")


def rospack() -> NoReturn:
    """Run `rospack find PACKAGE` as `ros2 pkg prefix --share`."""
    words = {"find": ["pkg", "prefix", "--share"], "list": ["pkg", "list"]}
    _instead("rospack", *words.get("".join(sys.argv[1:2]), ["pkg", "-h"]), skip=1)


def _instead(name: str, *words: str, skip: int = 0) -> NoReturn:
    become_real(name)
    sys.exit(main([*words, *sys.argv[1 + skip :]]))


def _guarded(words: list[str]) -> int:
    """Run one command; its mistakes and its end by the user or the reader become exit codes."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    watch_interrupts()
    if words[:1] == [BUFFERED]:
        words = words[1:]
    else:
        sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    try:
        code = _run(words)
        sys.stdout.flush()
        return code
    except ArjunaError as error:
        sys.stderr.write(f"{error}\n")
    except ModuleNotFoundError as error:
        sys.stderr.write(f"the module {error.name} is not installed; run 'make setup'\n")
    except (KeyboardInterrupt, ImportError, SystemError) as error:
        if not interrupted(error) and not was_interrupted():  # C extensions drop it
            raise
        return 0 if words[:1] == ["run"] else INTERRUPTED  # a node ends in order, as C++'s do
    except BrokenPipeError:  # nobody reads any more, as after `| head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    return FAILED


def _run(words: list[str]) -> int:
    if words[:1] == ["--completion"]:
        print(completion.script(words[1] if len(words) > 1 else "bash"))
        return 0
    if words and words[0] in FORWARDED:
        return load(FORWARDED[words[0]][1])(words[1:]) or 0
    parser = build_parser()
    arguments = parser.parse_args(words)
    if getattr(arguments, "run", None) is None:
        print(getattr(arguments, "help", parser.format_help)(), end="")
        return 0
    return load(arguments.run)(arguments) or 0


def real_ros2(environment: Mapping[str, str], own: Path) -> str | None:
    """Return the `ros2` of a sourced ROS, or None."""
    return None if _HANDED_ON in environment else real_program("ros2", environment, own)


def real_program(name: str, environment: Mapping[str, str], own: Path) -> str | None:
    """Return a program of a sourced ROS, or None; `own` is the one of that name that runs."""
    if "ROS_DISTRO" not in environment:
        return None
    bins = {own.resolve().parent, Path(sys.executable).parent.resolve()}
    folders = environment.get("PATH", "").split(os.pathsep)
    others = [folder for folder in folders if folder and Path(folder).resolve() not in bins]
    return shutil.which(name, path=os.pathsep.join(others))


def become_real(name: str) -> None:
    """Run a program of a sourced ROS, if there is one, in this one's stead; its libraries too."""
    _become(real_program(name, os.environ, Path(sys.argv[0])))


def _become(real: str | None) -> None:
    if real is not None:
        environment = without_wheels(os.environ)
        os.execve(real, [real, *sys.argv[1:]], environment)  # noqa: S606 - what the user asked for


def without_wheels(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without what the ROS wheels of this Python environment have set."""
    prefix = Path(sys.prefix).resolve()
    folders = environment.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    others = [one for one in folders if one and not Path(one).resolve().is_relative_to(prefix)]
    left_out = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "LD_LIBRARY_PATH")
    kept = {name: value for name, value in environment.items() if name not in left_out}
    return kept | ({"LD_LIBRARY_PATH": os.pathsep.join(others)} if others else {})


if __name__ == "__main__":
    sys.exit(main())
