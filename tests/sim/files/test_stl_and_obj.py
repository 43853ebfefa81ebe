"""OBJ and STL files line by line, and the bounds on what is read."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from arjuna_sim.files import meshes as triangles
from arjuna_sim.files.meshes import MeshError, read_mesh

SQUARE = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 2.0]])
CORNERS = "\n".join(f"v {x} {y} {z}" for x, y, z in SQUARE)
FAN = SQUARE[[[0, 1, 2], [0, 2, 3]]]


def read(folder: Path, name: str, content: str | bytes, part: str = "") -> np.ndarray:
    path = folder / name
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return read_mesh(path, part)


def turned(triangles: np.ndarray) -> list[list[list[float]]]:
    """Return triangles, each from its least corner on, in an order of their own."""
    return sorted(min(face[i:] + face[:i] for i in range(3)) for face in triangles.tolist())


def stl(count: int, said: int | None = None, header: bytes = b"", more: bytes = b"") -> bytes:
    """Return binary STL of faces whose corners are (i, i, i), (i + 1, 0, 0) and (0, i, 0)."""
    faces = [struct.pack("<12fH", 9, 9, 9, i, i, i, i + 1, 0, 0, 0, i, 0, 7) for i in range(count)]
    told = struct.pack("<I", count if said is None else said)
    return header.ljust(80, b"\0") + told + b"".join(faces) + more


def expected(count: int) -> list[list[list[float]]]:
    return [[[i, i, i], [i + 1, 0, 0], [0, i, 0]] for i in range(count)]


@pytest.mark.parametrize(
    "faces",
    ["f 1 2 3 4", "f 1/9 2/9/9 3//9 4", "f -4 -3 -2 -1", "f 1 2 3\nf 1 3 4", "f 1 -3 3 -1"],
)
def test_faces_name_corners_from_one_or_from_the_last(tmp_path: Path, faces: str) -> None:
    found = read(tmp_path, "a.obj", f"# plate\nvn 1 2 3\nvt 1 2\n{CORNERS}\n{faces}\nf 1 2\n")
    assert turned(found) == turned(FAN)


def test_a_corner_may_have_colours_after_its_place(tmp_path: Path) -> None:
    coloured = CORNERS.replace("\n", " 1 0 0\n") + " 1 0 0 1"
    assert turned(read(tmp_path, "A.OBJ", f"{coloured}\nf 1 2 3 4")) == turned(FAN)


def test_faces_count_back_from_the_corners_before_them(tmp_path: Path) -> None:
    later = "\nf -4 -3 -2\nv 5 5 5\nf -1 -5 -4"
    found = read(tmp_path, "a.obj", CORNERS + later)
    np.testing.assert_array_equal(found[0], SQUARE[:3])
    np.testing.assert_array_equal(found[1], [(5, 5, 5), SQUARE[0], SQUARE[1]])


def test_a_part_is_an_object_or_one_of_a_faces_groups(tmp_path: Path) -> None:
    text = f"{CORNERS}\no plate\nf 1 2 3\ng lid top\nf 1 3 4\ng\nf 2 3 4\n"
    counts = {
        part: len(read(tmp_path, "a.obj", text, part)) for part in ("", "plate", "lid", "top")
    }
    assert counts == {"": 3, "plate": 1, "lid": 1, "top": 1}
    assert turned(read(tmp_path, "a.obj", text, "top")) == turned(FAN[1:])
    assert read(tmp_path, "a.obj", text, "none").shape == (0, 3, 3)
    assert read(tmp_path, "a.stl", stl(2), "none").shape == (0, 3, 3)


@pytest.mark.parametrize("faces", ["f 0 1 2", "f 1 2 5", "f -5 1 2", "f 1 x 2"])
def test_faces_of_no_corner_are_refused(tmp_path: Path, faces: str) -> None:
    with pytest.raises(MeshError, match=r"a corner that does not exist|invalid literal"):
        read(tmp_path, "a.obj", f"{CORNERS}\n{faces}")


@pytest.mark.parametrize(
    ("content", "count"),
    [
        (stl(3), 3),
        (stl(3, more=b"trailer"), 3),
        (stl(3, said=2), 2),
        (stl(3, header=b"solid by CAD"), 3),  # binary all the same: its size says so
    ],
)
def test_binary_stl_is_known_by_its_size(tmp_path: Path, content: bytes, count: int) -> None:
    assert read(tmp_path, "a.stl", content).tolist() == expected(count)


@pytest.mark.parametrize("content", [stl(3)[:-1], stl(3, said=4), b"", b"\0" * 83])
def test_stl_that_is_cut_off_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(MeshError, match="cut off"):
        read(tmp_path, "a.stl", content)


@pytest.mark.parametrize("start", ["solid", "\n  solid name"])
def test_text_stl_holds_its_vertices_three_to_a_face(tmp_path: Path, start: str) -> None:
    loop = "facet normal 0 0 1\nouter loop\n{}\nendloop\nendfacet"
    corners = "\n".join(f"   vertex {x} {y} {z}" for x, y, z in FAN.reshape(-1, 3))
    found = read(tmp_path, "a.stl", f"{start}\n{loop.format(corners)}\nendsolid")
    assert turned(found) == turned(FAN)


def test_corners_end_at_a_thousand_million(tmp_path: Path) -> None:
    near, far = (CORNERS.replace("2.0", value) + "\nf 1 2 3 4" for value in ("-9.9e8", "-1e9"))
    assert len(read(tmp_path, "a.obj", near)) == 2
    with pytest.raises(MeshError, match="must be finite, below 1e9"):
        read(tmp_path, "a.obj", far)


@pytest.mark.parametrize(
    ("bound", "least", "problem"),
    [
        ("_BYTES_MAX", len(stl(3)), r"has 234 bytes; at most 233 are read"),
        ("_FACES_MAX", 3, r"has 3 triangles; at most 2 are read"),
    ],
)
def test_stl_of_the_most_that_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bound: str, least: int, problem: str
) -> None:
    monkeypatch.setattr(triangles, bound, least)
    assert len(read(tmp_path, "a.stl", stl(3))) == 3
    monkeypatch.setattr(triangles, bound, least - 1)
    with pytest.raises(MeshError, match=problem):
        read(tmp_path, "a.stl", stl(3))


def test_text_of_the_most_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = f"{CORNERS}\nf 1 2 3 4"
    for bound, least in (("_TEXT_MAX", len(text)), ("_LINES_MAX", 4), ("_FACES_MAX", 2)):
        with monkeypatch.context() as patch:
            patch.setattr(triangles, bound, least)
            assert len(read(tmp_path, "a.obj", text)) == 2
            patch.setattr(triangles, bound, least - 1)
            with pytest.raises(MeshError, match=r"valid: up to|at most 1 are read"):
                read(tmp_path, "a.obj", text)


def test_what_is_not_there_or_no_mesh_is_refused(tmp_path: Path) -> None:
    with pytest.raises(MeshError, match="cannot be read: No such file"):
        read_mesh(tmp_path / "none.stl")
    with pytest.raises(MeshError, match=r"has the form '.txt'; valid: .dae, .obj, .stl"):
        read(tmp_path, "a.txt", "")
    with pytest.raises(MeshError, match="has no triangles"):
        read(tmp_path, "a.obj", CORNERS)
