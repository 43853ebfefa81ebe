"""What the services of simulation_interfaces need of the simulator's node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from arjuna_sim.files.library import Library
from arjuna_sim.nodes.fleet import Fleet
from arjuna_sim.simulation import Simulation


class Host(Protocol):
    """A running simulation that clients control.

    Attributes:
        simulator: The core.
        fleet: The robots that have nodes of their own.
        library: What clients may name.
        state: A SimulationState constant: whether simulated time runs.
        quitting: Whether a client asked the process to end.
    """

    simulator: Simulation
    fleet: Fleet
    library: Library
    state: int
    quitting: bool

    def serve(self, service_type: Any, name: str, callback: Callable[[Any, Any], Any]) -> None:
        """Create a service that lives until cleanup."""

    def advance(self) -> None:
        """Advance one tick and publish what it brought."""

    def begin_anew(self) -> None:
        """Count contacts from zero, and publish the time, which was set back."""

    def tell_time(self) -> None:
        """Publish the time, where it was set back."""
