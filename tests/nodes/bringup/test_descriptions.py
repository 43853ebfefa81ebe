"""Every parameter that `ros2 param describe` shows says what it is."""

from __future__ import annotations

import re

import pytest

from bringup.processes.host import Host
from bringup.stack import DEMO_GROUPS, Group

MEASURES = re.compile(
    r"(_time|_timeout|_duration|_distance|_radius|_frequency|_rate|_angle|_vel|_velocity|_period)$"
)


@pytest.mark.parametrize("group", DEMO_GROUPS, ids=lambda group: group.name)
def test_every_parameter_is_described(group: Group, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "OFF")
    host = Host(group, {})
    described, bare = {}, []
    for node in (*host.nodes, host.manager, host.process.node):
        for name, parameter in node.get_parameters_by_prefix("").items():
            text = described[f"{node.get_name()}.{name}"] = node.describe_parameter(
                name
            ).description
            if MEASURES.search(name) and isinstance(parameter.value, float) and "[" not in text:
                bare.append(f"{node.get_name()}.{name}")
    host.stop()
    host.run()
    assert len(described) > len(host.nodes)
    assert [name for name, text in described.items() if not text.strip()] == []
    assert bare == []
