"""Gazebo's colours by name."""

from __future__ import annotations

import pytest

from arjuna_sim.files.tag_text import gazebo_colour

NAMES = (
    *("Red", "Green", "Blue", "Yellow", "Orange", "Purple", "Turquoise", "Indigo", "Gold"),
    *("Silver", "White", "Black", "Grey", "Gray", "Road", "Wood"),
)


@pytest.mark.parametrize("name", NAMES)
def test_a_colour_can_be_drawn_and_has_variants(name: str) -> None:
    colour = gazebo_colour(f"Gazebo/{name}")
    assert colour is not None
    assert len(colour) == 4
    assert all(0.0 <= part <= 1.0 for part in colour)
    for other in (name.lower(), f"Gazebo/Dark{name}", f"a/b/{name}Glow", f" {name}_Transparent "):
        assert gazebo_colour(other) == colour


def test_colours_look_as_they_are_called() -> None:
    for k, name in enumerate(("Red", "Green", "Blue")):
        colour = gazebo_colour(name)
        assert colour is not None
        assert colour.index(max(colour[:3])) == k
    black, white = gazebo_colour("Black"), gazebo_colour("White")
    assert black is not None
    assert white is not None
    assert max(black[:3]) < 0.2 < 0.8 < min(white[:3])
    assert gazebo_colour("Gazebo/Plaid") is None
