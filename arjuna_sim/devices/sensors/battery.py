"""Batteries, as gz-sim's LinearBatteryPlugin has them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

from arjuna_sim.devices.device import Mount, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import flag
from arjuna_sim.model.settings import SensorSettings, reads

_STEP = 1.0  # of the sum over time, at most [s]
_MOVES = 0.02  # speed from which a robot moves, or turns [m/s or rad/s]


@dataclass(frozen=True, kw_only=True)
class BatterySettings(SensorSettings):
    """A battery whose voltage falls with its charge.

    Attributes:
        voltage: At the start [V].
        full: Open, when it is full [V].
        fall: From there to the empty one's, negative [V].
        charge: At the start [Ah].
        capacity: [Ah].
        resistance: [Ohm].
        tau: In which the current follows the load [s].
        load: Power that is drawn [W].
        waits: Whether that is drawn from the robot's first motion on, else from the start on.
    """

    TITLE: ClassVar[str] = "battery"
    voltage: float
    full: float
    fall: float
    charge: float
    capacity: float
    resistance: float
    tau: float
    load: float
    waits: bool

    def details(self) -> str:
        """Return charge, voltage and load."""
        return f"{self.charge:g} of {self.capacity:g} Ah, {self.voltage:g} V, load {self.load:g} W"


@reads("linearbatteryplugin")
def read(tag: SensorTag) -> list[BatterySettings]:
    """Read a plugin that is a battery.

    Raises:
        RobotError: A value is invalid.
    """
    name = tag.text("batteryname", default="battery")
    voltage, capacity = tag.number("voltage", 0.0), tag.number("capacity", 0.0)
    if not (voltage > 0.0 and capacity > 0.0):
        raise tag.fail(f"<voltage> {voltage}, <capacity> {capacity}: both must be above 0")
    waits = flag(tag.element, False, "startonmotion")
    if not waits and not flag(tag.element, True, "startdraining"):
        tag.note("drains from the start on, not from when a topic says so")
    if flag(tag.element, False, "enablerecharge"):
        tag.note("is not recharged")
    return [
        BatterySettings(
            link=tag.link,
            frame=tag.link,
            rate=10.0,
            topic=f"/model/{tag.robot}/battery/{name}/state",
            name=name,
            voltage=voltage,
            full=tag.number("open_circuit_voltage_constant_coef", voltage),
            fall=tag.number("open_circuit_voltage_linear_coef", 0.0),
            charge=tag.number("initial_charge", capacity),
            capacity=capacity,
            resistance=tag.number("resistance", 0.0),
            tau=max(tag.number("smooth_current_tau", 1.0), 1e-3),
            load=tag.number("power_load", 0.0),
            waits=waits and not flag(tag.element, False, "startdraining"),
        )
    ]


class Charge(NamedTuple):
    """The state of a battery: voltage [V], current drawn [A], charge [Ah], of 1."""

    voltage: float
    current: float
    charge: float
    percentage: float


@simulates(BatterySettings)
class Battery:
    """Sums up what is drawn from the simulation's start or the robot's first motion on."""

    def __init__(self, settings: BatterySettings, mount: Mount) -> None:
        self._settings = settings
        self.rebind(mount.model)
        self._restart()

    def _restart(self) -> None:
        self._now, self._current, self._waits = 0.0, 0.0, self._settings.waits
        self._voltage, self._charge = self._settings.voltage, self._settings.charge

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._body = int(model.site_bodyid[model.site(self._settings.site).id])

    def settle(self) -> None:
        """Do nothing: no motion is remembered."""

    def read(self, data: Any, now: float) -> Charge:
        """Return its state at a time [s]."""
        if now < self._now:
            self._restart()
        if self._waits:
            self._now, self._waits = now, float(abs(data.cvel[self._body]).max()) < _MOVES
        while now - self._now > 1e-9:
            self._draw(min(now - self._now, _STEP))
        percentage = self._charge / self._settings.capacity
        return Charge(self._voltage, self._current, self._charge, percentage)

    def _draw(self, dt: float) -> None:
        own = self._settings
        self._now += dt
        wanted = own.load / max(self._voltage, 1e-3) if self._charge > 0.0 else 0.0
        self._current += min(dt / own.tau, 1.0) * (wanted - self._current)
        self._charge = max(0.0, self._charge - self._current * dt / 3600.0)
        empty = 1.0 - self._charge / own.capacity
        self._voltage = own.full + own.fall * empty - own.resistance * self._current
