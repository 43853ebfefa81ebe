"""Batteries, as gz-sim's LinearBatteryPlugin has them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any, ClassVar, NamedTuple

from arjuna_sim.devices.device import Mount, StaticDevice, simulates
from arjuna_sim.files.sensor_tag import SensorTag
from arjuna_sim.files.tag_text import flag, texts
from arjuna_sim.model.settings import SensorSettings, reads

_STEP = 1.0  # of the sum over time, at most [s]
_MOVES = 0.02  # speed from which a robot moves, or turns [m/s or rad/s]
_FULL = 0.9  # of its capacity: gz-sim charges no more from there on


class Supply(Enum):
    """The state of a battery's charge, in the numbers of `sensor_msgs/BatteryState`."""

    CHARGES = 1
    DRAINS = 2
    RESTS = 3
    FULL = 4


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
        charging_time: In which it is filled, 0 where it cannot be [h].
        charged_by_topic: Whether topics start and stop that too, beside services.
        draining_topics: On whose messages it drains from then on.
        resting_topics: On whose messages it drains no more.
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
    charging_time: float = 0.0
    charged_by_topic: bool = False
    draining_topics: tuple[str, ...] = ()
    resting_topics: tuple[str, ...] = ()

    @property
    def base(self) -> str:
        """The name below which its topics and services are."""
        return self.topic.rpartition("/")[0]

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
    draining, resting = (
        tuple(texts(tag.element, f"{word}powerdrainingtopic")) for word in ("", "stop")
    )
    if not (waits or draining or flag(tag.element, True, "startdraining")):
        tag.note("drains from the start on: no <power_draining_topic> says when else")
    charging_time = 0.0
    if flag(tag.element, False, "enablerecharge"):
        charging_time = tag.number("charging_time", tag.number("recharging_time", 0.0))
        if not charging_time > 0.0:
            tag.note("is not recharged: <charging_time> must be above 0")
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
            waits=(waits or bool(draining)) and not flag(tag.element, False, "startdraining"),
            charging_time=charging_time,
            charged_by_topic=flag(tag.element, False, "rechargebytopic"),
            draining_topics=draining,
            resting_topics=resting,
        )
    ]


class Charge(NamedTuple):
    """The state of a battery: voltage [V], current drawn [A], charge [Ah], of 1, and supply."""

    voltage: float
    current: float
    charge: float
    percentage: float
    supply: Supply


@simulates(BatterySettings)
class Battery(StaticDevice):
    """Sums up what is drawn from the simulation's start or the robot's first motion on.

    Attributes:
        charges: Whether it is being filled.
        drains: Whether its load is drawn; until it is, a robot that moves begins it.

    Source: gz-sim, LinearBatteryPlugin.
    """

    def __init__(self, settings: BatterySettings, mount: Mount) -> None:
        super().__init__(settings, mount)
        self._restart()

    def _restart(self) -> None:
        self._now, self._current, self.charges = 0.0, 0.0, False
        self.drains = not self._settings.waits
        self._voltage, self._charge = self._settings.voltage, self._settings.charge

    def rebind(self, model: Any) -> None:
        """Continue with another model, in which the robot is the same."""
        self._body = int(model.site_bodyid[model.site(self._settings.site).id])

    def read(self, data: Any, now: float) -> Charge:
        """Return its state at a time [s]."""
        if now < self._now:
            self._restart()
        self.drains = self.drains or float(abs(data.cvel[self._body]).max()) >= _MOVES
        if not (self.drains or self.charges):
            self._now = now
        while now - self._now > 1e-9:
            self._draw(min(now - self._now, _STEP))
        percentage = self._charge / self._settings.capacity
        return Charge(self._voltage, self._current, self._charge, percentage, self._supply())

    def _supply(self) -> Supply:
        if self.charges or self.drains:
            return Supply.CHARGES if self.charges else Supply.DRAINS
        is_full = self._charge > _FULL * self._settings.capacity
        return Supply.FULL if is_full else Supply.RESTS

    def _draw(self, dt: float) -> None:
        own = self._settings
        self._now += dt
        draws = self.drains and self._charge > 0.0
        wanted = own.load / max(self._voltage, 1e-3) if draws else 0.0
        if self.charges and self._charge < _FULL * own.capacity:
            wanted -= own.capacity / own.charging_time
        self._current += min(dt / own.tau, 1.0) * (wanted - self._current)
        self._charge = max(0.0, self._charge - self._current * dt / 3600.0)
        empty = 1.0 - self._charge / own.capacity
        self._voltage = own.full + own.fall * empty - own.resistance * self._current
