"""ROS 2's `launch_xml`, as far as launch files of Python import it."""
