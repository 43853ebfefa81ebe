"""One robot in lock-step under random messages, then made whole and sent to a goal."""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
from numba.core import event
from rclpy.parameter import Parameter
from rclpy.serialization import serialize_message
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import ResetSimulation, SetSimulationState

from arjuna_core.files.shipped import shipped_file
from arjuna_core.se2 import SE2
from bringup.client.goals import Goals
from bringup.lockstep import LockStep
from bringup.parameters.files import merged, shipped_parameters
from bringup.stack import (
    LOCALIZATION_GROUP,
    NAVIGATION_GROUP,
    SIM_GROUP,
    SLAM_GROUP,
    Group,
)
from tests.fuzz.messages import Filler, Target, drawn, filled, found, profile

MESSAGE_TIME_MAX = 1.0
"""How much of a core's time one message may take [s]."""
GOAL = SE2(1.5, 1.0, 0.5)
_TICK_EVERY = 4  # messages
_GARBLED = 0.05  # of the messages on topics
_FOREIGN = 0.03  # of them are messages of another type, or nothing but noise
_WALK_EVERY = 20  # messages a node goes through a transition
_RISE_EVERY = 150  # messages all nodes are active again
_STEPS = {
    "unconfigured": ("configure",),
    "inactive": ("activate", "cleanup"),
    "active": ("deactivate",),
}
STACKS: dict[str, tuple[Group, ...]] = {
    "nav": (LOCALIZATION_GROUP, NAVIGATION_GROUP),
    "slam": (SLAM_GROUP, NAVIGATION_GROUP),
}
_ON_MAP: dict[str, dict[str, Any]] = {
    "map_server": {"yaml_filename": str(shipped_file("maps/arjuna_room.yaml"))},
    "amcl": {"set_initial_pose": True},
}


class Barrage:
    """A robot, and what is sent to it.

    Args:
        stack: A key of STACKS.
        seed: Of everything.
        log: Takes a line for each message before it is sent: what ends the process is the last.
    """

    def __init__(self, stack: str, seed: int, log: Any) -> None:
        values = merged(shipped_parameters(), _ON_MAP, {"sim": {"seed": seed}})
        self.robot = LockStep(values, transport="dds")
        self._groups = STACKS[stack]
        self._rng = np.random.default_rng(seed)
        self._filler = Filler(self._rng)
        self._log = log
        self._publishers: dict[str, Any] = {}
        self._clients: dict[str, Any] = {}
        self.timed_out: list[str] = []
        self.robot.start(SIM_GROUP, *self._groups)
        self.robot.run(1.0)
        self._goals = Goals(self.robot)
        self._kept = {name: self._parameters(node) for name, node in self.robot.nodes.items()}
        self.targets = found(self.robot.client)

    @staticmethod
    def _parameters(node: Any) -> list[Parameter]:
        return list(node.get_parameters(list(node._parameters)))

    def reaches_a_goal(self) -> bool:
        """Drive somewhere."""
        return bool(self._goals.navigate(GOAL, 60.0).succeeded)

    def run(self, count: int) -> None:
        """Send messages, a tick after a few of them."""
        for number in range(count):
            target = drawn(self.targets, self._rng)
            self._filler.now = self.robot.now
            self._timed(target, number)
            if number % _RISE_EVERY == _RISE_EVERY - 1:
                self._rise()
            elif number % _WALK_EVERY == _WALK_EVERY - 1:
                self._walk()

    def _walk(self) -> None:
        """Take a node, but not the simulator, which is the clock, through a transition."""
        names = sorted(set(self.robot.nodes) - {"sim"})
        node = self.robot.nodes[str(self._rng.choice(names))]
        steps = _STEPS.get(node.state_label, ())
        if steps:
            getattr(node, f"trigger_{self._rng.choice(steps)}")()
            self.robot.process.drain()

    def _rise(self) -> None:
        """Take all nodes down and up again, with their own parameters: others may keep one down."""
        self._restore()
        for group in reversed((SIM_GROUP, *self._groups)):
            for spec in reversed(group.nodes):
                self._to_rest(self.robot.nodes[spec.name])
        self.robot.start(SIM_GROUP, *self._groups)

    def _timed(self, target: Target, number: int) -> None:
        print(json.dumps({"number": number, "target": target.name}), file=self._log, flush=True)
        data = self._made(target)
        compiled: list[float] = []
        with event.install_timer("numba:compile", compiled.append):
            spent = self._spent(target, data, number)
        if (
            spent > MESSAGE_TIME_MAX and compiled
        ):  # which happens once on a machine: it is sent again
            spent = self._spent(target, data, number)
        if spent > MESSAGE_TIME_MAX:
            self.timed_out.append(f"{target.name}: {spent:.1f} s")

    def _spent(self, target: Target, data: Any, number: int) -> float:
        """Return what a message, and every few of them a tick, take of a core's time [s]."""
        self._send(target, data)
        started = time.process_time()
        self.robot.process.drain()
        if number % _TICK_EVERY == 0:
            self._play()
            self.robot.step()
        return time.process_time() - started

    def _made(self, target: Target) -> Any:
        owner = self.robot.nodes.get(target.name.rsplit("/", 1)[0].lstrip("/"))
        names = [] if owner is None else list(owner._parameters)
        made = filled(target, self._filler, self._rng, names)
        if target.kind == "topic" and self._rng.random() < _GARBLED:
            return self._filler.garble(serialize_message(made))
        if target.kind == "topic" and self._rng.random() < _FOREIGN:
            return self._foreign()[: len(serialize_message(made))]
        return made

    def _foreign(self) -> bytes:
        """Return what no message of a topic's type is; longer than one it could not be sent."""
        if self._rng.random() < 0.3:
            noise: bytes = self._rng.bytes(int(self._rng.integers(0, 2000)))
            return b"\x00\x01\x00\x00" + noise
        topics = [target for target in self.targets if target.kind == "topic"]
        other = topics[int(self._rng.integers(0, len(topics)))]
        return bytes(serialize_message(filled(other, self._filler, self._rng, [])))

    def _send(self, target: Target, data: Any) -> None:
        client = self.robot.client
        if target.kind == "topic":
            if target.name not in self._publishers:
                made = client.create_publisher(
                    target.cls, target.name, profile(client, target.name)
                )
                self._publishers[target.name] = made
            self._publishers[target.name].publish(data)
            return
        if target.name not in self._clients:
            self._clients[target.name] = client.create_client(target.cls, target.name)
            self.robot.process.drain()
        self._clients[target.name].call_async(data)

    def _play(self) -> None:
        """Let simulated time run, for a request may have stopped it."""
        request = SetSimulationState.Request(state=SimulationState(state=1))
        self.robot.call(SetSimulationState, "set_simulation_state", request)

    def mend(self) -> None:
        """Undo what clients may rightly do: poses, parameters, maps, goals, modes."""
        for publisher in self._publishers.values():
            self.robot.client.destroy_publisher(publisher)
        self._rise()
        self._play()
        self.robot.call(ResetSimulation, "reset_simulation", ResetSimulation.Request())
        self.robot.run(1.0)

    def _restore(self) -> None:
        for name, parameters in self._kept.items():
            self.robot.nodes[name].set_parameters(parameters)

    def _to_rest(self, node: Any) -> None:
        for state, step in (("active", "deactivate"), ("inactive", "cleanup")):
            if node.state_label == state:
                getattr(node, f"trigger_{step}")()
                self.robot.process.drain()

    def tallies(self) -> dict[str, dict[str, Any]]:
        """Return what the guard counted: what was refused, and what callbacks raised."""
        result: dict[str, dict[str, Any]] = {"failed": {}, "refused": {}}
        for (node, source), tally in self.robot.process.guard.tallies.items():
            where = f"{node} {source}"
            result[tally.kind][where] = {"count": tally.count, "last": tally.reason[:300]}
        return result


def main() -> int:
    """Run one session; write its outcome as JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("stack", choices=STACKS)
    parser.add_argument("seed", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    with (arguments.folder / "log.jsonl").open("w", encoding="utf-8") as log:
        barrage = Barrage(arguments.stack, arguments.seed, log)
        reached_before = barrage.reaches_a_goal()
        barrage.run(arguments.count)
        print(json.dumps({"number": -1, "target": "mend"}), file=log, flush=True)
        barrage.mend()
        outcome = {
            "targets": len(barrage.targets),
            "timed_out": barrage.timed_out,
            "goal_before": reached_before,
            "goal_after": barrage.reaches_a_goal(),
            "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
            **barrage.tallies(),
        }
        barrage.robot.close()
    (arguments.folder / "outcome.json").write_text(json.dumps(outcome), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
