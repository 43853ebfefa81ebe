"""Handling of failures within a process: caught, refused, counted, reported."""
