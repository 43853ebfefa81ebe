"""A sensor is added by docs/extending.md alone."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from pathlib import Path

import pytest
from sensor_msgs.msg import Temperature

from arjuna_core.ros import qos
from arjuna_sim.devices import sensors
from arjuna_sim.devices.sensors import altimeter
from arjuna_sim.model import settings as kinds
from arjuna_sim.nodes import sensor_topics
from tests.helpers.extending import files_of
from tests.helpers.ros import RosBench
from tests.nodes.sim.running import run, start_sim
from tests.sim.robot_cases import RobotMaker

MESSAGE = """
from sensor_msgs.msg import Temperature
from arjuna_sim.devices.sensors.thermometer import ThermometerSettings

@publishes(ThermometerSettings, Temperature)
def _temperature(sensor, reading, now):
    return Temperature(header=header(sensor.frame, now), temperature=reading)
"""


@pytest.fixture
def thermometer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Write the two files that the page names: the altimeter's with other words, and a message."""
    files = files_of("A sensor")
    assert files == [Path(inspect.getfile(module)) for module in (altimeter, sensor_topics)]
    code = files[0].read_text(encoding="utf-8")
    code = code.replace("Altimeter", "Thermometer").replace("altimeter", "thermometer")
    cooler = code.replace("return Climb(", "return 20.0 - 0.0065 * height\n        return Climb(")
    assert cooler != code
    (tmp_path / "thermometer.py").write_text(cooler, encoding="utf-8")
    monkeypatch.setattr(kinds, "_readers", dict(kinds._readers))
    monkeypatch.setattr(sensors, "__path__", [*sensors.__path__, str(tmp_path)])
    kinds.sensor_kinds.cache_clear()
    kinds.sensor_kinds()
    exec(MESSAGE, vars(sensor_topics))
    yield
    kinds.sensor_kinds.cache_clear()


@pytest.mark.usefixtures("thermometer")
def test_a_new_kind_is_read_simulated_and_published(bench: RosBench, tmp_path: Path) -> None:
    maker = RobotMaker(tmp_path)
    maker.add("thermometer", "outside", "<update_rate>10</update_rate>")
    sim = start_sim(bench, robot=str(maker.write(bare=False)))
    received = bench.collect(Temperature, "/thermometer", qos.SENSOR_SUBSCRIPTION)
    run(bench, sim, 10)
    assert [message.temperature for message in received] == pytest.approx([20.0] * 2, abs=0.01)
    assert received[0].header.frame_id == "outside_link"
