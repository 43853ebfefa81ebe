"""The direct goal mover: speed by the distance, turn rate by the bearing; `direct_pose.py X Y`."""

import math

from geometry_msgs.msg import Twist
from simple_pose import SimplePose, main

MAX_SPEED, MAX_TURN = 0.22, 2.84
K_RHO, K_ALPHA = 0.3, 0.8


class DirectPose(SimplePose):
    """Steers while it drives. The bearing is wrapped: else a goal behind costs whole turns."""

    tolerance = 0.02

    def command(self, alpha: float) -> Twist:
        """Return speed and turn rate in proportion, within what a burger can do."""
        alpha = math.atan2(math.sin(alpha), math.cos(alpha))
        twist = Twist()
        twist.linear.x = min(K_RHO * self.rho, MAX_SPEED) * max(0.0, math.cos(alpha))
        twist.angular.z = max(-MAX_TURN, min(MAX_TURN, K_ALPHA * alpha))
        return twist


if __name__ == "__main__":
    main(DirectPose)
