"""The transport of an isolated process: its nodes hand each other objects, without middleware."""
