"""Claims: images of the usual encodings become pixels, thinned to a width."""

from __future__ import annotations

import numpy as np
import pytest

from arjuna_core.pixels import pixels


def test_a_colour_image_is_shown_as_it_is() -> None:
    assert pixels("rgb8", 1, 2, 6, bytes([1, 2, 3, 4, 5, 6])).tolist() == [[[1, 2, 3], [4, 5, 6]]]


@pytest.mark.parametrize(
    ("encoding", "data"), [("bgr8", [3, 2, 1]), ("rgba8", [1, 2, 3, 9]), ("bgra8", [3, 2, 1, 9])]
)
def test_channels_come_in_the_order_red_green_blue(encoding: str, data: list[int]) -> None:
    assert pixels(encoding, 1, 1, len(data), bytes(data)).tolist() == [[[1, 2, 3]]]


def test_padding_at_the_end_of_rows_is_left_out() -> None:
    assert pixels("mono8", 2, 1, 4, bytes([7, 0, 0, 0, 8, 0, 0, 0]))[:, 0, 0].tolist() == [7, 8]


def test_a_large_image_is_thinned() -> None:
    assert pixels("rgb8", 480, 640, 1920, bytes(480 * 1920), 320).shape == (240, 320, 3)


def test_near_depths_are_brighter_and_none_are_black() -> None:
    depths = np.array([[1.0, 3.0, np.nan, np.inf]], dtype="<f4")
    shown = pixels("32FC1", 1, 4, 16, depths.tobytes())[0, :, 0].tolist()
    assert shown == [255, 40, 0, 0]


def test_an_unknown_encoding_is_refused_with_those_that_are_known() -> None:
    with pytest.raises(ValueError, match="'yuv422' is not shown; valid: rgb8"):
        pixels("yuv422", 1, 1, 2, b"ab")


def test_an_image_cut_short_is_refused() -> None:
    with pytest.raises(ValueError, match="5 bytes for an image of 1 rows of 6"):
        pixels("rgb8", 1, 2, 6, b"12345")
