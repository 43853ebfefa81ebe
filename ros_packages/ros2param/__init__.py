"""ROS 2's `ros2param`, as far as programs import it: `ros2param.api`."""
