"""ROS 2's `ros2cli`, as far as programs import it: the node that its commands have."""
