"""What the verbs of `ros2` do."""
