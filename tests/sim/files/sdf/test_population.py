"""Copies of a population: their positions, their names, and what is no population."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from arjuna_core.errors import WorldError
from arjuna_sim.files.sdf.includes import populate
from tests.sim.builders import sdf_file

MODEL = "<model name='tree'/>"
BOX = "<box><size>4 6 2</size></box>"
TUBE = "<cylinder><radius>2</radius><length>3</length></cylinder>"


def copies(inside: str, model: str = MODEL, pose: str = "0 0 0 0 0 0") -> dict[str, list[float]]:
    """Return the pose of each copy that a population makes, by its name."""
    given = f"<population name='wood'>{model}<pose>{pose}</pose>{inside}</population>"
    xml = sdf_file(given)
    found = {}
    for each in populate(xml, xml.root[0]):
        assert len(each.findall("pose")) == 1
        name = each.get("name") or each.findtext("name") or ""
        found[name] = [float(word) for word in each.findtext("pose", "").split()]
    return found


def positions(inside: str) -> NDArray[np.float64]:
    """Return where the copies stand, `(N, 3) float64`."""
    return np.array([pose[:3] for pose in copies(inside).values()])


def spread(kind: str, count: int, region: str = BOX, more: str = "") -> str:
    """Return the tags of the copies' positions."""
    given = f"<distribution><type>{kind}</type>{more}</distribution>"
    return f"<model_count>{count}</model_count>{region}{given}"


def test_a_grid_is_centred_and_goes_row_by_row() -> None:
    more = "<rows>2</rows><cols>3</cols><step>1 10 0</step>"
    expected = [(x, y, 0.0) for y in (-5.0, 5.0) for x in (-1.0, 0.0, 1.0)]
    np.testing.assert_allclose(positions(spread("grid", 9, more=more)), expected)
    one = positions("<distribution><type> grid </type></distribution>")  # needs no region
    np.testing.assert_array_equal(one, np.zeros((1, 3)))
    assert len(copies(spread("grid", 9, more="<rows>0</rows><cols>3</cols>"))) == 0
    step = positions(spread("grid", 1, more="<rows>2</rows><cols>2</cols>"))
    np.testing.assert_allclose(np.ptp(step, axis=0), (1.0, 1.0, 0.0))


@pytest.mark.parametrize(("kind", "along", "edge"), [("x", 0, 4.0), ("y", 1, 6.0), ("z", 2, 2.0)])
def test_a_line_shares_the_region_evenly(kind: str, along: int, edge: float) -> None:
    expected = np.zeros((4, 3))
    expected[:, along] = np.array([-3.0, -1.0, 1.0, 3.0]) / 8.0 * edge
    np.testing.assert_allclose(positions(spread(f"linear-{kind}", 4)), expected)
    assert len(copies(spread(f"linear-{kind}", 0))) == 0


@pytest.mark.parametrize("kind", ["random", "uniform"])
def test_random_positions_fill_their_region_and_no_more(kind: str) -> None:
    in_box = positions(spread(kind, 200))
    assert (np.abs(in_box) <= (2.0, 3.0, 1.0)).all()
    assert (np.ptp(in_box, axis=0) > np.array((4.0, 6.0, 2.0)) * 0.9).all()
    in_tube = positions(spread(kind, 200, TUBE))
    reach = np.hypot(in_tube[:, 0], in_tube[:, 1])
    assert 1.8 < reach.max() <= 2.0
    assert 1.35 < np.abs(in_tube[:, 2]).max() <= 1.5
    short = TUBE.replace("<length>3</length>", "")
    assert 0.4 < np.abs(positions(spread(kind, 200, short))[:, 2]).max() <= 0.5
    np.testing.assert_array_equal(in_box, positions(spread(kind, 200)))  # the same each time


def test_uniform_positions_keep_apart_and_random_ones_need_not() -> None:
    def nearest(points: NDArray[np.float64]) -> float:
        gaps = np.linalg.norm(points[:, None] - points[None], axis=2)
        return float(gaps[~np.eye(len(points), dtype=bool)].min())

    flat = "<box><size>4 4 0.01</size></box>"
    assert nearest(positions(spread("uniform", 30, flat))) > 0.4
    by_chance = nearest(positions(spread("random", 30, flat)))
    assert by_chance < 0.2
    assert nearest(positions(f"<model_count>30</model_count>{flat}")) == by_chance  # if not told


def test_copies_are_numbered_and_stand_in_the_populations_frame() -> None:
    more = "<rows>1</rows><cols>2</cols><step>2 1 0</step>"
    quarter = f"5 6 7 0 0 {np.pi / 2}"
    plain = copies(spread("grid", 0, more=more), pose=quarter)
    assert list(plain) == ["tree_clone_0", "tree_clone_1"]
    np.testing.assert_allclose(plain["tree_clone_0"], (5, 5, 7, 0, 0, np.pi / 2), atol=1e-12)
    np.testing.assert_allclose(plain["tree_clone_1"], (5, 7, 7, 0, 0, np.pi / 2), atol=1e-12)
    own = "<model name='tree'><pose>0.5 0 0 0 0 0.1</pose></model>"
    moved = copies(spread("grid", 0, more=more), own, quarter)["tree_clone_0"]
    np.testing.assert_allclose(moved, (5, 5.5, 7, 0, 0, np.pi / 2 + 0.1), atol=1e-12)


@pytest.mark.parametrize(
    ("model", "name"),
    [
        ("<include><uri>model://oak</uri></include>", "wood"),
        ("<include><uri>model://oak</uri><name>oak</name></include>", "oak"),
        ("<model/>", "wood"),
    ],
)
def test_a_copy_without_a_name_is_called_as_its_population(model: str, name: str) -> None:
    assert list(copies(spread("random", 2), model)) == [f"{name}_clone_{i}" for i in range(2)]


@pytest.mark.parametrize(
    ("inside", "problem"),
    [
        (spread("random", 5001), "<model_count> is 5001; valid: 0 to 5000"),
        (spread("random", -1), "<model_count> is -1; valid: 0 to 5000"),
        (spread("random", 1, ""), "lacks its region; valid: <box>, <cylinder>"),
        (spread("random", 1, "<box/>"), "'wood' <size>.*has 0 numbers"),
        (spread("grid", 1, more="<rows>51</rows><cols>100</cols>"), "has 51 x 100 models; valid"),
        (spread("grid", 1, more="<rows>-1</rows><cols>-2</cols>"), "has -1 x -2 models; valid"),
        (spread("grid", 1, more="<step>1 2</step>"), "'wood' <step>.*has 2 numbers"),
    ],
)
def test_what_is_no_population_is_refused(inside: str, problem: str) -> None:
    with pytest.raises(WorldError, match=problem):
        copies(inside)
    with pytest.raises(WorldError, match="lacks <include>"):
        copies(spread("random", 1), model="")


def test_five_thousand_copies_are_the_most() -> None:
    line = positions(spread("linear-x", 5000))
    assert len(line) == 5000
    assert all(b > a for a, b in pairwise(line[:, 0].tolist()))
    assert len(copies(spread("grid", 0, more="<rows>50</rows><cols>100</cols>"))) == 5000
