"""Robots from their files: the rules that make links, joints and tags a `RobotModel`."""
