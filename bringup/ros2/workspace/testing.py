"""`colcon test` and `colcon test-result`: the tests of packages, by pytest and launch_test.

Each test writes JUnit's XML below `build/PACKAGE`, as colcon's and ament's do.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from xml.etree.ElementTree import Element

from arjuna_core.errors import ArjunaError
from arjuna_core.files.input_file import read_bytes, read_text
from arjuna_core.files.xml_text import parse_xml
from bringup.ros2.errors import Ros2Error
from bringup.ros2.workspace.cmake import Test, read_cmake
from bringup.ros2.workspace.packages import SITE, Package

_LINTERS = re.compile(r"^[ \t]*(?:from|import) (ament_\w+)", re.MULTILINE)
_SOURCED = '[ -f "$0" ] && . "$0"; exec "$@"'


def run_tests(packages: list[Package], arguments: argparse.Namespace) -> int:
    """Run packages' tests; return 1 where they fail and that is asked for."""
    began, failed = time.monotonic(), []
    build, setup = arguments.build_base.resolve(), arguments.install_base.resolve() / "setup.bash"
    for package in packages:
        start = time.monotonic()
        print(f"Starting >>> {package.name}", flush=True)
        wrong = [
            test.name
            for test, result in _tests_of(package, build / package.name)
            if not _run(test, package, result, ["/bin/bash", "-c", _SOURCED, str(setup)], arguments)
        ]
        mark = "\t[ with test failures ]" if wrong else ""
        failed += [package.name] if wrong else []
        print(f"Finished <<< {package.name} [{time.monotonic() - start:.2f}s]{mark}", flush=True)
    plural = "s" if len(packages) != 1 else ""
    print(f"\nSummary: {len(packages)} package{plural} finished [{time.monotonic() - began:.2f}s]")
    if failed:
        have = "s" if len(failed) > 1 else ""
        print(f"  {len(failed)} package{have} had test failures: {' '.join(failed)}")
    return 1 if failed and arguments.return_code_on_test_failure else 0


def _tests_of(package: Package, build: Path) -> Iterator[tuple[Test, Path]]:
    """Yield a package's tests, each with its JUnit file; those that cannot be run are named."""
    if package.kind in ("ament_python", "python"):
        words = [f"--junit-prefix={package.name}"]
        words += [f"--ignore={one}" for one in _without_linters(package)]
        yield Test("pytest", "pytest", words, None, {}), build / "pytest.xml"
        return
    if not (package.folder / "CMakeLists.txt").is_file():
        raise Ros2Error(f"{package.name} is of the type '{package.kind}', which has no tests here")
    found = read_cmake(package.folder, package.name, SITE)
    for name in found.compiled_tests:
        print(f"{package.name}: test '{name}' is C++, and is not run")
    for one in found.tests:
        yield one, build / "test_results" / package.name / f"{one.name}.xunit.xml"


def _command(test: Test, package: str, result: Path, words: list[str]) -> list[str]:
    """Return what runs a test, with the user's words where pytest does."""
    python = [sys.executable, "-m"]
    if test.kind == "pytest":
        options = ["-q", "--tb=short", "-p", "no:cacheprovider", f"--junit-xml={result}"]
        return [*python, "pytest", *options, *test.words, *words]
    if test.kind == "launch":
        named = ["--junit-xml", str(result), "--package-name", package]
        return [*python, "launch_testing.launch_test", *test.words, *named]
    return [*(python[:1] if test.words[0].endswith(".py") else []), *test.words]


def _without_linters(package: Package) -> Iterator[Path]:
    """Yield and name the files of tests that run ament's linters, which are not here."""
    for path in sorted((package.folder / "test").glob("test_*.py")):
        names = set(_LINTERS.findall(read_text(path)))
        if missing := sorted(one for one in names if importlib.util.find_spec(one) is None):
            print(f"{package.name}: {path.name} is left out, for {missing[0]} is not installed")
            yield path.resolve()


def _run(
    test: Test, package: Package, result: Path, shell: list[str], arguments: argparse.Namespace
) -> bool:
    """Return whether a test passes, in the workspace's environment."""
    result.parent.mkdir(parents=True, exist_ok=True)
    result.unlink(missing_ok=True)
    command = _command(test, package.name, result, arguments.pytest_args)
    try:
        done = subprocess.run(  # noqa: S603 - what the user's package names
            [*shell, *command],
            cwd=package.folder,
            env={**os.environ, **test.environment},
            timeout=test.timeout,
            check=False,
        )
    except subprocess.TimeoutExpired:
        print(f"test '{test.name}' did not end within {test.timeout:g} s", file=sys.stderr)
        return False
    return done.returncode in (0, 5 if test.kind == "pytest" else 0)  # 5: it has no tests


def show_results(arguments: argparse.Namespace) -> int:
    """List what tests have written; return 1 where one failed."""
    totals = dict.fromkeys(("tests", "errors", "failures", "skipped"), 0)
    for path in sorted(arguments.test_result_base.rglob("*.xml")):
        try:
            root = parse_xml(path, read_bytes(path, 1 << 27))
            suites = [root, *root] if root.tag == "testsuites" else [root]
            suites = [one for one in suites if one.tag == "testsuite"]
            counts = {key: sum(int(one.get(key) or 0) for one in suites) for key in totals}
        except (ArjunaError, ValueError):
            continue  # no result of tests
        if not suites:
            continue
        totals = {key: totals[key] + count for key, count in counts.items()}
        if arguments.all or counts["errors"] or counts["failures"]:
            print(f"{path}: {_counted(counts)}")
            for suite in suites if arguments.verbose else ():
                _show_failures(suite)
    print(f"\nSummary: {_counted(totals)}")
    return 1 if totals["errors"] or totals["failures"] else 0


def _counted(counts: Mapping[str, int]) -> str:
    words = []
    for key, count in counts.items():
        one = key if key == "skipped" or count != 1 else key[:-1]
        words.append(f"{count} {one}")
    return ", ".join(words)


def _show_failures(suite: Element) -> None:
    for case in suite.iter("testcase"):
        for problem in (*case.findall("failure"), *case.findall("error")):
            print(f"- {case.get('classname')} {case.get('name')}\n  <<< {problem.tag} message")
            lines = (problem.text or problem.get("message") or "").strip().splitlines()
            print("".join(f"    {line}\n" for line in lines) + "  >>>")
