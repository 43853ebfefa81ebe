"""One process of the interactive stack: a group of nodes under one executor."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import time
from collections.abc import Callable, Sequence

from arjuna_core.config import load
from arjuna_core.errors import ArjunaError
from arjuna_core.ros.process import POLL, Process
from bringup.parameters.files import SAFETY, Parameters, for_node, sim_time_of
from bringup.processes.lifecycle.manager import LifecycleManager
from bringup.processes.reporter import Reporter, Twins
from bringup.processes.supervisor import QUIT_EXIT, USAGE_EXIT
from bringup.stack import ALL_GROUPS, NAV2_PROGRAMS, PROGRAMS, Group, program_group, with_further
from bringup.terminal import show


class Host:
    """A group's nodes and their lifecycle manager in one process; `write` takes its events.

    Without a clock the nodes start after a patience [s] all the same.

    Raises:
        ConfigError: A parameter is not valid.
    """

    def __init__(
        self,
        group: Group,
        parameters: Parameters,
        namespace: str = "",
        write: Callable[[str], None] = lambda line: None,
        clock_patience: float = 1.0,
    ) -> None:
        group = with_further(group, parameters)
        specs = group.nodes
        use_sim_time = sim_time_of(parameters, [spec.name for spec in specs])
        self.process = Process(f"{group.name}_host", use_sim_time, namespace=namespace)
        self.nodes = [spec.make(self.process, for_node(parameters, spec.name)) for spec in specs]
        self._paced = [node for node in self.nodes if hasattr(node, "realtime_due")]
        self.process.remarks = tuple(parameters.get(SAFETY, {}).get(group.name, ()))
        for line in self.process.remarks:
            self.process.node.get_logger().warning(line)
        self._start_at = time.monotonic() + clock_patience
        self._reporter = Reporter(self.process, self.nodes, write)
        names = [node.get_fully_qualified_name() for node in self.nodes]
        self._twins = Twins(self.process.node, names)
        self.manager = LifecycleManager(
            self.process,
            group.manager,
            [spec.name for spec in specs],
            load(LifecycleManager.Config, for_node(parameters, group.manager), group.manager),
            commandable=group.commandable,
            ready=self._may_start,
            on_wait=self._reporter.wait_for,
        )
        self._stopping = self.quit = False

    def stop(self, number: int = 0, frame: object = None) -> None:
        """Make `run` end; a signal handler."""
        self._stopping = True

    def stop_on_signals(self) -> None:
        """Let SIGINT and SIGTERM end `run`, from now on."""
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self.stop)

    def run(self, done: Callable[[], bool] = lambda: False) -> None:
        """Spin until done, stopped or orphaned, then take the nodes down in order."""
        parent = os.getppid()
        while not self._stopping and not done() and os.getppid() == parent:
            self._spin_once()
            if any(node.quitting for node in self._paced):
                self.quit = True
                self._linger()
                break
        self._shut_down()

    def run_until_done(self, timeout: float, patience: float = 2.5) -> bool:
        """Run until the first node's end, `done`, or a timeout [s]; return whether it came to it.

        What the node still `waits_for` after a patience [s] is said.
        """
        node, start, warned = self.nodes[0], time.monotonic(), False

        def ended() -> bool:
            nonlocal warned
            passed = time.monotonic() - start
            if not warned and node.active and passed >= patience:
                warned = True
                if node.waits_for:
                    node.get_logger().warning(node.waits_for)
            return bool(node.done) or passed >= timeout

        self.run(ended)
        return bool(node.done)

    def _linger(self, duration: float = 1.0) -> None:
        """Stay until the answer has reached who asked to quit: it goes with its writer."""
        end = time.monotonic() + duration
        while time.monotonic() < end:
            self.process.spin_once(POLL)

    def _spin_once(self) -> None:
        """Run what waits; a simulator's tick is due by the wall clock, not by an event."""
        wait = POLL
        self._reporter.update(time.monotonic())
        self._twins.look(time.monotonic())
        for node in self._paced:
            due = node.realtime_due(time.monotonic()) if node.active else POLL
            if due <= 0.0:
                node.tick()
                self.process.drain()
                wait = 0.0
            wait = min(wait, due)
        if wait > 0.0:
            self.process.spin(wait)

    def _may_start(self) -> bool:
        """Return whether time is known, so that what nodes latch has a stamp, or does not come."""
        has_time = self.process.now > 0.0 or bool(self._paced) or not self.process.use_sim_time
        return has_time or time.monotonic() >= self._start_at

    def _shut_down(self) -> None:
        """Let all rest first: what still works hard would hold up every step.

        What comes from elsewhere meanwhile is not waited for: it may never end.
        """
        call = self.process.guard.call
        for node in reversed(self.nodes):
            if node.active:
                call(node, "the end", node.trigger_deactivate)
        self.process.run_waiting()
        for node in reversed(self.nodes):
            call(node, "the end", node.trigger_shutdown)
        self.process.run_waiting()
        self.manager.destroy_node()
        self._reporter.close()
        self.process.close()


def main(argv: Sequence[str] | None = None) -> int:
    """Run a group of nodes.

    Returns:
        0 after a clean stop, 2 where an input is refused, 3 where a client asked to quit.
    """
    groups = {group.name: group for group in ALL_GROUPS}
    programs = {"/".join(names): spec for names, spec in {**PROGRAMS, **NAV2_PROGRAMS}.items()}
    parser = argparse.ArgumentParser(
        prog="python -m bringup.host", description=__doc__, fromfile_prefix_chars="@"
    )
    parser.add_argument("group", choices=sorted([*groups, *programs]), metavar="GROUP")
    parser.add_argument("--namespace", default="", help="the robot's")
    parser.add_argument("--domain-id", help="of ROS ($ROS_DOMAIN_ID)")
    parser.add_argument("--parameters", type=json.loads, default={}, help="JSON: node: name: value")
    parser.add_argument("--alone", action="store_true", help="no supervisor reads its events")
    arguments, _ = parser.parse_known_args(argv)  # what follows --ros-args is rclpy's
    if arguments.domain_id is not None:
        os.environ["ROS_DOMAIN_ID"] = arguments.domain_id
    report = (lambda line: None) if arguments.alone else show
    try:
        group = groups.get(arguments.group)
        if group is None:  # a program's node is the one that has parameters
            group = program_group(programs[arguments.group], next(iter(arguments.parameters)))
        host = Host(group, arguments.parameters, arguments.namespace, report)
    except ArjunaError as error:
        sys.stderr.write(f"error: {error}\n")
        return USAGE_EXIT
    host.stop_on_signals()
    host.run()
    return QUIT_EXIT if host.quit else 0
