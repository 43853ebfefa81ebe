"""Where the robot has got to since something was seen."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import TransformError
from arjuna_core.se2 import IDENTITY, SE2


@dataclass(frozen=True)
class WatchFrames:
    """The frames in which sources are read.

    Attributes:
        node: The node that reads.
        base: The robot's.
        odom: That in which what is seen stays put.
        correction: Whether what was seen is moved to where the robot is now.
        tolerance: By how much a transform may be older than what was seen [s].
    """

    node: ManagedNode
    base: str
    odom: str
    correction: bool
    tolerance: float

    def then(self, stamp: float) -> SE2:
        """Return `T_odom_base` at a time [s], or the newest where that is hardly older.

        Raises:
            TransformError: It is not known, or older than the tolerance.
        """
        transforms = self.node.transforms
        newest = transforms.latest_common(self.odom, self.base)
        if newest and stamp - newest > self.tolerance:
            late = f"{stamp - newest:.2f} s, over transform_tolerance of {self.tolerance:g} s"
            raise TransformError(f"{self.odom} -> {self.base} is behind what was seen by {late}")
        return transforms.lookup(self.odom, self.base, min(stamp, newest))

    def since(self, stamp: float) -> SE2:
        """Return `T_base_then`, which maps what the base saw at a time [s] to what it sees now.

        Raises:
            TransformError: It is not known.
        """
        if not self.correction:
            return IDENTITY
        return self.node.transforms.lookup(self.base, self.odom) @ self.then(stamp)
