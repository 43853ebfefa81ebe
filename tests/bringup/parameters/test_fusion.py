"""The topics that connect a file's filters of robot_localization."""

from __future__ import annotations

from typing import Any

import pytest

from bringup.parameters.files import Parameters, merged, shipped_parameters
from bringup.parameters.fusion import between_filters

pytestmark = pytest.mark.ros
MASK = [True] * 15


def _filter(world: str, **values: Any) -> dict[str, Any]:
    return {"world_frame": world, "odom0": "odom", "odom0_config": MASK, **values}


def found(sections: Parameters) -> Parameters:
    return between_filters(merged(shipped_parameters(), sections))


def test_conversion_of_gps_takes_the_filter_in_map() -> None:
    both = {"ekf_odom": _filter("odom"), "ekf_map": _filter("map"), "navsat_transform": {}}
    topics = {name: values.get("odom_topic") for name, values in found(both).items()}
    assert topics.pop("sim") is None
    assert topics == {
        "ekf_odom": "odometry/local",
        "ekf_map": "odometry/global",
        "navsat_transform": "odometry/global",
    }


@pytest.mark.parametrize(
    "sections",
    [
        {},
        {"ekf_map": _filter("map"), "navsat_transform": {}},
        {"ekf_filter_node": _filter("odom", odom0="/wheel_odom")},
        {"sim": {"wheel_odometry": "raw"}, "ekf_filter_node": _filter("odom")},
    ],
)
def test_what_is_connected_already_is_left(sections: Parameters) -> None:
    assert found(sections) == {}


def test_topics_that_the_file_gives_hold() -> None:
    sections = {"a": _filter("odom", odom_topic="mine"), "b": _filter("map")}
    assert found(sections) == {
        "b": {"odom_topic": "odometry/global"},
        "sim": {"wheel_odometry": ""},
    }
