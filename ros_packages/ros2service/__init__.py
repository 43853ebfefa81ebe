"""ROS 2's `ros2service`, as far as programs import it: `ros2service.api`."""
