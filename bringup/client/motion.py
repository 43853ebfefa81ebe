"""Velocity commands of a client, and straight drives and turns that its odometry closes."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from arjuna_core.ros.tf import TransformBuffer
from arjuna_core.ros.velocity import VelocityOutput, listeners
from arjuna_core.se2 import SE2, wrap
from arjuna_core.twist import STILL, Velocity
from bringup.client.session import ClientError, Session

if TYPE_CHECKING:
    from arjuna_nav.behaviors.legs import Leg

ODOM = "odom"
_REMEDY = "is 'python -m bringup sim' running?"


def velocity_output(
    session: Session, timeout: float, topic: str = "cmd_vel", stamped: bool | None = None
) -> VelocityOutput:
    """Return the output of commands to a robot that listens.

    Raises:
        ArjunaError: None does in time [s].
    """
    node, what = session.client, f"a robot that listens on '{topic}'"
    session.wait_for(lambda: bool(listeners(node, topic)), timeout, what, _REMEDY)
    output = VelocityOutput(node, stamped, frame="", topic=topic)
    session.wait_for(output.has_listener, timeout, what, _REMEDY)
    return output


def stop(session: Session, output: VelocityOutput) -> None:
    """Stand still; the command reaches the robot before the client leaves."""
    for _ in range(3):
        output.stop()
        session.pause(0.05)


class Trail(TransformBuffer):
    """Transforms that remember where the base was in `odom`, a pose every 2 cm."""

    def __init__(self) -> None:
        super().__init__()
        self.poses: deque[SE2] = deque(maxlen=100_000)

    def insert(
        self, parent: str, child: str, stamp: float, transform: SE2, *args: Any, **options: Any
    ) -> bool:
        """Add `T_parent_child`; see `TransformBuffer.insert`."""
        added = super().insert(parent, child, stamp, transform, *args, **options)
        moved = not self.poses or self.poses[-1].distance(transform) >= 0.02
        if added and moved and parent == ODOM and child == self.base_below(ODOM):
            self.poses.append(transform)
        return added

    def odometry(self) -> tuple[float, SE2]:
        """Return time [s] and pose of the base in `odom`, where there are `poses`.

        Raises:
            TransformError: Neither is known.
        """
        base = self.base_below(ODOM) or ODOM
        return self.latest_common(ODOM, base), self.lookup(ODOM, base)


class Reckoning:
    """Straight drives and turns on the spot, closed by the odometry.

    Each begins where the one before should have ended, if the robot stands near it: so a small
    error of one is made good by the next, and errors do not add up.

    Args:
        publish: Sends a velocity.
        timeout: For odometry to come, and beyond three times what a motion takes [s].
    """

    def __init__(
        self,
        session: Session,
        trail: Trail,
        publish: Callable[[Velocity], None],
        timeout: float,
    ) -> None:
        self._session, self._trail, self._publish = session, trail, publish
        self._timeout = timeout
        self._end: SE2 | None = None
        self._interrupted = False

    def interrupt(self) -> None:
        """End the motion under way; the next one begins where the robot stands."""
        self._end, self._interrupted = None, True

    def forward(self, distance: float, speed: float, check: Callable[[float], None]) -> float:
        """Drive straight by a distance, back where it is negative; return the one driven [m].

        Args:
            speed: [m/s].
            check: Takes the distance driven [m]; raises where the robot must stop.
        """
        from arjuna_nav.behaviors.legs import Leg

        start = self._start()
        leg = Leg(distance, speed=speed, start=start)
        done = self._run(leg, abs(distance) / speed, f"{distance:g} m", check)
        return self._ended(start @ SE2(distance, 0.0), done)

    def turn(self, angle: float, rate: float) -> float:
        """Turn on the spot [rad, rad/s], left where the angle is positive; return the angle."""
        from arjuna_nav.behaviors.legs import Leg

        start = self._start()
        leg = Leg(angle=angle, rate=rate, start=start)
        done = self._run(leg, abs(angle) / rate, f"{angle:g} rad")
        return self._ended(start @ SE2(0.0, 0.0, angle), done)

    def _start(self) -> SE2:
        """Return where a motion starts, and forget where the one before should have ended."""
        trail, end = self._trail, self._end
        what, remedy = "odometry", "is 'python -m bringup sim' running, and not paused?"
        self._session.wait_for(lambda: bool(trail.poses), self._timeout, what, remedy)
        pose = trail.odometry()[1]
        self._end, self._interrupted = None, False
        if end is None or pose.distance(end) > 0.05 or abs(wrap(pose.theta - end.theta)) > 0.1:
            return pose  # it was carried away meanwhile
        return end

    def _ended(self, end: SE2, done: float) -> float:
        self._end = None if self._interrupted else end
        return done

    def _run(
        self,
        leg: Leg,
        least: float,
        goal: str,
        check: Callable[[float], None] = lambda done: None,
    ) -> float:
        """Drive until a leg ends; return how far it came.

        Raises:
            ClientError: It takes more than three times its least duration [s].
        """
        from arjuna_nav.behaviors.legs import Legs
        from arjuna_nav.controllers.tracker import TrackerConfig

        near = replace(TrackerConfig(), xy_precision=0.005, yaw_precision=0.005)
        # Weak motors brake so too.
        config = replace(near, deceleration=0.25, angular_deceleration=0.5)
        legs = Legs([lambda pose: leg], config)
        duration = self._timeout + 3.0 * least
        for pose, velocity in self._measured(duration):
            wanted = legs.tick(pose, velocity)
            if wanted is None or self._interrupted:
                return legs.done
            check(legs.done)
            self._publish(wanted)
        raise ClientError(
            f"{legs.done:.2f} of {goal} after {duration:.0f} s: does something hold the robot, or"
            " does something else command it ('ros2 topic info -v /cmd_vel')?"
        )

    def _measured(self, duration: float) -> Iterator[tuple[SE2, Velocity]]:
        """Yield each new pose and velocity of the odometry for a duration [s]."""
        session, trail, velocity = self._session, self._trail, STILL
        deadline = session.now + duration
        stamp, pose = trail.odometry()

        def newer() -> bool:
            return trail.odometry()[0] > stamp

        while True:
            yield pose, velocity
            if not session.run_until(newer, deadline - session.now, required=False):
                return
            later, there = trail.odometry()
            x, y, turn = (pose.inverse() @ there).log() / (later - stamp)
            stamp, pose, velocity = later, there, Velocity(x, y=y, yaw_rate=turn)
