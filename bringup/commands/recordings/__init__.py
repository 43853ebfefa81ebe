"""Recordings: made, played, examined, looked at."""
