"""ros2_control's helpers for launch files, by Jazzy's name."""
