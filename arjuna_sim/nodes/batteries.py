"""Commands of batteries, as gz-sim's LinearBatteryPlugin takes them: recharging and draining."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from arjuna_core.ros import qos
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.devices.sensors.battery import BatterySettings
from arjuna_sim.driven_robot import DrivenRobot

_Command = Callable[[], None]


def offer_commands(node: ManagedNode, robot: DrivenRobot, battery: BatterySettings) -> None:
    """Offer `recharge/start` and `recharge/stop` below a battery's name, and listen to topics.

    Whatever comes on a topic counts, as with gz-sim; here it is a Bool.
    """

    def set_to(field: str, value: bool) -> _Command:
        return lambda: setattr(robot.device(battery), field, value)

    for word, on in (("start", True), ("stop", False)):
        name, command = f"{battery.base}/recharge/{word}", set_to("charges", on)
        if battery.charging_time > 0.0:
            node.serve(Trigger, name, partial(_answer, command))
            if battery.charged_by_topic:
                _listen(node, name, command)
    for topics, on in ((battery.draining_topics, True), (battery.resting_topics, False)):
        for topic in topics:
            _listen(node, topic, set_to("drains", on))


def _answer(command: _Command, request: Any, response: Any) -> Any:
    command()
    response.success = True
    return response


def _listen(node: ManagedNode, topic: str, command: _Command) -> None:
    node.subscribe(Bool, topic, lambda message: command(), qos.DEFAULT)
