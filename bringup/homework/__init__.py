"""Homework: exercises that are handed out, and graded by the simulator's truth."""
