"""Commands that drive the robot."""
