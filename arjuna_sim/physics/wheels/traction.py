"""Traction: how hard a robot may pull away and brake before a wheel slips or leaves the ground."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from arjuna_core.arrays import Bools, Floats
from arjuna_core.geodesy import GRAVITY

LEAST = 0.5
"""Acceleration that any robot is asked for [m/s^2]."""
_CARRIED = 0.1  # share of the weight that wheels carry at least that do not hang
SPREAD = 1e-3  # of contacts along the robot, from which they hold it upright [m]


@dataclass(frozen=True)
class GroundContacts:
    """The contacts of a robot with level ground.

    Attributes:
        positions: From above, in the root's frame, `(N, 2) float64` [m].
        gaps: Between the ground and each when the lowest touches it, by what a wheel sinks in under
            its load, `(N,) float64`.
        friction: Of each, `(N,) float64`.
        drives: Whether each is a driven wheel, `(N,) bool`.
    """

    positions: Floats
    gaps: Floats
    friction: Floats
    drives: Bools


@dataclass(frozen=True)
class Weight:
    """The load on a robot's ground contacts.

    Attributes:
        mass: [kg].
        middle: Centre of mass, in the root's frame and above the ground, `(3,) float64` [m].
        spin: Inertia of the wheels over their radius, `I / r` of all together [kg m].
        force: Greatest force of all motors at the ground [N].
        rolling: Mass that the wheels' turning adds, `I / r^2` of all together [kg].
    """

    mass: float
    middle: Floats
    spin: float
    force: float
    rolling: float


def steady_acceleration(contacts: GroundContacts, weight: Weight) -> float:
    """Return the greatest acceleration at which all stay on the ground and none slips [m/s^2].

    The contacts share the weight as equal springs do. Whoever accelerates leans on the rear ones by
    the height of the weight, and by the torque that the wheels take to spin up.

    Returns:
        The acceleration, at least `LEAST`, as where the driven wheels carry nothing; infinity where
        the contacts do not hold the robot upright, as of one that balances, or none is driven.
    """
    if not contacts.drives.any():
        return np.inf
    contacts, loads = _loaded_contacts(contacts, weight)
    if not contacts.drives.any():
        return LEAST
    if np.ptp(contacts.positions[:, 0]) < SPREAD:
        return np.inf
    lean = _shares(contacts) @ np.array([0.0, -(weight.mass * weight.middle[2] + weight.spin), 0.0])
    # [m/s^2] A foot that carries next to nothing may leave the ground.
    lifting = max(1.0, float((loads / np.maximum(np.abs(lean), 1e-12)).min()))
    held = contacts.friction * loads
    gripping = float(held[contacts.drives].sum() - held[~contacts.drives].sum()) / weight.mass
    turning = weight.force / (weight.mass + weight.rolling)
    # A fifth of the grip and of the motors' force is left to steer with.
    return max(LEAST, min(lifting, 0.8 * gripping, 0.8 * turning))


def _loaded_contacts(contacts: GroundContacts, weight: Weight) -> tuple[GroundContacts, Floats]:
    """Return the contacts that carry something at rest, and their loads, `(N,) float64` [N]."""
    x, y, _ = weight.middle.tolist()
    unit = weight.mass * GRAVITY / max(1, int(contacts.drives.sum()))  # sinks a contact in by one
    while True:
        shares, levers = _shares(contacts), _levers(contacts)
        warped = contacts.gaps - levers @ (shares.T @ contacts.gaps)
        loads = shares @ (weight.mass * GRAVITY * np.array([1.0, x, y])) - unit * warped
        keep = loads > loads.min()
        if loads.min() > 0.0 or not keep.any():
            return contacts, loads
        contacts = GroundContacts(**{key: part[keep] for key, part in vars(contacts).items()})


def _levers(contacts: GroundContacts) -> Floats:
    return np.column_stack((np.ones(len(contacts.positions)), contacts.positions))


def _shares(contacts: GroundContacts) -> Floats:
    """Return what a force and its moments load each contact with, `(N, 3) float64`."""
    shares: Floats = np.linalg.pinv(_levers(contacts)).T
    return shares


def carrier(contacts: GroundContacts, weight: Weight) -> int:
    """Return the contact that carries a robot in place of its driven wheels, -1 for none."""
    if not contacts.drives.any():
        return -1
    loaded, loads = _loaded_contacts(contacts, weight)
    if loads[loaded.drives].sum() >= _CARRIED * weight.mass * GRAVITY:
        return -1
    most = loaded.positions[np.where(loaded.drives, -np.inf, loads).argmax()]
    return int(((contacts.positions == most).all(axis=1) & ~contacts.drives).argmax())


def traction_notes(steady: float, stands_on: str) -> tuple[str, ...]:
    """Return a note on a robot that hardly pulls away.

    Args:
        steady: Its steady acceleration [m/s^2].
        stands_on: The link that carries it in place of its driven wheels; "" where these carry it.
    """
    if steady > LEAST:
        return ()
    if stands_on:
        reason = f"its driven wheels carry next to nothing, it stands on '{stands_on}'"
        return (f"hardly drives: {reason}",)
    return ("hardly drives: its wheels grip, or its motors pull, little more than the rest rubs",)
