"""A file with a keepout zone and its servers, as Nav2's tutorial has them: the zone is kept."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from action_msgs.msg import GoalStatus

from arjuna_core.files.maps import save_map
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2
from tests.foreign.nav2.test_system import User
from tests.foreign.nav2.waffle import START, in_its_world
from tests.helpers.nav.stock_files import nav2_file

pytestmark = [pytest.mark.ros, pytest.mark.system]
GOAL = SE2(-2.0, 0.9, 1.57)
ZONE = (-2.6, -1.65, 0.1, 0.4)
"""Least and greatest x, then y [m]: across the shortest path, with room on its right."""
ERR = 0.03  # what localization errs, and half a cell: the robot passes along the zone's edge [m]


def with_zone(folder: Path) -> str:
    """Return Nav2's file with a keepout filter in both costmaps, and the servers of its mask."""
    frame = GridFrame(0.05, 120, 120, SE2(-3.0, -3.0, 0.0))
    rows, columns = np.indices(frame.shape)
    x, y = -3.0 + 0.05 * (columns + 0.5), -3.0 + 0.05 * (rows + 0.5)
    inside = (x > ZONE[0]) & (x < ZONE[1]) & (y > ZONE[2]) & (y < ZONE[3])
    mask, _ = save_map(OccupancyGrid(frame, np.where(inside, 100, 0).astype(np.int8)), folder / "m")
    document: dict[str, Any] = yaml.safe_load(nav2_file())
    for name in ("local_costmap", "global_costmap"):
        values = document[name][name]["ros__parameters"]
        values["filters"] = ["keepout_filter"]
        values["keepout_filter"] = {
            "plugin": "nav2_costmap_2d::KeepoutFilter",
            "enabled": True,
            "filter_info_topic": "/costmap_filter_info",
        }
    info = {"type": 0, "filter_info_topic": "/costmap_filter_info", "mask_topic": "/filter_mask"}
    served = {"topic_name": "/filter_mask", "yaml_filename": str(mask)}
    document["costmap_filter_info_server"] = {"ros__parameters": info}
    document["filter_mask_server"] = {"ros__parameters": served}
    return yaml.safe_dump(document)


@pytest.mark.parametrize("kept", [False, True])
def test_a_zone_is_gone_round(kept: bool, tmp_path: Path) -> None:
    text = with_zone(tmp_path) if kept else nav2_file()
    with closing(in_its_world(tmp_path, text)) as robot:
        user = User(robot)
        user.say_where(START)
        inside: list[SE2] = []

        def watch() -> None:
            x, y = user.truth.x, user.truth.y
            if ZONE[0] + ERR < x < ZONE[1] - ERR and ZONE[2] + ERR < y < ZONE[3] - ERR:
                inside.append(user.truth)

        robot.on_tick = watch
        assert user.end(user.to_pose(GOAL))[0] == GoalStatus.STATUS_SUCCEEDED
        assert bool(inside) != kept
