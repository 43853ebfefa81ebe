"""Claims: cells become pixels by RViz's colours, and pixels a rectangle that a browser reads."""

from __future__ import annotations

import io
import json
import struct

import numpy as np
import pytest
import trimesh
from PIL import Image

from arjuna_core.grid import GridFrame, OccupancyGrid
from bringup.viewing.drawing import textures


def grid(rows: list[list[int]]) -> OccupancyGrid:
    data = np.array(rows, dtype=np.int8)
    return OccupancyGrid(GridFrame(0.5, data.shape[1], data.shape[0]), data)


def picture_of(glb: bytes) -> Image.Image:
    scene = trimesh.load_scene(io.BytesIO(glb), file_type="glb")
    (mesh,) = scene.geometry.values()
    picture: Image.Image = mesh.visual.material.baseColorTexture
    return picture


def test_a_map_shows_free_light_occupied_black_and_its_highest_row_first() -> None:
    glb = textures.map_glb(grid([[0, 100], [-1, -1]]), 1.0, 1.0)
    pixels = np.asarray(picture_of(glb).convert("RGB"))
    assert pixels[1].tolist() == [[250, 250, 250], [0, 0, 0]]
    assert pixels[0].tolist() == [[128, 144, 140]] * 2


def test_a_costmap_is_clear_where_it_is_free_or_unknown() -> None:
    pixels = textures.cost_pixels(grid([[0, -1, 50, 99, 100]]), 0.5)[0, ::4]
    assert pixels[:2, 3].tolist() == [0, 0]
    assert pixels[2:, 3].tolist() == [128] * 3
    assert pixels[3:, :3].tolist() == [[0, 255, 255], [255, 0, 255]]


def test_costs_redden_as_they_grow() -> None:
    costs = textures.cost_pixels(grid([list(range(1, 99))]), 1.0)[0, ::4].astype(int)
    assert (np.diff(costs[:, 0]) > 0).all()
    assert (np.diff(costs[:, 2]) < 0).all()


def test_a_small_grid_is_enlarged_and_keeps_its_lowest_row_first() -> None:
    pixels = textures.cost_pixels(grid([[100, 0], [0, 0]]), 1.0)
    assert pixels.shape == (8, 8, 4)
    assert pixels[:4, :4, 3].all()
    assert pixels[:, :, 3].sum() == 16 * 255


def test_a_grid_too_large_for_a_texture_loses_no_wall() -> None:
    data = np.zeros((3, 2 * textures.MAX_TEXTURE + 1), dtype=np.int8)
    data[1, 5], data[0, :] = 100, -1
    thin = textures.thinned(data)
    assert thin.shape == (1, -(-data.shape[1] // 3))
    assert np.flatnonzero(thin[0] == 100).tolist() == [1]


def test_a_map_is_glTF_that_trimesh_reads_unlit_and_with_sharp_cells() -> None:
    glb = textures.map_glb(grid([[0, 100]]), 3.0, 2.0)
    scene = trimesh.load_scene(io.BytesIO(glb), file_type="glb")
    assert scene.bounds == pytest.approx(np.array([[0, 0, 0], [3, 2, 0]]))
    assert picture_of(glb).size == (2, 1)
    (mesh,) = scene.geometry.values()
    assert mesh.visual.uv * (3, 2) == pytest.approx(mesh.vertices[:, :2])
    (length,) = struct.unpack_from("<I", glb, 12)
    document = json.loads(glb[20 : 20 + length])
    assert document["materials"][0]["extensions"] == {"KHR_materials_unlit": {}}
    assert document["samplers"][0]["magFilter"] == 9728
    assert struct.unpack_from("<I", glb, 8)[0] == len(glb)
