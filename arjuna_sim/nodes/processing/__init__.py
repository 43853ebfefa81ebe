"""The small nodes of a robot's bringup, under the names of their packages."""
