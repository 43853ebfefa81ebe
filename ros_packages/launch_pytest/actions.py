"""The action that lets tests begin, by launch_pytest's name."""

from launch_testing.actions import ReadyToTest

__all__ = ["ReadyToTest"]
