"""DWB's oscillation critic: no velocity changes its sign back and forth on one spot."""

from __future__ import annotations

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.dwb.config import OscillationConfig


class _Trend:
    """The signs that one velocity had."""

    def __init__(self) -> None:
        self.sign = 0
        self.only = 0

    def update(self, value: float) -> bool:
        """Take a commanded velocity; return whether it changed its sign."""
        sign = (value > 0.0) - (value < 0.0)
        if sign == 0:
            return False
        flipped = self.sign == -sign
        self.sign = sign
        if flipped:
            self.only = sign
        return flipped

    def allowed(self) -> tuple[bool, bool]:
        """Return whether negative and positive values are allowed."""
        return self.only <= 0, self.only >= 0


class Oscillation:
    """Remembers what was commanded since the robot last got on.

    Source: nav2 dwb_critics, OscillationCritic.
    """

    def __init__(self, config: OscillationConfig) -> None:
        self._config = config
        self._since: SE2 | None = None
        self.reset()

    def reset(self) -> None:
        """Allow everything."""
        self._v, self._side, self._w = _Trend(), _Trend(), _Trend()
        self._since = None

    def take(self, command: Velocity, pose: SE2) -> None:
        """Take what was commanded at a pose."""
        if self._since is not None and self._got_on(self._since, pose):
            self.reset()
        flipped = self._v.update(command.x)
        slow = self._config.x_only_threshold
        if slow < 0.0 or abs(command.x) <= slow:
            flipped |= self._side.update(command.y) | self._w.update(command.yaw_rate)
        if flipped:
            self._since = pose

    def _got_on(self, before: SE2, pose: SE2) -> bool:
        turned = abs(wrap(pose.theta - before.theta))
        return (
            before.distance(pose) > self._config.oscillation_reset_dist
            or turned > self._config.oscillation_reset_angle
        )

    @property
    def allowed(self) -> tuple[tuple[bool, bool], tuple[bool, bool], tuple[bool, bool]]:
        """Flags: negative and positive values are allowed; forward, to the left, of turning."""
        return self._v.allowed(), self._side.allowed(), self._w.allowed()
