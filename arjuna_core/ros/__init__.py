"""rclpy code that every node shares."""
