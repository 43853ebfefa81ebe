"""Tasks that fill a status each, and what publishes them once a period."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.node import Node

OK, WARN, ERROR, STALE = (
    getattr(DiagnosticStatus, name) for name in ("OK", "WARN", "ERROR", "STALE")
)


class DiagnosticStatusWrapper(DiagnosticStatus):
    """A status with what fills it."""

    def summary(self, *args: Any) -> None:
        """Set level and message: of another status, or both."""
        self.level, self.message = _level_and_message(args)

    def clearSummary(self) -> None:
        """Set the level to OK and the message to nothing."""
        self.summary(OK, "")

    def mergeSummary(self, *args: Any) -> None:
        """Take the worse level in; messages of levels of one kind, OK or not, are joined."""
        level, message = _level_and_message(args)
        if (level > OK) == (self.level > OK):
            self.message = "; ".join(filter(None, (self.message, message)))
        elif level > self.level:
            self.message = message
        self.level = max(self.level, level)

    def add(self, key: str, val: Any) -> None:
        self.values.append(KeyValue(key=key, value=str(val)))


def _level_and_message(args: tuple[Any, ...]) -> tuple[bytes, str]:
    if len(args) == 1:
        return args[0].level, args[0].message
    level, message = args
    return (bytes((level,)) if isinstance(level, int) else level), str(message)


class DiagnosticTask:
    """Fills a status; a subclass has `run`."""

    def __init__(self, name: str) -> None:
        self.name = name

    def getName(self) -> str:
        return self.name

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        return stat


class FunctionDiagnosticTask(DiagnosticTask):
    """A function that fills a status."""

    def __init__(self, name: str, fn: Callable[[Any], Any]) -> None:
        super().__init__(name)
        self.fn = fn

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        filled: DiagnosticStatusWrapper = self.fn(stat)
        return filled


class CompositeDiagnosticTask(DiagnosticTask):
    """Several tasks that fill one status, which is as bad as the worst of them."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.tasks: list[DiagnosticTask] = []

    def addTask(self, t: DiagnosticTask) -> None:
        self.tasks.append(t)

    def run(self, stat: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        before, combined = DiagnosticStatusWrapper(), DiagnosticStatusWrapper()
        before.summary(stat)
        for task in self.tasks:
            stat.summary(before)
            stat = task.run(stat)
            combined.mergeSummary(stat)
        stat.summary(combined)
        return stat


class Updater:
    """Runs a node's tasks once a period [s] and publishes their statuses.

    The parameter `diagnostic_updater.period` changes it, `diagnostic_updater.use_fqn` puts the
    node's namespace into the names.
    """

    def __init__(self, node: Node, period: float = 1.0) -> None:
        self.node = node
        self.tasks: list[DiagnosticTask] = []
        self.lock = threading.Lock()
        self.publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 1)
        self.verbose, self.hwid = False, ""
        self.period = float(self._parameter("diagnostic_updater.period", period))
        self.use_fqn = bool(self._parameter("diagnostic_updater.use_fqn", False))
        self.timer = node.create_timer(self.period, self.update)

    def _parameter(self, name: str, default: Any) -> Any:
        if self.node.has_parameter(name):
            return self.node.get_parameter(name).value
        return self.node.declare_parameter(name, default).value

    def setHardwareID(self, hwid: str) -> None:
        """Set what statuses have as their hardware's name."""
        self.hwid = hwid

    def add(self, *args: Any) -> None:
        """Add a task, or a name and a function."""
        task = args[0] if len(args) == 1 else FunctionDiagnosticTask(*args)
        with self.lock:
            self.tasks.append(task)
        stat = DiagnosticStatusWrapper(name=task.getName())
        stat.summary(OK, "Node starting up")
        self.publish(stat)

    def removeByName(self, name: str) -> bool:
        """Remove the first task of a name; return whether there was one."""
        with self.lock:
            found = next((task for task in self.tasks if task.getName() == name), None)
            if found is not None:
                self.tasks.remove(found)
        return found is not None

    def update(self) -> None:
        self.force_update()

    def force_update(self) -> None:
        statuses = []
        with self.lock:
            for task in self.tasks:
                stat = DiagnosticStatusWrapper(name=task.getName(), hardware_id=self.hwid)
                stat.summary(ERROR, "No message was set")
                stat = task.run(stat)
                statuses.append(stat)
                if self.verbose and stat.level != OK:
                    text = f"{stat.name}: level {stat.level[0]}: {stat.message}"
                    self.node.get_logger().warning(text)
        self.publish(statuses)

    def broadcast(self, lvl: Any, msg: str) -> None:
        """Publish one level and message as the status of every task."""
        statuses = []
        for task in self.tasks:
            stat = DiagnosticStatusWrapper(name=task.getName(), hardware_id=self.hwid)
            stat.summary(lvl, msg)
            statuses.append(stat)
        self.publish(statuses)

    def publish(self, msg: Any) -> None:
        """Publish a status or a list of them, the node's name before theirs."""
        statuses = msg if isinstance(msg, list) else [msg]
        own = self.node.get_fully_qualified_name() if self.use_fqn else self.node.get_name()
        found = DiagnosticArray()
        found.header.stamp = self.node.get_clock().now().to_msg()
        for stat in statuses:
            plain = DiagnosticStatus(level=stat.level, name=f"{own.lstrip('/')}: {stat.name}")
            plain.message, plain.hardware_id = stat.message, stat.hardware_id
            plain.values = stat.values
            found.status.append(plain)
        self.publisher.publish(found)
