"""Laser scans as clouds."""

from __future__ import annotations

from laser_geometry.laser_geometry import LaserProjection
