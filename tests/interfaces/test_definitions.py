"""The definition files, read as text: the expected set, and constants that clients rely on."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2] / "arjuna_interfaces"
HASHES = Path(__file__).with_name("type_hashes.json")
OUR_OWN = {"arjuna_interfaces/msg/LocalizationQuality"}
WITHOUT_HASHES = tuple(
    f"{package}/"
    for package in (
        *("example_interfaces", "composition_interfaces"),
        *("ackermann_msgs", "control_msgs", "rosbag2_interfaces", "vision_msgs"),
        *("controller_manager_msgs", "gazebo_msgs", "irobot_create_msgs", "ros_gz_interfaces"),
        "turtlesim",
    )
)
"""The packages whose hashes of a release we have not."""
FILES = sorted(
    path for kind in ("msg", "srv", "action") for path in ROOT.glob(f"*/{kind}/*.{kind}")
)


def parts(name: str) -> list[dict[str, str]]:
    """Return the constants of each part of a definition."""
    path = ROOT / f"{name}.{name.split('/')[1]}"
    pattern = re.compile(r"^\w+ ([A-Z][A-Z0-9_]*) ?= ?(\S+)", re.MULTILINE)
    return [dict(pattern.findall(part)) for part in path.read_text().split("---\n")]


def test_definitions_are_the_expected_types() -> None:
    found = {str(path.relative_to(ROOT).with_suffix("")) for path in FILES}
    found = {name for name in found if not name.startswith(WITHOUT_HASHES)}
    assert found == set(json.loads(HASHES.read_text())) | OUR_OWN


def test_folder_does_not_shadow_the_generated_package() -> None:
    # The generated package arjuna_interfaces has the name of the folder it is defined in.
    assert not (ROOT / "__init__.py").exists()


def test_definitions_say_what_they_are_for_and_name_no_constant_twice() -> None:
    # rosidl_parser 4.6.6 puts the second of two equal constants, comment included, into the
    # part of the first, and the generated C does not compile.
    for path in FILES:
        text = path.read_text(encoding="ascii")
        assert text.startswith("# "), path
        assert text.endswith("\n"), path
        lines = [line for line in text.splitlines() if re.match(r"\w+ [A-Z0-9_]+ ?=", line)]
        assert len(lines) == len(set(lines)), path


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (
            "nav2_msgs/srv/ManageLifecycleNodes",
            "STARTUP PAUSE RESUME RESET SHUTDOWN CONFIGURE CLEANUP",
        ),
        (
            "slam_toolbox/srv/DeserializePoseGraph",
            "UNSET START_AT_FIRST_NODE START_AT_GIVEN_POSE LOCALIZE_AT_POSE",
        ),
        (
            "simulation_interfaces/msg/Result",
            "RESULT_FEATURE_UNSUPPORTED RESULT_OK RESULT_NOT_FOUND RESULT_INCORRECT_STATE"
            " RESULT_OPERATION_FAILED",
        ),
    ],
)
def test_commands_and_results_count_from_zero(name: str, expected: str) -> None:
    assert parts(name)[0] == {key: str(value) for value, key in enumerate(expected.split())}


@pytest.mark.parametrize(
    ("action", "first"),
    [
        ("FollowPath", 100),
        ("ComputePathToPose", 200),
        ("ComputePathThroughPoses", 300),
        ("SmoothPath", 500),
        ("FollowWaypoints", 600),
        ("FollowGPSWaypoints", 600),
        ("Spin", 700),
        ("BackUp", 710),
        ("DriveOnHeading", 720),
        ("AssistedTeleop", 730),
    ],
)
def test_error_codes_of_an_action_are_its_block_of_numbers(action: str, first: int) -> None:
    codes = parts(f"nav2_msgs/action/{action}")[1]
    values = [int(value) for value in codes.values()]
    assert codes["NONE"] == "0"
    assert codes["UNKNOWN"] == str(first)
    assert values[1:] == list(range(first, first + len(values) - 1))


def test_back_up_and_drive_on_heading_order_their_last_codes_differently() -> None:
    back_up = parts("nav2_msgs/action/BackUp")[1]
    drive = parts("nav2_msgs/action/DriveOnHeading")[1]
    assert (back_up["INVALID_INPUT"], back_up["COLLISION_AHEAD"]) == ("713", "714")
    assert (drive["COLLISION_AHEAD"], drive["INVALID_INPUT"]) == ("723", "724")
