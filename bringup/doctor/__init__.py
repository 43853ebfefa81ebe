"""Faults of a machine and a running robot with their remedies; and a table of its nodes."""
