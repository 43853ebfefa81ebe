"""ROS 2's `launch_yaml`, as far as launch files of Python import it."""
