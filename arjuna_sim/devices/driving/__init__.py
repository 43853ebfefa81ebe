"""Bases: how velocities become turns of wheels, and turns of wheels motion."""
