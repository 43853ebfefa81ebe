"""Watches a running robot: a table of its nodes each time it is asked."""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import Log

from bringup.client.graph import endpoints, lifecycle_states, nodes
from bringup.client.session import Session
from bringup.doctor.machine import host_processes
from bringup.doctor.observer import LOG, Counter
from bringup.doctor.table import Row, cpu_shares, main_topic, rows
from bringup.ros2.discovery import discover


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

    def rows(self, period: float) -> list[Row]:
        """Watch for a period [s] and return a row for each node."""
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
        rates = {topic: count / passed for topic, count in self._counter.counts().items()}
        shares = cpu_shares(before, host_processes(), passed)
        states = lifecycle_states(session, 1.0)
        return rows(names, states, shares, topics, rates, self._warnings)
