"""Limits of what a message holds: far more than any robot needs, far less than hurts."""

from __future__ import annotations

GREATEST = 1e12
"""Of the sum of a message's numbers without their signs: squares of it stay exact enough."""
FARTHEST = 1e7
"""From the origin of a frame [m]: beyond it a float32 knows no metre."""
FUTURE = 10.0
"""How far ahead of the clock a measurement's stamp may be [s]."""
TEXT = 4096
"""Characters of a name, a path or a frame."""
DOCUMENT = 2**24
"""Characters of a description or a file's text."""
ITEMS = 10_000
"""Items of a list that no other limit names."""
NUMBERS = 2**20
"""Numbers of a list that no other limit names."""
BYTES = 2**26
"""Bytes of an image or a cloud of points."""
CALLS = 1000
"""Parameters of one request to a node."""
LISTED = 2**21
"""Bytes of a message of lists alone, such as a path: 20 000 poses, 0.1 s to read."""
POSES = 15_000
"""Poses of a path: 750 m, one each five centimetres."""
CORNERS = 1000
"""Corners of a polygon."""
OUTLINE = 20.0
"""From a robot's origin to a corner of its outline [m]."""
BEAMS = 20_000
"""Beams of a scan."""
CELLS = 2**25
"""Cells of a map: 290 m x 290 m at 5 cm."""
FINEST, COARSEST = 0.004, 100.0
"""Edge of a map's cell [m]."""
