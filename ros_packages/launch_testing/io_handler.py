"""What processes have written, by launch_testing's names."""

from launch_testing.records import IoHandler

ActiveIoHandler = IoHandler

__all__ = ["ActiveIoHandler", "IoHandler"]
