"""The stand-in robot that the commands look at."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.helpers.processes import Lines
from tests.helpers.ros2.commands import Outcome, run_ros2

ENVIRONMENT = {
    "ROS_DOMAIN_ID": str(10 + os.getpid() % 60),
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
}


@pytest.fixture(scope="session")
def stand_in() -> Iterator[None]:
    """Run the stand-in in a domain of its own."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in ENVIRONMENT.items():
            patch.setenv(name, value)
        process = Lines("-m", "tests.helpers.ros2.stand_in")
    with process:
        process.wait_for("ready")
        yield


@pytest.fixture
def ros2(stand_in: None, tmp_path: Path) -> Callable[..., Outcome]:
    """Return what runs a command on the stand-in's graph."""
    return lambda *words: run_ros2(list(words), tmp_path, ENVIRONMENT)
