"""Tests of bases and of how they take commands."""
