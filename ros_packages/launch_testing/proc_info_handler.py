"""Starts and ends of processes, by launch_testing's names."""

from launch_testing.records import ProcInfoHandler

ActiveProcInfoHandler = ProcInfoHandler

__all__ = ["ActiveProcInfoHandler", "ProcInfoHandler"]
