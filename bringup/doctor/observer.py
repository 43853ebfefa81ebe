"""A running robot observed: its snapshot for the checks, and a table of its nodes."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Iterable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import Log
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock as ClockMsg
from sensor_msgs.msg import LaserScan

from arjuna_core.errors import ArjunaError
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, scan_from_msg, seconds
from arjuna_core.ros.tf import TransformBuffer, TransformError, TransformListener
from bringup.client.endpoint import Endpoint
from bringup.client.frames import FrameListener
from bringup.client.graph import endpoints, lifecycle_states, nodes, on_system_time
from bringup.client.session import Session
from bringup.doctor.checks.rates import LEAST, LEAST_OF_TYPE
from bringup.doctor.machine import host_processes, read_machine
from bringup.doctor.snapshot import Clock, Robot, ScanFacts, Snapshot, scan_facts
from bringup.doctor.table import cpu_shares, main_topic, rows
from bringup.ros2.discovery import discover
from bringup.ros2.types import interface_class

LOG = QoSProfile(depth=1000, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Observer:
    """Listens to a robot."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._transforms = TransformBuffer()
        TransformListener(session.client, self._transforms)
        self._frames = FrameListener(session)
        self._last: dict[str, Any] = {}
        self._log: list[tuple[str, str]] = []
        self._times: list[float] = []
        self._remarks: dict[str, None] = {}
        self._troubles: dict[str, str] = {}
        self._keep(PoseWithCovarianceStamped, "amcl_pose", qos.LATCHED)
        self._keep(OccupancyGridMsg, "map", qos.LATCHED)
        self._keep(LaserScan, "scan", qos.SENSOR_SUBSCRIPTION)
        self._keep(Odometry, "ground_truth/odom", qos.SENSOR_SUBSCRIPTION)
        listen = session.client.create_subscription
        listen(Log, "/rosout", self._on_log, LOG)
        listen(DiagnosticArray, "diagnostics", self._on_diagnostics, qos.DEFAULT)
        listen(ClockMsg, "clock", lambda m: self._times.append(seconds(m.clock)), qos.CLOCK)

    def _keep(self, message_type: Any, topic: str, profile: QoSProfile) -> None:
        self._session.client.create_subscription(
            message_type, topic, lambda message: self._last.update({topic: message}), profile
        )

    def _on_log(self, message: Any) -> None:
        if message.level >= Log.WARN:
            self._log.append((message.name, message.msg))

    def _on_diagnostics(self, message: Any) -> None:
        remarks = (one.message for one in message.status if one.name.endswith(": parameters"))
        self._remarks.update(dict.fromkeys(remarks))
        for one in message.status:
            node, _, about = one.name.partition(": ")
            if about == "messages":
                self._troubles[node] = one.message if one.level == DiagnosticStatus.ERROR else ""

    def snapshot(self, duration: float) -> Snapshot:
        """Listen for a duration [s] after discovery, and return what there is."""
        discover(self._session)
        counter = Counter(self._session)
        namespace = self._session.client.get_namespace()
        for topic in LEAST:
            counter.listen(namespace.rstrip("/") + topic)
        for topic, types in self._session.client.get_topic_names_and_types():
            if LEAST_OF_TYPE.keys() & set(types):
                counter.listen(topic)
        self._session.pause(0.5)  # until new subscriptions get messages
        self._times.clear()
        counter.restart()
        start = self._session.now
        self._session.pause(duration)
        passed = self._session.now - start
        times, counts = self._times[:], dict(counter.counts)
        ends, states = endpoints(self._session), lifecycle_states(self._session, 1.0)
        found = Snapshot(
            machine=read_machine(),
            domain=int(self._session.client.context.get_domain_id()),
            duration=passed,
            nodes=tuple(nodes(self._session)),
            endpoints=ends,
            states=states,
            counts=counts,
            clock=clock_of(times),
            on_system_time=self._on_system_time(ends, states) if times else (),
            frames=self._frames.frames(self._times[-1] if self._times else time.time()),
            robot=self._robot(),
        )
        return found.below(namespace)

    def _on_system_time(self, ends: Iterable[Endpoint], managed: Iterable[str]) -> tuple[str, ...]:
        """Return the nodes that stamp, or are managed, and do not take their time from /clock."""
        names = {*managed, *(end.node for end in ends if end.publishes and is_stamped(end.type))}
        clocks = [end for end in ends if not end.publishes and end.topic.endswith("/clock")]
        names -= {end.node for end in clocks}  # a process listens for its nodes
        return tuple(sorted(on_system_time(self._session, names, 1.0)))

    def _robot(self) -> Robot:
        pose, truth = self._last.get("amcl_pose"), self._last.get("ground_truth/odom")
        grid = grid_from_msg(self._last["map"]) if "map" in self._last else None
        return Robot(
            scan=self._scan(grid),
            map_known=None if grid is None else float(1.0 - grid.unknown().mean()),
            deviation=None if pose is None else math.sqrt(max(pose.pose.covariance[::7][:2])),
            height=None if truth is None else truth.pose.pose.position.z,
            log=tuple(self._log[-5:]),
            remarks=tuple(self._remarks),
            troubles=tuple((node, text) for node, text in self._troubles.items() if text),
        )

    def _scan(self, grid: OccupancyGrid | None) -> ScanFacts | None:
        message = self._last.get("scan")
        if message is None:
            return None
        frame = message.header.frame_id.lstrip("/")
        T_map_sensor = self._transforms.try_lookup("map", frame, seconds(message.header.stamp))
        if T_map_sensor is None:
            T_map_sensor = self._transforms.try_lookup("map", frame)
        try:
            upside_down = self._transforms.upside_down("base_link", frame)
        except TransformError:
            upside_down = False
        return scan_facts(scan_from_msg(message), frame, upside_down, grid, T_map_sensor)


def is_stamped(type_name: str) -> bool:
    """Return whether messages of a type say when they are of; False for a type not installed."""
    try:
        fields = interface_class(type_name).get_fields_and_field_types()
    except ArjunaError:
        return False
    return fields.get("header") == "std_msgs/Header" or type_name == "tf2_msgs/msg/TFMessage"


def clock_of(times: Sequence[float]) -> Clock | None:
    """Return what a series of times of /clock [s] says; None for none."""
    if not times:
        return None
    steps = [after - before for before, after in itertools.pairwise(times)]
    return Clock(sum(step for step in steps if step > 0.0), sum(step < 0.0 for step in steps))


class Counter:
    """Counts the messages on topics from the last restart on."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.counts: dict[str, int] = {}

    def listen(self, topic: str) -> None:
        """Count a topic too, if somebody publishes on it and it is not counted yet."""
        client = self._session.client
        publishers = client.get_publishers_info_by_topic(topic)
        if topic in self.counts or not publishers:
            return

        def count(message: bytes) -> None:
            self.counts[topic] += 1

        self.counts[topic] = 0
        kind = interface_class(publishers[0].topic_type)
        profile = QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
        client.create_subscription(kind, topic, count, profile, raw=True)

    def restart(self) -> None:
        """Start at zero again."""
        self.counts = dict.fromkeys(self.counts, 0)


class Watcher:
    """Listens to a robot."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._counter = Counter(session)
        self._warnings: dict[str, str] = {}
        session.client.create_subscription(Log, "/rosout", self._on_log, LOG)
        discover(session)

    def _on_log(self, message: Any) -> None:
        if message.level >= Log.WARN:
            self._warnings[message.name] = message.msg

    def rows(self, period: float) -> list[tuple[str, ...]]:
        """Watch for a period [s] and return the table's cells for each node."""
        session = self._session
        start = f"{session.client.get_namespace().rstrip('/')}/"
        names = [name for name in nodes(session) if name.startswith(start)]
        ends = endpoints(session)
        topics = {name: main_topic(name, ends) for name in names}
        for topic in filter(None, topics.values()):
            self._counter.listen(topic)
        self._counter.restart()
        domain, begin = session.client.context.get_domain_id(), session.now
        before = [host for host in host_processes() if host.domain == domain]
        session.pause(period)
        passed = session.now - begin
        rates = {topic: count / passed for topic, count in self._counter.counts.items()}
        shares = cpu_shares(before, host_processes(), passed)
        states = lifecycle_states(session, 1.0)
        return rows(names, states, shares, topics, rates, self._warnings)
