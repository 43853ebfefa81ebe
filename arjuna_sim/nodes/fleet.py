"""The robots of a simulation that have nodes of their own, as they come and go."""

from __future__ import annotations

from collections.abc import Iterator

from arjuna_core.errors import ArjunaError
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_sim.inputs import named_robot
from arjuna_sim.model.robot import SOLO, RobotModel
from arjuna_sim.nodes.robot_nodes import RobotNodes
from arjuna_sim.nodes.sim_config import SimConfig
from arjuna_sim.simulation import Simulation, Start


class NamespaceError(ArjunaError):
    """A robot lacks a namespace, or another has it."""


def starts_of(config: SimConfig) -> dict[str, Start]:
    """Return the robots that a simulator starts with, by namespace, and where each starts.

    Raises:
        RobotError: A robot's file cannot be used.
    """
    files = config.robots or (config.robot,) * len(config.namespaces)
    robots = {file: named_robot(file, config.robot_arguments) for file in files}
    own = config.initial_pose
    numbers = config.starts or (own.x, own.y, own.yaw) * len(files)
    poses = [SE2(*numbers[i : i + 3]) for i in range(0, len(numbers), 3)]
    return {
        name.strip("/"): Start(robots[file], pose)
        for name, file, pose in zip(config.namespaces, files, poses, strict=True)
    }


class Fleet:
    """Brings up the nodes of each robot that is there, and takes down those of one that is not.

    A robot of the start has its namespace for a name. The simulator's own robot, where there is
    one, has no nodes here.

    Args:
        node: The simulator's node, being configured, in whose process the nodes live.
        simulation: Holds the robots.

    Raises:
        ArjunaError: A robot's nodes could not be configured.
    """

    def __init__(self, node: ManagedNode, simulation: Simulation) -> None:
        self._node, self._simulation = node, simulation
        self._namespaces: dict[str, str] = {}
        self._nodes: dict[str, RobotNodes] = {}
        node.keep(self)
        self.match()

    def __iter__(self) -> Iterator[tuple[str, RobotNodes]]:
        """Return each robot's name and nodes."""
        return iter(self._nodes.items())

    def nodes(self, name: str) -> RobotNodes:
        """Return the nodes of a robot."""
        return self._nodes[name]

    def add(self, name: str, namespace: str, robot: RobotModel, pose: SE2) -> None:
        """Put a robot into the world, with nodes below a namespace.

        Raises:
            NamespaceError: Another robot has the namespace.
            PlaceTakenError: It would stand in something.
            ArjunaError: It cannot be simulated, or its nodes cannot be brought up.
        """
        taken = {nodes.namespace: other for other, nodes in self._nodes.items()}
        if SOLO in self._simulation.robots:
            taken[self._node.process.namespace] = "the simulator's own"
        if namespace in taken:
            problem = f"namespace '/{namespace}' is that of robot '{taken[namespace]}'"
            raise NamespaceError(f"{problem}; give another as entity_namespace")
        self._simulation.add(name, Start(robot, pose))
        self._namespaces[name] = namespace
        try:
            self.match()
        except ArjunaError:
            self._simulation.remove(name)
            raise

    def remove(self, name: str) -> None:
        """Take a robot out of the world, and its topics out of the graph."""
        self._simulation.remove(name)
        self.match()

    def match(self) -> None:
        """Have nodes for just the robots that are there.

        Raises:
            ArjunaError: A robot's nodes could not be brought up.
        """
        robots = self._simulation.robots
        for name in [n for n, nodes in self._nodes.items() if robots.get(n) is not nodes.robot]:
            gone = self._nodes.pop(name)
            gone.deactivate()
            # who asks for it may be answered by one of these nodes' own events, still queued
            self._node.process.executor.create_task(gone.destroy)
        for name in [n for n in robots if n != SOLO and n not in self._nodes]:
            namespace = self._namespaces.get(name, name)
            made = RobotNodes(
                self._node.process,
                namespace,
                robots[name],
                self._simulation.stage,
                self._node.config,
            )
            if self._node.active:
                made.activate()
            self._nodes[name] = made

    def activate(self) -> None:
        """Let all work.

        Raises:
            ArjunaError: A node refuses.
        """
        for nodes in self._nodes.values():
            nodes.activate()

    def deactivate(self) -> None:
        """Let all rest."""
        for nodes in self._nodes.values():
            nodes.deactivate()

    def destroy(self) -> None:
        """Take all nodes out of the graph."""
        while self._nodes:
            self._nodes.popitem()[1].destroy()
