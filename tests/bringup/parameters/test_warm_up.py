"""What processes are forked from: everything they stand on is there, and no thread is."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS here")

from tests.helpers.processes import Lines

pytestmark = pytest.mark.ros
SOURCE = """
import os, sys
os.environ["OPENBLAS_NUM_THREADS"] = "1"
from bringup.stack import ALL_GROUPS
from bringup.processes.fork import can_fork, warm_up
from bringup.stack import MESSAGES

warm_up(ALL_GROUPS)
cores = [core for group in ALL_GROUPS for core in group.cores]
print("missing:", [name for name in (*MESSAGES, *cores) if name not in sys.modules])
print("rclpy:", "rclpy" in sys.modules, "can fork:", can_fork())
print("groups without:", [group.name for group in ALL_GROUPS if not group.cores])
"""


def test_every_group_is_warmed_up_without_rclpy_and_its_threads() -> None:
    with Lines("-c", SOURCE) as lines:
        assert lines.read_to_end() == 0
        assert lines.seen == [
            "missing: []",
            "rclpy: False can fork: True",
            "groups without: ['explorer']",  # which runs in its command's own process
        ]
