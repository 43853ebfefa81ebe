"""True motion on the topics that a robot's file names."""

from __future__ import annotations

from pathlib import Path

import pytest
from nav_msgs.msg import Odometry

from arjuna_core.ros import qos
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim
from tests.sim import drive_cases as cases


@pytest.mark.parametrize("topic", ["truth", "ground_truth/odom"])
def test_plugin_of_the_truth_publishes_it(topic: str, bench: RosBench, tmp_path: Path) -> None:
    """Alone, too, where the simulator's own truth would be on its topic."""
    path = cases.mecanum().write(tmp_path)
    tags = "<frame_name>map</frame_name><update_rate>10</update_rate>"
    tags += f"<topic_name>{topic}</topic_name>"
    tag = cases.plugin("libgazebo_ros_p3d.so", f"{tags}<gaussian_noise>0.001</gaussian_noise>")
    path.write_text(path.read_text().replace("</robot>", f"{tag}</robot>"))
    sim = start_sim(bench, robot=str(path))
    heard = bench.collect(Odometry, f"/{topic}", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 50)
    assert len(heard) == 10
    last = heard[-1]
    assert (last.header.frame_id, last.child_frame_id) == ("map", "base")
    assert last.pose.pose.position.z == pytest.approx(0.06, abs=0.01)
    assert last.pose.covariance[0] == pytest.approx(1e-6)
