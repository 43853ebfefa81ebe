"""ROS 2's `ros2node`, as far as programs import it: `ros2node.api`."""
