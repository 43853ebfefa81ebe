"""Velocity commands in and out: Twist, or TwistStamped."""
