"""Tests of the checks of messages."""
