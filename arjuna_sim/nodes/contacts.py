"""The topic `ground_truth/contacts`: what the robot touches, and how often it has."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_core.timing import Periodic
from arjuna_sim.nodes.messages import WORLD
from arjuna_sim.physics.contacts import ContactLog

TOPIC = "ground_truth/contacts"
_PERIOD = 1.0  # [s] of simulated time, where nothing changes


class ContactTopic:
    """Publishes a DiagnosticArray with one status when contacts change, and once a second.

    Its level is WARN while the robot touches something beside the ground, else OK; its message
    names what; its values are `count`, the contacts that began since the start, and the count of
    each thing by its name.

    Args:
        node: The node, being configured.
        robot: The robot's name.
    """

    def __init__(self, node: ManagedNode, robot: str) -> None:
        self._robot = robot
        self._out = node.publisher(DiagnosticArray, TOPIC, qos.LATCHED)
        self._due = Periodic(_PERIOD, phase=_PERIOD)
        self.log = ContactLog()

    def update(self, touched: tuple[str, ...], now: float) -> None:
        """Count what the robot touches at a time [s], and publish what is due."""
        changed = self.log.update(touched)
        if self._due.due(now) or changed:
            self._out.publish(contacts_msg(self.log, self._robot, now))


def contacts_msg(log: ContactLog, robot: str, now: float) -> DiagnosticArray:
    """Return counted contacts at a time [s] as a DiagnosticArray message."""
    level = DiagnosticStatus.WARN if log.touched else DiagnosticStatus.OK
    status = DiagnosticStatus(
        level=level,
        name=f"{robot}: contacts",
        message=", ".join(log.touched),
        hardware_id=robot,
        values=[
            KeyValue(key="count", value=str(log.total)),
            *(KeyValue(key=name, value=str(log.counts[name])) for name in sorted(log.counts)),
        ],
    )
    return DiagnosticArray(header=header(WORLD, now), status=[status])
