"""Where the pattern of a calibration leads a vehicle that does exactly as it is told."""

from __future__ import annotations

import math

import pytest

from arjuna_core.se2 import SE2
from arjuna_core.twist import Velocity
from arjuna_sim.devices.calibration import Measurement, drive

# Worked out by hand: a straight goes on by its speed times its time; a spin turns on the spot; an
# arc of half a turn ends beside its start by twice its radius v / w, facing back.
ENDS = (
    (2.0, 0.0, 0, 4.0),  # straight at 0.5 m/s for 4 s
    (2.0, 0.0, 90, math.pi / 2),  # a quarter to the left at 1 rad/s
    (2.0, 1.2, 90, 4.0),  # at 0.3 m/s
    (2.0, 1.2, 180, math.pi / 4),  # a quarter at 2 rad/s
    (0.0, 1.2, 180, 2.0),  # at 1 m/s
    (0.0, 1.2, 360, 2.0 * math.pi),  # a half at 0.5 rad/s
    (0.0, 2.8, 540, 2.0 * math.pi),  # half a circle to the left, of 0.8 m
    (0.0, 2.8, 450, math.pi / 2),  # a quarter to the right
    (1.6, 2.8, 270, 2.0 * math.pi),  # half a circle to the right, of 0.8 m
    (1.6, 2.8, 180, math.pi / 4),
    (1.6, 1.8, 360, math.pi),  # half a circle to the left, of 0.5 m
    (0.4, 1.8, 360, 4.0),  # back at 0.3 m/s
    (0.4, 0.6, 180, math.pi),  # half a circle to the right, of 0.6 m
    (0.4, 0.6, 90, math.pi),  # a quarter to the right at 0.5 rad/s
)


class Exact:
    """A vehicle that does what it is told, and knows when it rested."""

    tick = math.pi / 400  # of which every manoeuvre but a straight takes a whole number

    def __init__(self) -> None:
        self.pose = SE2(0.0, 0.0, 0.0)

    def drive(self, velocity: Velocity) -> None:
        self.pose @= SE2.exp((velocity.x * self.tick, 0.0, velocity.yaw_rate * self.tick))

    def observe(self) -> Measurement:
        return Measurement((0.0, 0.0), self.pose)


def test_the_pattern_leads_where_geometry_says() -> None:
    log = drive(Exact())
    assert len(log.spans) == len(ENDS)
    for (x, y, degrees, seconds), (manoeuvre, start, end) in zip(ENDS, log.spans, strict=True):
        assert log.truth[end, :2] == pytest.approx((x, y), abs=0.03)
        assert log.truth[end, 2] == pytest.approx(math.radians(degrees), abs=1e-6)
        assert (end - start) * log.tick - 1.0 == pytest.approx(seconds, abs=log.tick)
        assert manoeuvre.seconds == pytest.approx(seconds)
