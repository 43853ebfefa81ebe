"""Contexts of rclpy: what they set up where the environment says nothing."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from pathlib import Path

import pytest
from nav2_msgs.action import Wait

from arjuna_core.ros.context import class_of, discovery, new_context
from arjuna_core.ros.process import Process

_SEGMENT = 4 << 20  # [bytes] what the profile asks for
_NODE = """
import glob, os
from rclpy.node import Node
from arjuna_core.ros.context import class_of, discovery, new_context

context = new_context()
node = Node("one", context=context)
mine = [line.split()[-1] for line in open("/proc/self/maps") if "/dev/shm/fastrtps_" in line]
print(max(os.path.getsize(path) for path in mine))
node.destroy_node()
context.shutdown()
"""


def test_shared_memory_holds_pictures() -> None:
    environment = {
        name: value for name, value in os.environ.items() if not name.startswith("FASTRTPS")
    }
    done = subprocess.run(
        [sys.executable, "-c", _NODE], env=environment, capture_output=True, text=True, timeout=60
    )
    assert done.stderr == ""
    assert int(done.stdout) >= _SEGMENT


@pytest.mark.parametrize("own", [None, "mine.xml"])
def test_environment_comes_first(
    own: str | None, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    name = "FASTRTPS_DEFAULT_PROFILES_FILE"
    monkeypatch.delenv(name, raising=False)
    if own is not None:
        monkeypatch.setenv(name, str(tmp_path / own))
    new_context().shutdown()
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "OFF"
    assert Path(os.environ[name]).name == (own or "fastdds.xml")


@pytest.mark.parametrize(
    ("before", "isolated", "within"),
    [(None, False, "LOCALHOST"), ("SUBNET", False, "SUBNET"), ("SUBNET", True, "OFF")],
)
def test_discovery_range_holds_for_what_is_made_within(
    before: str | None, isolated: bool, within: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    monkeypatch.delenv(name, raising=False)
    if before:
        monkeypatch.setenv(name, before)
    with discovery(isolated):
        assert os.environ[name] == within
    assert os.environ.get(name) == before


def test_an_isolated_process_holds_no_port_of_the_domain(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "99")
    process = Process("alone", isolated=True)
    try:
        assert process.context.get_domain_id() != 99
        assert os.environ["ROS_DOMAIN_ID"] == "99"
    finally:
        process.close()


def test_a_collection_of_garbage_is_rare_and_still_comes() -> None:
    context = new_context(231)
    context.shutdown()
    assert gc.isenabled()
    assert gc.get_threshold()[0] >= 10_000


def test_interfaces_are_found_by_name() -> None:
    assert class_of("nav2_msgs/action/Wait") is Wait
    assert class_of("nav2_msgs/action/Wait_FeedbackMessage") is Wait.Impl.FeedbackMessage
    with pytest.raises(LookupError, match="is no type; valid: package/msg/Name"):
        class_of("nav2_msgs")
    with pytest.raises(LookupError, match="is not installed"):
        class_of("nav2_msgs/msg/None_")
