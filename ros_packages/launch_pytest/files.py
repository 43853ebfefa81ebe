"""Files whose generate_test_description is marked as a launch test: a test for each launch."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

MARKS = {"launch_test", "rostest"}


def launch_tests(module_path: Path, parent: Any) -> Any:
    from arjuna_core.files.input_file import head_of

    if b"generate_test_description" not in head_of(module_path, 1_000_000):
        return None
    from launch_testing.runner import load

    try:
        module = load(module_path)
    except Exception:  # noqa: BLE001 - of anyone's file: pytest imports it again, and says what is wrong
        return None
    marks = getattr(module.generate_test_description, "pytestmark", [])
    if not {mark.name for mark in marks} & MARKS:
        return None
    return LaunchTestFile.from_parent(parent, path=module_path, module=module)


class LaunchTestFile(pytest.File):
    """A file of launch tests; each launch is one test."""

    def __init__(self, *, module: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._module = module

    def collect(self) -> Iterator[pytest.Item]:
        from launch_testing.runner import LaunchTest, runs_of

        for given in runs_of(self._module):
            test = LaunchTest(self._module, given)
            yield LaunchTestItem.from_parent(self, name=f"launch{test.name}", test=test)


class LaunchTestFailed(Exception):
    """Tests beside a launch, or behind its end, failed."""


class LaunchTestItem(pytest.Item):
    """One launch with its tests."""

    def __init__(self, *, test: Any, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self._test = test

    def runtest(self) -> None:
        """Run it, in a ROS domain of its own."""
        from launch_testing.launch_test import isolated_domain

        with isolated_domain():
            outcome = self._test.run()
        if not outcome.succeeded:
            raise LaunchTestFailed(outcome.summary())
        if all(case.kind == "skipped" for case in outcome.cases):
            pytest.skip(outcome.cases[0].problem)

    def repr_failure(self, excinfo: Any, style: Any = None) -> Any:
        if isinstance(excinfo.value, LaunchTestFailed):
            return str(excinfo.value)
        return super().repr_failure(excinfo, style)

    def reportinfo(self) -> tuple[Path, int, str]:
        return self.path, 0, f"launch tests: {self.path.name}"
