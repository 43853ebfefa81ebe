"""Claims: images of the usual encodings become pixels, thinned to a width."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.pixels import pixels


@pytest.mark.parametrize(
    ("encoding", "step", "data", "shown"),
    [
        ("rgb8", 6, [1, 2, 3, 4, 5, 6], [[[1, 2, 3], [4, 5, 6]]]),
        ("bgr8", 3, [3, 2, 1], [[[1, 2, 3]]]),
        ("rgba8", 4, [1, 2, 3, 9], [[[1, 2, 3]]]),
        ("bgra8", 4, [3, 2, 1, 9], [[[1, 2, 3]]]),
        ("mono8", 4, [7, 0, 0, 0, 8, 0, 0, 0], [[[7, 7, 7]], [[8, 8, 8]]]),  # rows are padded
    ],
)
def test_channels_come_in_the_order_red_green_blue(
    encoding: str, step: int, data: list[int], shown: list[list[list[int]]]
) -> None:
    found = pixels(encoding, len(shown), len(shown[0]), step, bytes(data))
    assert np.broadcast_to(found, np.shape(shown)).tolist() == shown


def test_a_large_image_is_thinned() -> None:
    assert pixels("rgb8", 480, 640, 1920, bytes(480 * 1920), 320).shape == (240, 320, 3)


def test_near_depths_are_brighter_and_none_are_black() -> None:
    depths = np.array([[1.0, 3.0, np.nan, np.inf]], dtype="<f4")
    shown = pixels("32FC1", 1, 4, 16, depths.tobytes())[0, :, 0].tolist()
    assert shown == [255, 40, 0, 0]


@pytest.mark.parametrize(
    ("encoding", "problem"),
    [
        ("yuv422", "'yuv422' is not shown; valid: rgb8"),
        ("rgb8", "5 bytes for an image of 1 rows of 6"),
    ],
)
def test_what_cannot_be_shown_is_refused(encoding: str, problem: str) -> None:
    with pytest.raises(ValueError, match=problem):
        pixels(encoding, 1, 2, 6, b"12345")
