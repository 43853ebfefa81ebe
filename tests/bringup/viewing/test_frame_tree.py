"""The tree of frames: every frame once, under its parent, loops named, drawn without overlap."""

from __future__ import annotations

from pathlib import Path

from bringup.viewing.frame_tree import (
    Frame,
    chain,
    draw_tree,
    layout,
    loops,
    roots,
    tree_text,
)

TREE = {
    "odom": Frame("odom", ("map",), rate=10.0, age=-0.2),
    "base": Frame("base", ("odom",), rate=50.0, age=0.25),
    "lidar": Frame("lidar", ("base",), static=True),
    "camera": Frame("camera", ("mast", "base"), static=True),
}
LOOP = {"a": Frame("a", ("b",)), "b": Frame("b", ("a",))}


def test_the_text_has_each_frame_under_its_parent_with_rate_and_age() -> None:
    lines = tree_text(TREE).splitlines()
    assert [line.split()[-1] for line in lines[:1]] == ["map"]
    assert [line.lstrip("│├└─ ").split()[0] for line in lines] == [
        *("map", "odom", "base", "camera", "lidar"),
    ]
    assert lines[1].endswith("10.0 Hz, 0.20 s ahead")
    assert lines[2].endswith("50.0 Hz, 0.25 s old")
    assert lines[3].endswith("static  also under mast")


def test_stamps_of_the_system_s_clock_are_named_so_beside_simulated_time() -> None:
    arm = Frame("arm", ("base",), rate=10.0, age=-1.7e9)
    (line,) = (line for line in tree_text({**TREE, "arm": arm}).splitlines() if " arm" in line)
    assert line.endswith(" 10.0 Hz, stamped by another clock")


def test_two_trees_have_two_roots() -> None:
    frames = {**TREE, "tool": Frame("tool", ("arm",))}
    assert roots(frames) == ["arm", "map"]
    lines = tree_text(frames).splitlines()
    assert [line for line in lines if line[0] not in "│├└ "] == ["arm", "map"]


def test_a_loop_is_named_and_ends() -> None:
    frames = {**TREE, **LOOP}
    assert loops(frames) == ["a", "b"]
    assert chain(frames, "a") == ["a", "b"]
    assert "a (in a loop through b)" in tree_text(frames)


def test_a_chain_runs_up_to_the_root() -> None:
    assert chain(TREE, "lidar") == ["lidar", "base", "odom", "map"]


def test_parents_stand_above_the_middle_of_their_children() -> None:
    parents = {"odom": "map", "left": "odom", "right": "odom"}
    assert layout({name: Frame(name, (parent,)) for name, parent in parents.items()}) == {
        "left": (0.0, -2.0),
        "right": (1.0, -2.0),
        "odom": (0.5, -1.0),
        "map": (0.5, 0.0),
    }


def test_every_frame_has_a_point_of_its_own_in_the_picture(tmp_path: Path) -> None:
    points = layout(TREE)
    assert set(points) == {"map", *TREE}
    assert len(set(points.values())) == len(points)
    path = tmp_path / "tree.png"
    draw_tree(path, TREE, {name: frame.facts for name, frame in TREE.items()})
    assert path.read_bytes().startswith(b"\x89PNG")
