"""`launch_test FILE`: the tests of a file beside what it launches, in a ROS domain of their own."""

from __future__ import annotations

import argparse
import os
import socket
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

from bringup.parameters.options import DOMAINS
from launch_testing.runner import Case, LaunchResult, LaunchTest, LaunchTestError, load, runs_of


@contextmanager
def isolated_domain() -> Iterator[int]:
    """Set ROS_DOMAIN_ID to a domain that no other test on this machine has meanwhile.

    Raises:
        LaunchTestError: All are taken.
    """
    before = os.environ.get("ROS_DOMAIN_ID")
    with socket.socket(socket.AF_UNIX) as held:  # its name ends with the process, however that ends
        for number in range(1, DOMAINS + 1):
            try:
                held.bind(f"\0launch_test/{number}")
            except OSError:
                continue
            os.environ["ROS_DOMAIN_ID"] = str(number)
            try:
                yield number
            finally:
                os.environ.pop("ROS_DOMAIN_ID")
                if before is not None:
                    os.environ["ROS_DOMAIN_ID"] = before
            return
    raise LaunchTestError(f"all {DOMAINS} domains are taken by tests; --disable-isolation")


def main(words: list[str] | None = None) -> int:
    """Run a file's tests; return 0 if all pass, 1 if not, 2 for a file that cannot be run."""
    parser = argparse.ArgumentParser(prog="launch_test", description=__doc__)
    parser.add_argument("launch_test_file", type=Path, help="file with generate_test_description")
    parser.add_argument("launch_arguments", nargs="*", help="name:=value")
    parser.add_argument("-v", "--verbose", action="store_true", help="log all of launch")
    parser.add_argument("-s", "--show-args", action="store_true", help="list launch arguments")
    parser.add_argument("-i", "--isolated", action="store_true", help="the default")
    parser.add_argument("--disable-isolation", action="store_true", help="in the caller's domain")
    parser.add_argument("--package-name", default="", help="of the results")
    parser.add_argument("--junit-xml", type=Path, help="file for the results")
    given = parser.parse_args(words)
    if wrong := [word for word in given.launch_arguments if ":=" not in word]:
        parser.error(f"'{wrong[0]}' is no launch argument; valid: NAME:=VALUE")
    pairs = [word.partition(":=") for word in given.launch_arguments]
    path, arguments = given.launch_test_file, {name: value for name, _, value in pairs}
    if not path.is_file():
        parser.error(f"there is no file {path}")
    try:
        if given.show_args:
            return _show(path)
        if given.disable_isolation:
            return _run(path, arguments, given.package_name, given.junit_xml)
        with isolated_domain():
            return _run(path, arguments, given.package_name, given.junit_xml)
    except LaunchTestError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def _show(path: Path) -> int:
    from bringup.ros2.verbs.launch import show

    module = load(path)
    described, _ = LaunchTest(module, runs_of(module)[0]).describe()
    return show(described.get_launch_arguments())


def _run(path: Path, arguments: dict[str, str], package: str, results: Path | None) -> int:
    module = load(path)
    outcomes = [LaunchTest(module, run, arguments, _tell).run() for run in runs_of(module)]
    count = sum(len(one.cases) for one in outcomes)
    succeeded = all(one.succeeded for one in outcomes)
    print(f"{count} tests: {'all passed' if succeeded else 'FAILED'}")
    if results is not None:
        results.parent.mkdir(parents=True, exist_ok=True)
        results.write_bytes(_junit(outcomes, package or path.stem))
    return 0 if succeeded else 1


def _tell(case: Case) -> None:
    print(f"[{case.kind}] {case.name} ({case.duration:.1f} s)", flush=True)
    if case.problem:
        print(case.problem, flush=True)


def _junit(outcomes: list[LaunchResult], package: str) -> bytes:
    """Return results as JUnit's XML, which CI servers read."""
    root = ElementTree.Element("testsuites", name=package)
    for outcome in outcomes:
        kinds = [case.kind for case in outcome.cases]
        counts = {"failures": "failed", "errors": "error", "skipped": "skipped"}
        about = {
            "name": f"{package}.{package}{outcome.name}.launch_tests",
            "tests": str(len(kinds)),
        }
        about |= {key: str(kinds.count(kind)) for key, kind in counts.items()}
        suite = ElementTree.SubElement(root, "testsuite", about)
        for case in outcome.cases:
            where, _, test = case.name.rpartition(".")
            about = {"classname": f"{package}.{where}".rstrip("."), "name": test + outcome.name}
            about["time"] = f"{case.duration:.3f}"
            row = ElementTree.SubElement(suite, "testcase", about)
            tag = {"failed": "failure", "error": "error", "skipped": "skipped"}.get(case.kind)
            if tag is not None:
                lines = case.problem.strip().splitlines() or [""]
                ElementTree.SubElement(row, tag, {"message": lines[-1]}).text = case.problem
    data: bytes = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    return data


if __name__ == "__main__":
    sys.exit(main())
