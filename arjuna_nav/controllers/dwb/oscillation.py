"""DWB's oscillation critic: no velocity changes its sign back and forth on one spot."""

from __future__ import annotations

from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import Velocity
from arjuna_nav.controllers.dwb.config import OscillationConfig


class Oscillation:
    """Remembers what was commanded since the robot last got on.

    Source: nav2 dwb_critics, OscillationCritic.
    """

    def __init__(self, config: OscillationConfig) -> None:
        self._config = config
        self._since: tuple[SE2, float] | None = None
        self.reset()

    def reset(self) -> None:
        """Allow everything."""
        self._signs, self._only = [0, 0, 0], [0, 0, 0]  # had last; allowed, 0 for both
        self._since = None

    def take(self, command: Velocity, pose: SE2, now: float) -> None:
        """Take what was commanded at a pose and a time [s]."""
        if self._since is not None and self._got_on(*self._since, pose, now):
            self.reset()
        slow = self._config.x_only_threshold
        all_count = slow < 0.0 or abs(command.x) <= slow
        values = (command.x, command.y, command.yaw_rate) if all_count else (command.x,)
        for k, value in enumerate(values):
            sign = (value > 0.0) - (value < 0.0)
            if sign != 0 and self._signs[k] == -sign:
                self._only[k], self._since = sign, (pose, now)
            self._signs[k] = sign or self._signs[k]

    def _got_on(self, before: SE2, since: float, pose: SE2, now: float) -> bool:
        config, turned = self._config, abs(wrap(pose.theta - before.theta))
        return (
            before.distance(pose) > config.oscillation_reset_dist >= 0.0
            or turned > config.oscillation_reset_angle >= 0.0
            or now - since > config.oscillation_reset_time >= 0.0
        )

    @property
    def allowed(self) -> tuple[tuple[bool, bool], ...]:
        """Flags: negative and positive values are allowed; forward, to the left, of turning."""
        return tuple((only <= 0, only >= 0) for only in self._only)
