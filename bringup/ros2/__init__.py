"""The `ros2` command where no ROS is installed: ros2cli's grammar, output and exit codes."""
