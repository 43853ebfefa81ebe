"""Places hardly wider than the robot, driven through along their middle."""
