"""A machine, a graph and a scan at one instant, and findings of them, as plain values."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from arjuna_core.grid import OccupancyGrid
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from bringup.client.endpoint import Endpoint
from bringup.viewing.frame_tree import Frame


@dataclass(frozen=True)
class Finding:
    """A fault, with its numbers, and its remedy."""

    what: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.what}: {self.remedy}"


@dataclass(frozen=True)
class Machine:
    """The machine and this terminal's environment.

    Attributes:
        python: Version, (3, 12).
        foreign: Modules of ours that come from elsewhere than this environment, with their path.
        gl_error: Why nothing can be drawn off-screen; empty where it can.
        disk_free: Of the home folder [GiB].
        memory_free: [GiB].
        load: Processes that want to run, a core.
        domains: ROS domains in which processes of ours run, in order.
    """

    python: tuple[int, int] = (3, 12)
    missing: tuple[str, ...] = ()
    foreign: dict[str, str] = field(default_factory=dict)
    environment: dict[str, str] = field(default_factory=dict)
    gl_error: str = ""
    disk_free: float = 100.0
    memory_free: float = 8.0
    load: float = 0.5
    domains: tuple[int, ...] = ()


@dataclass(frozen=True)
class Clock:
    """The time that passed on /clock meanwhile [s], and how often it was set back."""

    elapsed: float
    set_back: int = 0


@dataclass(frozen=True)
class ScanFacts:
    """The last scan.

    Attributes:
        returns: Share of the beams that hit something.
        near: Share of the beams that hit something within 5 cm: the robot itself.
        upside_down: Whether its frame's z axis points down in the robot's base.
        clockwise: Whether its bearings fall.
        on_walls: Share of the hits within 15 cm of what /map has occupied; None without a map
            that has walls, or without a transform.
    """

    frame: str
    returns: float
    near: float = 0.0
    upside_down: bool = False
    clockwise: bool = False
    on_walls: float | None = None


@dataclass(frozen=True)
class Robot:
    """The last messages of a robot; None where there was none.

    Attributes:
        map_known: Share of the map's cells that are known.
        deviation: Standard deviation of AMCL's position [m].
        height: Height of the base's true pose [m].
        log: The last warnings and errors, `(node, text)`, oldest first.
        remarks: On parameters without an effect that its safety needs.
        troubles: What nodes report as an error, `(node, text)`.
    """

    scan: ScanFacts | None = None
    map_known: float | None = None
    deviation: float | None = None
    height: float | None = None
    log: tuple[tuple[str, str], ...] = ()
    remarks: tuple[str, ...] = ()
    troubles: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class Snapshot:
    """Everything that the checks look at.

    Attributes:
        namespace: The robot's, "/" for none; names of nodes and topics are without it.
        duration: Of listening [s].
        nodes: Full names of the nodes, one for each, so that twins show.
        states: Lifecycle state of each managed node, "" where it did not answer.
        on_system_time: Nodes that stamp by the system's clock while /clock is published.
    """

    machine: Machine = Machine()
    domain: int = 0
    namespace: str = "/"
    duration: float = 3.0
    nodes: tuple[str, ...] = ()
    endpoints: tuple[Endpoint, ...] = ()
    states: dict[str, str] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    clock: Clock | None = None
    on_system_time: tuple[str, ...] = ()
    frames: dict[str, Frame] = field(default_factory=dict)
    robot: Robot = Robot()

    def publishers(self, topic: str) -> list[Endpoint]:
        """Return the publishers of a topic."""
        return [end for end in self.endpoints if end.topic == topic and end.publishes]

    def subscribers(self, topic: str) -> list[Endpoint]:
        """Return the subscriptions of a topic."""
        return [end for end in self.endpoints if end.topic == topic and not end.publishes]

    def published(self, node: str) -> set[str]:
        """Return the types of what a node publishes."""
        return {end.type for end in self.endpoints if end.node == node and end.publishes}

    def runs(self, *names: str) -> bool:
        """Return whether a node of one of these names, in any namespace, is there."""
        return any(node.rpartition("/")[2] in names for node in self.nodes)

    def below(self, namespace: str) -> Snapshot:
        """Return one robot's part, its names without its namespace."""
        start = f"{namespace.rstrip('/')}/"
        plain = len(start) - 1

        def cut(names: dict[str, Any]) -> dict[str, Any]:
            return {name[plain:]: each for name, each in names.items() if name.startswith(start)}

        return replace(
            self,
            namespace=namespace,
            nodes=tuple(name[plain:] for name in self.nodes if name.startswith(start)),
            endpoints=tuple(
                replace(end, node=end.node[plain:], topic=end.topic[plain:])
                for end in self.endpoints
                if end.node.startswith(start) and end.topic.startswith(start)
            ),
            states=cut(self.states),
            on_system_time=tuple(cut(dict.fromkeys(self.on_system_time))),
            counts=cut(self.counts),
        )

    @property
    def pace(self) -> float:
        """The pace of the robot's time, of real time."""
        return 1.0 if self.clock is None else self.clock.elapsed / self.duration


def scan_facts(
    scan: Scan, frame: str, upside_down: bool, grid: OccupancyGrid | None, T_map_sensor: SE2 | None
) -> ScanFacts:
    """Return the facts of a scan in the sensor's frame."""
    hits = scan.valid
    fit = None
    if grid is not None and T_map_sensor is not None and hits.any() and grid.occupied().any():
        seen = scan.mirrored() if upside_down else scan
        fit = share_on_walls(replace(seen, T_base_sensor=T_map_sensor).points(), grid)
    return ScanFacts(
        frame,
        float(hits.mean()) if len(hits) else 0.0,
        float((hits & (scan.ranges < 0.05)).mean()) if len(hits) else 0.0,
        upside_down,
        scan.angle_increment < 0.0,
        fit,
    )


def share_on_walls(points: NDArray[np.float64], grid: OccupancyGrid, near: float = 0.15) -> float:
    """Return the share of points `(N, 2) float64` that lie near a map's occupied cells [m]."""
    cells = grid.frame.to_cells(points)
    rows, columns = cells[grid.frame.inside(cells)].T
    distances = distance_transform_edt(~grid.occupied()) * grid.frame.resolution
    return float((distances[rows, columns] <= near).sum() / len(points))
