"""Gazebo's actions of launch files, by Jazzy's names: what they start is Arjuna's simulator."""
