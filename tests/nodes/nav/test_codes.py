"""The cores' codes are those of Nav2's messages, by name and number."""

from __future__ import annotations

from enum import IntEnum
from types import SimpleNamespace
from typing import Any

import pytest
from nav2_msgs.action import ComputePathToPose, DockRobot, FollowPath, SmoothPath

from arjuna_nav.controllers import ControlStatus
from arjuna_nav.docking.docking import DockingError
from arjuna_nav.planners import PlanStatus
from arjuna_nav.smoothers.smoothers import SmoothStatus
from arjuna_nav.trees.xml_file import NODES


@pytest.mark.parametrize(
    ("codes", "result"),
    [
        (ControlStatus, FollowPath.Result),
        (PlanStatus, ComputePathToPose.Result),
        (SmoothStatus, SmoothPath.Result),
        (DockingError, DockRobot.Result),
    ],
)
def test_a_code_is_nav2s(codes: type[IntEnum], result: Any) -> None:
    for code in codes:
        name = "NONE" if code.value == 0 else code.name
        assert code.value == getattr(result, name), code.name


@pytest.mark.parametrize(
    ("node", "result", "names"),
    [
        (
            "WouldAControllerRecoveryHelp",
            FollowPath.Result,
            ("UNKNOWN", "PATIENCE_EXCEEDED", "FAILED_TO_MAKE_PROGRESS", "NO_VALID_CONTROL"),
        ),
        (
            "WouldASmootherRecoveryHelp",
            SmoothPath.Result,
            ("UNKNOWN", "TIMEOUT", "FAILED_TO_SMOOTH_PATH", "SMOOTHED_PATH_IN_COLLISION"),
        ),
    ],
)
def test_recoveries_follow_nav2s_codes(node: str, result: Any, names: tuple[str, ...]) -> None:
    helps = vars(NODES[node])["ANSWER"]
    found = {code for code in range(1000) if helps(SimpleNamespace(error_code=code))}
    assert found == {getattr(result, name) for name in names}
