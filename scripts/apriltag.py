"""Draw an AprilTag: `python -m scripts.apriltag worlds/tag36h11_00000.png --id 0`.

Source: Olson, AprilTag: A robust and flexible visual fiducial system, ICRA 2011; the family's
published table of codes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from PIL import Image

_CODES = (0xD5D628584, 0xD97F18B49, 0xDD280910E, 0xE479E9C98, 0xEBCBCA822, 0xF31DAB3AC)
"""The first codes of tag36h11: six rows of six bits, the first the highest."""
_CELL = 40  # pixels


def main() -> None:
    """Write one tag with its white border, ten cells wide."""
    parser = argparse.ArgumentParser(description=main.__doc__)
    parser.add_argument("file", type=Path, help="a PNG file")
    parser.add_argument("--id", type=int, default=0, choices=range(len(_CODES)), help="which (0)")
    given = parser.parse_args()
    bits = [_CODES[given.id] >> (35 - i) & 1 for i in range(36)]
    cells = np.full((10, 10), 255, np.uint8)
    cells[1:9, 1:9] = 0
    cells[2:8, 2:8] = 255 * np.array(bits, np.uint8).reshape(6, 6)
    Image.fromarray(cells.repeat(_CELL, axis=0).repeat(_CELL, axis=1)).save(given.file)


if __name__ == "__main__":
    main()
