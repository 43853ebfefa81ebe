"""`colcon`: packages of Python, and of data, built into a workspace that can be sourced.

What colcon 0.18 and colcon-ros 0.5 lay down for them: `install/PACKAGE` with `lib/PACKAGE`,
`lib/pythonX.Y/site-packages` and `share/PACKAGE`, and `install/setup.bash`.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

from arjuna_core.errors import ArjunaError, nearest
from arjuna_core.files.input_file import read_text
from bringup.ros2.errors import Ros2Error
from bringup.ros2.main import become_real
from bringup.ros2.prefix import prefix_folder
from bringup.ros2.workspace.cmake import read_cmake
from bringup.ros2.workspace.packages import SITE, Package, packages_below
from bringup.ros2.workspace.testing import run_tests, show_results

_REMEDY = "ROS's own tools build it, what else the package installs is there"


def run() -> None:
    """Run colcon: that of a sourced ROS where there is one, else this."""
    become_real("colcon")
    sys.exit(main(sys.argv[1:]))


def main(words: Sequence[str]) -> int:
    """Build, test or list the packages below the working folder; return the exit code."""
    parser = _parser()
    arguments, unknown = parser.parse_known_args(words)
    if unknown:
        print(f"no effect: {' '.join(unknown)}")
    try:
        if arguments.verb == "test-result":
            return show_results(arguments)
        packages = _chosen(arguments)
        if arguments.verb == "test":
            return run_tests(packages, arguments)
        if arguments.verb == "list":
            print("\n".join(f"{p.name}\t{p.folder}\t({p.kind})" for p in packages))
            return 0
        return _build_all(packages, arguments)
    except ArjunaError as error:
        sys.stderr.write(f"{error}\n")
        return 1


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="colcon", description=__doc__.splitlines()[0])
    verbs = parser.add_subparsers(dest="verb", required=True)
    listing = verbs.add_parser("list", help="list the packages")
    build = verbs.add_parser("build", help="build them")
    test = verbs.add_parser("test", help="run their tests")
    results = verbs.add_parser("test-result", help="list what their tests have written")
    for verb in (listing, build, test):
        verb.add_argument("--base-paths", nargs="+", default=["."])
        for option in ("--packages-select", "--packages-up-to", "--packages-skip"):
            verb.add_argument(option, nargs="+", default=[], metavar="PACKAGE")
    build.add_argument("--symlink-install", action="store_true", help="link to the sources")
    for verb in (build, test):
        for base in ("build", "install"):
            verb.add_argument(f"--{base}-base", type=Path, default=Path(base))
        for option in ("--event-handlers", "--cmake-args", "--ament-cmake-args", "--mixin"):
            verb.add_argument(option, nargs="*", help="without an effect")
        verb.add_argument("--parallel-workers", type=int, help="without an effect")
    test.add_argument("--pytest-args", nargs="*", default=[], help="words of pytest")
    test.add_argument("--ctest-args", nargs="*", help="without an effect")
    test.add_argument(
        "--return-code-on-test-failure", action="store_true", help="1 where one fails"
    )
    results.add_argument("--test-result-base", type=Path, default=Path("build"))
    results.add_argument("--all", action="store_true", help="those that passed, too")
    results.add_argument("--verbose", action="store_true", help="say what failed")
    for flag in ("--merge-install", "--continue-on-error", "--allow-overriding"):
        build.add_argument(flag, action="store_true", help="without an effect")
    return parser


def _chosen(arguments: argparse.Namespace) -> list[Package]:
    """Return the packages that are meant, those that others need first."""
    found: dict[str, Package] = {}
    for package in packages_below(arguments.base_paths):
        if package.name in found:
            both = f"{found[package.name].folder} and {package.folder}"
            raise Ros2Error(f"two packages are called '{package.name}': {both}")
        found[package.name] = package
    named = (arguments.packages_select, arguments.packages_up_to, arguments.packages_skip)
    for name in (name for names in named[:2] for name in names if name not in found):
        raise Ros2Error(f"there is no package '{name}'; {nearest(name, found)}")
    graph = {name: package.depends & found.keys() for name, package in found.items()}
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        raise Ros2Error(f"packages need each other: {' -> '.join(error.args[1])}") from error
    wanted = set(arguments.packages_up_to)
    for name in reversed(order):
        wanted |= graph[name] if name in wanted else set()
    wanted |= set(arguments.packages_select)
    kept = (name for name in order if name in wanted or not any(named[:2]))
    return [found[name] for name in kept if name not in named[2]]


def _build_all(packages: list[Package], arguments: argparse.Namespace) -> int:
    began, failed = time.monotonic(), []
    install = arguments.install_base.resolve()
    for package in packages:
        start = time.monotonic()
        print(f"Starting >>> {package.name}", flush=True)
        try:
            _build(package, install / package.name, arguments)
        except ArjunaError as error:
            failed.append(package.name)
            print(f"--- stderr: {package.name}\n{error}\n---", file=sys.stderr)
            print(f"Failed   <<< {package.name} [{time.monotonic() - start:.2f}s]")
            continue
        print(f"Finished <<< {package.name} [{time.monotonic() - start:.2f}s]", flush=True)
    _write_setup(install)
    count, plural = len(packages) - len(failed), "s" if len(packages) - len(failed) != 1 else ""
    print(f"\nSummary: {count} package{plural} finished [{time.monotonic() - began:.2f}s]")
    if failed:
        print(f"  {len(failed)} package{'s' if len(failed) > 1 else ''} failed: {' '.join(failed)}")
    return 1 if failed else 0


def _build(package: Package, prefix: Path, arguments: argparse.Namespace) -> None:
    if prefix.exists():
        shutil.rmtree(prefix)
    linked, share = arguments.symlink_install, prefix / "share" / package.name
    problems: list[str] = []
    if package.kind in ("ament_python", "python"):
        _python(package, prefix, arguments.build_base.resolve() / package.name, linked)
    elif package.kind == "catkin":
        _catkin(package, prefix)
    elif (package.folder / "CMakeLists.txt").is_file():
        problems = _cmake(package, prefix, linked)
    else:
        raise Ros2Error(f"{package.name} is of the type '{package.kind}', which is not built here")
    if not (share / "package.xml").exists() and (package.folder / "package.xml").is_file():
        put(package.folder / "package.xml", share / "package.xml", linked)
    marker = prefix / "share" / "ament_index" / "resource_index" / "packages" / package.name
    marker.parent.mkdir(parents=True, exist_ok=True)
    marker.touch()
    if problems:
        raise Ros2Error("\n".join(problems))


def put(source: Path, target: Path, linked: bool) -> None:
    """Copy or link a file or folder, in place of what is there."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if target.is_dir() and not target.is_symlink():
        shutil.rmtree(target)
    else:
        target.unlink(missing_ok=True)
    if linked:
        target.symlink_to(source.resolve())
    elif source.is_dir():
        shutil.copytree(source, target)
    else:
        shutil.copy2(source, target)


def _python(package: Package, prefix: Path, build: Path, linked: bool) -> None:
    if not (package.folder / "setup.py").is_file():
        raise Ros2Error(f"{package.folder} has no setup.py; 'ros2 pkg create' writes one")
    build.mkdir(parents=True, exist_ok=True)
    words = [package.name, str(prefix), str(build), str(int(linked)), SITE]
    done = subprocess.run(  # noqa: S603 - ours
        [sys.executable, "-m", "bringup.ros2.workspace.setup_py", *words],
        cwd=package.folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    if done.returncode:
        raise Ros2Error(f"setup.py of {package.name} failed:\n{done.stdout.strip()[-400:]}")


def _catkin(package: Package, prefix: Path) -> None:
    """Link to a package of ROS 1, as its `devel` does: all that is in it, its programs too."""
    put(package.folder, prefix / "share" / package.name, True)
    for path in sorted(package.folder.rglob("*")):
        if path.is_file() and os.access(path, os.X_OK):
            put(path, prefix / "lib" / package.name / path.name, True)


def _cmake(package: Package, prefix: Path, linked: bool) -> list[str]:
    """Install what a CMakeLists.txt installs; return what could not be, a line each."""
    found = read_cmake(package.folder, package.name, SITE)
    if found.is_interfaces:
        from rosidl_build.environment import build
        from rosidl_build.generate import find_prefix

        try:
            build(package.folder)
        except (ValueError, OSError) as error:
            raise Ros2Error(f"interfaces of {package.name}: {error}") from error
        built = Path("share", package.name)
        put(find_prefix() / built, prefix / built, False)
    for name, folder in found.modules.items():
        put(folder, prefix / SITE / name, linked)
    for source, target, is_program in found.items:
        put(source, prefix / target, linked)
        if is_program:
            (prefix / target).resolve().chmod(0o755)
    if found.hooks:
        hook = prefix / "share" / package.name / "environment" / "hooks.dsv"
        hook.parent.mkdir(parents=True, exist_ok=True)
        hook.write_text("".join(f"prepend-non-duplicate;{n};{path}\n" for n, path in found.hooks))
    problems = [f"install() of {package.name}: there is no {path}" for path in found.missing]
    if found.compiled:
        problems.append(f"{package.name}: {', '.join(found.compiled)} is C++, not built; {_REMEDY}")
    return problems


_SETUP = """# Puts the packages of this workspace before those of its environment.
_prepend() {{ eval "case :\\$$1: in *:$2:*) ;; *) export $1=$2\\${{$1:+:\\$$1}} ;; esac"; }}
_append() {{ eval "case :\\$$1: in *:$2:*) ;; *) export $1=\\${{$1:+\\$$1:}}$2 ;; esac"; }}
for _package in "{0}"/*/share/ament_index/resource_index/packages; do
  _prefix="${{_package%/share/ament_index/resource_index/packages}}"
  _prepend AMENT_PREFIX_PATH "$_prefix"
  _prepend COLCON_PREFIX_PATH "{0}"
  [ -d "$_prefix/{1}" ] && _prepend PYTHONPATH "$_prefix/{1}"
  [ -d "$_prefix/bin" ] && _prepend PATH "$_prefix/bin"
done
{3}_prepend PATH "{2}"
_append AMENT_PREFIX_PATH "{4}"
_append AMENT_PREFIX_PATH "{5}"
unset _package _prefix
unset -f _prepend _append
"""


def _write_setup(install: Path) -> None:
    install.mkdir(parents=True, exist_ok=True)
    (install / "COLCON_IGNORE").touch()
    hooks = ""
    for path in sorted(install.glob("*/share/*/environment/*.dsv")):
        for line in read_text(path).splitlines():
            _, name, folder = line.split(";")
            hooks += f'_prepend {name} "{path.parents[3] / folder}"\n'
    programs = Path(sys.executable).parent
    text = _SETUP.format(install, SITE, programs, hooks, prefix_folder(), sys.prefix)
    for name in ("setup", "local_setup"):
        for shell in ("sh", "bash", "zsh"):
            (install / f"{name}.{shell}").write_text(text, encoding="utf-8")
