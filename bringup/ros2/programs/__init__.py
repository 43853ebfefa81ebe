"""Programs of other packages that `ros2 run` runs."""
