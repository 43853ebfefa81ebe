"""rosbridge: the robot for web pages and for clients without ROS (roslibjs, roslibpy)."""
