"""The verbs of `ros2`; each raises Ros2Error where it fails."""
