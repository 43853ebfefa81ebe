"""ROS 2's `ros2topic`, as far as programs import it: `ros2topic.api`."""
