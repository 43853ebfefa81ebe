"""What is wrong with a machine and a running robot, and the cure; also what it is doing."""
