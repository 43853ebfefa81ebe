"""Waiting for processes of a launch, by launch_pytest's names."""

from launch_pytest.tools import process
