"""Maps written, read and looked for."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from numpy.typing import NDArray
from PIL import Image

from arjuna_core.errors import MapError
from arjuna_core.files.map_image import MODES, MapOptions
from arjuna_core.files.maps import FORMATS, load_map, save_map
from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.se2 import SE2

FRAME = GridFrame(0.05, 7, 4, SE2(-1.25, 2.5, 0.3))
TRINARY = np.array([[-1, 0, 100, 0, 0, 100, -1]] * 3 + [[0, 0, 0, 100, 100, -1, -1]], np.int8)
GRADED = np.arange(28, dtype=np.int8).reshape(4, 7) * 3
GRADED[3] = (0, 1, 2, 26, 65, 99, 100)


@pytest.mark.parametrize("negate", [False, True])
@pytest.mark.parametrize("image_format", FORMATS)
@pytest.mark.parametrize("mode", MODES)
def test_a_map_reads_back_as_it_was(
    tmp_path: Path, mode: str, image_format: str, negate: bool
) -> None:
    data = TRINARY if mode == "trinary" else GRADED
    grid = OccupancyGrid(FRAME, data)
    paths = save_map(grid, tmp_path / "map", image_format, MapOptions(mode, negate))
    assert [path.name for path in paths] == ["map.yaml", f"map.{image_format}"]
    loaded = load_map(paths[0])
    assert loaded.frame == FRAME
    np.testing.assert_array_equal(loaded.data, data)


@pytest.mark.parametrize(
    ("mode", "image_format"), [("raw", "pgm"), ("raw", "png"), ("raw", "bmp"), ("scale", "png")]
)
@pytest.mark.parametrize("negate", [False, True])
def test_unknown_cells_read_back_beside_graded_ones(
    tmp_path: Path, mode: str, image_format: str, negate: bool
) -> None:
    data = GRADED.copy()
    data[0] = -1
    grid = OccupancyGrid(FRAME, data)
    path, _ = save_map(grid, tmp_path / "map", image_format, MapOptions(mode, negate))
    np.testing.assert_array_equal(load_map(path).data, data)


def test_trinary_decides_by_the_thresholds_and_leaves_the_rest_unknown(tmp_path: Path) -> None:
    data = np.array([[0, 25, 26, 64, 65, 100, -1]], np.int8)
    grid = OccupancyGrid(GridFrame(0.1, 7, 1), data)
    path, _ = save_map(grid, tmp_path / "map")
    assert load_map(path).data.tolist() == [[0, 0, -1, -1, 100, 100, -1]]


def test_the_top_row_of_the_image_is_highest_in_y(tmp_path: Path) -> None:
    data = np.zeros((3, 2), np.int8)
    data[2, 0] = 100
    _, image = save_map(OccupancyGrid(GridFrame(1.0, 2, 3), data), tmp_path / "map")
    pixels = np.asarray(Image.open(image))
    assert pixels[0, 0] == 0
    assert pixels[2, 0] == 254


def test_nav2s_own_shades_read_as_map_server_reads_them(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 89, 90, 191, 192, 205, 254, 255]], np.uint8)).save(
        tmp_path / "m.pgm"
    )
    header = {"image": "m.pgm", "resolution": 0.05, "origin": [0, 0, 0]}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(header))
    assert load_map(tmp_path / "m.yaml").data.tolist() == [[100, 100, -1, -1, 0, 0, 0, 0]]
    (tmp_path / "m.yaml").write_text(yaml.safe_dump({**header, "free_thresh": 0.196}))
    assert load_map(tmp_path / "m.yaml").data.tolist() == [[100, 100, -1, -1, -1, -1, 0, 0]]


def test_saving_leaves_no_partial_files_and_overwrites(tmp_path: Path) -> None:
    save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "new" / "map")
    save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "new" / "map")
    assert sorted(path.name for path in (tmp_path / "new").iterdir()) == ["map.pgm", "map.yaml"]


def test_saving_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    grid = OccupancyGrid(FRAME, TRINARY)
    with pytest.raises(MapError, match="image format 'jpg' is unknown; valid: pgm, png, bmp"):
        save_map(grid, tmp_path / "map", "jpg")
    with pytest.raises(MapError, match="no shade for unknown in a pgm image; valid: png"):
        save_map(grid, tmp_path / "map", "pgm", MapOptions("scale"))
    with pytest.raises(MapError, match="mode 'grey' is unknown; valid: trinary, scale, raw"):
        save_map(grid, tmp_path / "map", "pgm", MapOptions("grey"))
    with pytest.raises(MapError, match="thresholds: must be 0 <= free_thresh < occupied_thresh"):
        save_map(grid, tmp_path / "map", "pgm", MapOptions(free_thresh=0.7))
    empty = OccupancyGrid(GridFrame(0.05, 0, 0), np.zeros((0, 0), np.int8))
    with pytest.raises(MapError, match="the map is empty"):
        save_map(empty, tmp_path / "map")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    with pytest.raises(MapError, match="cannot be written"):
        save_map(grid, tmp_path / "file" / "map")


Edit = Callable[[dict[str, Any]], Any]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda h: h.update(resolution=0), "resolution: must be positive, got 0.0"),
        (lambda h: h.update(resolution=-0.05), "resolution: must be positive, got -0.05"),
        (lambda h: h.update(resolution="x"), "resolution: must be a finite number, got 'x'"),
        (lambda h: h.update(resolution=True), "resolution: must be a finite number, got True"),
        (lambda h: h.update(origin=[0, 0]), "origin: must be a list [x, y, yaw], got [0, 0]"),
        (lambda h: h.update(origin=[0, 0, float("nan")]), "origin: must be a finite number"),
        (lambda h: h.update(mode="grey"), "mode: is 'grey'; valid: trinary, scale, raw"),
        (lambda h: h.update(negate=2), "negate: is 2; valid: 0, 1"),
        (lambda h: h.update(free_thresh=0.8), "must be 0 <= free_thresh <= occupied_thresh <= 1"),
        (lambda h: h.update(occupied_thresh=1.5), "must be 0 <= free_thresh <= occupied_"),
        (lambda h: h.update(occupied_thresh="a"), "occupied_thresh: must be a finite number"),
        (lambda h: h.update(image=""), "image: must be a file name, got ''"),
        (lambda h: h.update(image="no.pgm"), "no.pgm does not exist"),
        (lambda h: h.update(image="/home/me/map.pgm"), "exist; beside the YAML lies 'map.pgm'"),
        (lambda h: h.update(image="C:\\maps\\map.pgm"), "exist; beside the YAML lies 'map.pgm'"),
        (lambda h: h.update(image="map.yaml"), "is no readable PGM or PNG image"),
        (lambda h: h.pop("origin"), "lacks the key 'origin'; required: image, resolution, origin"),
    ],
)
def test_a_bad_header_is_refused_with_its_reason(tmp_path: Path, edit: Edit, message: str) -> None:
    path, _ = save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "map")
    header = yaml.safe_load(path.read_text())
    edit(header)
    path.write_text(yaml.safe_dump(header))
    with pytest.raises(MapError, match=re.escape(message)) as caught:
        load_map(path)
    assert str(tmp_path) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"- 1\n- 2\n", "is no map: it must have the keys image, resolution, origin"),
        (b"", "is no map"),
        (b"image: [\n", "YAML: "),
        (b"\xff\xfe\x00", "is no UTF-8 text"),
        (b"!!python/object/apply:os.system ['true']", "YAML: "),
    ],
)
def test_a_file_that_is_no_map_is_refused(tmp_path: Path, content: bytes, message: str) -> None:
    (tmp_path / "map.yaml").write_bytes(content)
    with pytest.raises(MapError, match=re.escape(message)):
        load_map(tmp_path / "map.yaml")


def test_an_unknown_key_of_a_map_is_passed_over_with_a_warning(tmp_path: Path) -> None:
    path, _ = save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "map")
    path.write_text(f"{path.read_text()}\nmodes: raw\n")
    warned: list[str] = []
    assert load_map(path, warned.append).frame == FRAME
    assert warned == [f"{path}: unknown key 'modes'; the nearest is 'mode'"]


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(
        MapError, match=r"none\.yaml: cannot be read: No such file or directory; 'save-map' writes"
    ):
        load_map(tmp_path / "none.yaml")


@pytest.mark.parametrize("keep", [5, 40])
def test_a_truncated_image_is_refused(tmp_path: Path, keep: int) -> None:
    path, image = save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "map", "png")
    image.write_bytes(image.read_bytes()[:keep])
    with pytest.raises(MapError, match="is no readable PGM or PNG image"):
        load_map(path)


GREYS = np.array([[0, 100, 180, 210, 255]])
COLOURS = np.array([[[0, 0, 0], [0, 255, 0], [255, 255, 0], [250, 200, 180], [255, 255, 255]]])


@pytest.mark.parametrize(
    ("pixels", "mode", "cells"),
    [
        (GREYS.astype(np.uint8), "trinary", [100, -1, -1, 0, 0]),
        ((GREYS * 257).astype(np.uint16), "trinary", [100, -1, -1, 0, 0]),
        ((GREYS * 257).astype(np.uint16), "scale", [100, 91, 22, 0, 0]),
        ((GREYS * 257).astype(np.uint16), "raw", [0, 100, -1, -1, -1]),
        (COLOURS.astype(np.uint8), "trinary", [100, 100, -1, 0, 0]),
        (COLOURS.astype(np.uint8), "Scale", [100, 100, 30, 0, 0]),
        (COLOURS.astype(np.uint8), "raw", [0, 85, -1, -1, -1]),
    ],
)
def test_greys_of_16_bits_and_colours_read_as_map_server_reads_them(
    pixels: NDArray[np.uint8], mode: str, cells: list[int], tmp_path: Path
) -> None:
    Image.fromarray(pixels).save(tmp_path / "m.png")
    header = {"image": "m.png", "resolution": "0.05", "origin": [0, 0, "0"], "mode": mode}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump({**header, "free_thresh": 0.196}))
    assert load_map(tmp_path / "m.yaml").data.tolist() == [cells]


def test_a_palette_with_transparency_has_alpha_and_thresholds_may_be_one(tmp_path: Path) -> None:
    image = Image.new("P", (2, 1), 1)
    image.putpalette([0, 0, 0, 255, 255, 255])
    image.putpixel((0, 0), 0)
    image.save(tmp_path / "m.png", transparency=1)
    header = {"image": "m.png", "resolution": 0.05, "origin": [0, 0, 0], "mode": "scale"}
    header |= {"free_thresh": 0.5, "occupied_thresh": 0.5}
    (tmp_path / "m.yaml").write_text(yaml.safe_dump(header))
    assert load_map(tmp_path / "m.yaml").data.tolist() == [[100, -1]]


@pytest.mark.parametrize("ending", ["yaml", "png"])
def test_a_file_of_something_else_is_not_overwritten(tmp_path: Path, ending: str) -> None:
    foreign = tmp_path / f"notes.{ending}"
    foreign.write_bytes(b"name: mine")
    with pytest.raises(MapError, match="it is not overwritten; choose another name"):
        save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "notes", "png")
    assert foreign.read_bytes() == b"name: mine"
    assert list(tmp_path.iterdir()) == [foreign]


@pytest.mark.parametrize("image_format", ["pgm", "png"])
def test_a_map_is_overwritten_even_without_its_image(tmp_path: Path, image_format: str) -> None:
    for _ in range(2):
        _, image = save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "room", image_format)
    image.unlink()
    save_map(OccupancyGrid(FRAME, TRINARY), tmp_path / "room", image_format)
    np.testing.assert_array_equal(load_map(tmp_path / "room.yaml").data, TRINARY)


@pytest.fixture
def folders(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Folders `maps`, `home` and `work` side by side, with links between them and out."""
    root = tmp_path.resolve()
    for name in ("maps", "home/.ssh", "work", "elsewhere"):
        (root / name).mkdir(parents=True)
    (root / "home/out").symlink_to(root / "elsewhere")
    (root / "home/in").symlink_to(root / "work")
    (root / "work/room.posegraph").symlink_to(root / "elsewhere/room.posegraph")
    monkeypatch.setenv("HOME", str(root / "home"))
    monkeypatch.chdir(root / "work")
    return root


@pytest.mark.parametrize(
    ("url", "expected"),
    [
        ("a/b", "maps/a/b"),
        ("../home/a", "home/a"),
        ("~/a", "home/a"),
        ("{root}/home/a", "home/a"),
        ("file://{root}/work/a", "work/a"),
        ("~/in/a", "work/a"),
        (".hidden", "maps/.hidden"),
        ("../work/a.b", "work/a.b"),
    ],
)
def test_a_path_is_found(folders: Path, url: str, expected: str) -> None:
    assert map_path(folders / "maps", url.format(root=folders)) == folders / expected


@pytest.mark.parametrize(
    "url",
    ["/etc/passwd", "../elsewhere/a", "~/out/a", "~/.ssh/id", "~/.bashrc", "~/", "..", "~/../a"],
)
def test_a_path_elsewhere_is_refused(folders: Path, url: str) -> None:
    with pytest.raises(MapsFolderError, match=r"is no place for maps; valid: paths in .*/maps, "):
        map_path(folders / "maps", url)


def test_a_suffix_is_added_once_and_links_are_followed_after_it(folders: Path) -> None:
    for name in ("a", "a.posegraph"):
        found = map_path(folders / "maps", name, ".posegraph")
        assert found == folders / "maps/a.posegraph"
    with pytest.raises(MapsFolderError, match="is no place for maps"):
        map_path(folders / "maps", "~/../work/room", ".posegraph")


def test_the_whole_disk_is_no_home(folders: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", "/")
    monkeypatch.chdir("/")
    with pytest.raises(MapsFolderError, match=r"valid: paths in .*/maps, none of them hidden"):
        map_path(folders / "maps", "/etc/passwd")
