"""Robots: URDF, xacro and Gazebo's tags."""
