"""Shared by the tests of nodes: they need ROS, and each has a process of its own."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from tests.helpers.ros import RosBench

collect_ignore_glob = [] if find_spec("rclpy") else ["*"]
_HERE = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of this folder as those that need ROS."""
    for item in items:
        if _HERE in item.path.parents:
            item.add_marker(pytest.mark.ros)


@pytest.fixture
def own_plugins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with the modules of docs/plugins.md, which can be imported."""
    from tests.helpers.nav.plugins_page import write_modules

    monkeypatch.syspath_prepend(str(tmp_path))
    names = write_modules(tmp_path)
    yield tmp_path
    for name in names:
        sys.modules.pop(name, None)


@pytest.fixture
def bench(request: pytest.FixtureRequest) -> Iterator[RosBench]:
    """A process and a client's node in it, made by the options that the module's BENCH names."""
    from tests.helpers.ros import RosBench

    made = RosBench(**getattr(request.module, "BENCH", {}))
    yield made
    made.close()
