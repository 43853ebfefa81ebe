"""Claims: map_server and map_saver serve and write maps as Nav2's do, inside one folder only."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from nav2_msgs.srv import LoadMap, SaveMap
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.srv import GetMap
from rclpy.lifecycle import TransitionCallbackReturn

from arjuna_core.files.maps import load_map, save_map
from arjuna_core.grid import GridFrame, OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, grid_msg
from arjuna_core.se2 import SE2
from arjuna_slam.nodes.map_server import MapSaverNode, MapServerNode
from tests.helpers.ros import RosBench
from tests.nodes.slam.nodes import activated

FRAME = GridFrame(0.05, 4, 3, SE2(-1.0, 2.0, 0.3))
GRID = OccupancyGrid(FRAME, np.array([[0, 100, -1, 0], [0, 0, 0, 100], [-1, 0, 0, 0]], np.int8))
OTHER = OccupancyGrid(GridFrame(0.1, 2, 1), np.array([[0, 100]], np.int8))


@pytest.fixture
def server(bench: RosBench, tmp_path: Path) -> Any:
    path, _ = save_map(GRID, tmp_path / "first")
    return activated(bench, MapServerNode, yaml_filename=str(path), maps_folder=str(tmp_path))


def load(bench: RosBench, url: str) -> Any:
    return bench.call(LoadMap, "map_server/load_map", LoadMap.Request(map_url=url))


def assert_same(message: Any, grid: OccupancyGrid) -> None:
    received = grid_from_msg(message)
    np.testing.assert_array_equal(received.data, grid.data)
    assert received.frame.origin.distance(grid.frame.origin) < 1e-9
    assert received.frame.resolution == grid.frame.resolution


def test_a_late_subscriber_and_the_service_get_the_map(bench: RosBench, server: Any) -> None:
    (message,) = bench.latched(OccupancyGridMsg, "map")
    assert message.header.frame_id == "map"
    assert_same(message, GRID)
    assert_same(bench.call(GetMap, "map_server/map", GetMap.Request()).map, GRID)


def test_load_map_refuses_or_replaces_the_map(bench: RosBench, server: Any, tmp_path: Path) -> None:
    (tmp_path / "broken.yaml").write_text("image: 3\n")
    for url, result in (
        ("none.yaml", LoadMap.Response.RESULT_MAP_DOES_NOT_EXIST),
        ("broken.yaml", LoadMap.Response.RESULT_INVALID_MAP_METADATA),
        ("../outside.yaml", LoadMap.Response.RESULT_UNDEFINED_FAILURE),
        ("/etc/passwd", LoadMap.Response.RESULT_UNDEFINED_FAILURE),
        ("package://maps/first.yaml", LoadMap.Response.RESULT_UNDEFINED_FAILURE),
        ("", LoadMap.Response.RESULT_UNDEFINED_FAILURE),
    ):
        assert load(bench, url).result == result
        assert_same(bench.call(GetMap, "map_server/map", GetMap.Request()).map, GRID)
    save_map(OTHER, tmp_path / "second")
    received = bench.latched(OccupancyGridMsg, "map")
    second = f"{tmp_path}/second.yaml"
    for url, grid in (("second.yaml", OTHER), ("first.yaml", GRID), (f"file://{second}", OTHER)):
        response = load(bench, url)
        assert response.result == LoadMap.Response.RESULT_SUCCESS
        assert_same(response.map, grid)
        assert_same(received[-1], grid)
    assert load(bench, second).result == LoadMap.Response.RESULT_SUCCESS


def test_without_a_map_it_waits_for_load_map(bench: RosBench, tmp_path: Path) -> None:
    save_map(GRID, tmp_path / "first")
    activated(bench, MapServerNode, maps_folder=str(tmp_path))
    assert bench.collect(OccupancyGridMsg, "map", qos.LATCHED) == []
    assert load(bench, "first.yaml").result == LoadMap.Response.RESULT_SUCCESS
    assert_same(bench.call(GetMap, "map_server/map", GetMap.Request()).map, GRID)


def test_a_missing_map_refuses_the_configuration(bench: RosBench, tmp_path: Path) -> None:
    node = MapServerNode(bench.process, {"yaml_filename": str(tmp_path / "none.yaml")})
    assert node.trigger_configure() == TransitionCallbackReturn.FAILURE


def asked_to_save(bench: RosBench, **request: Any) -> Any:
    client = bench.node.create_client(SaveMap, "map_saver/save_map")
    future = client.call_async(SaveMap.Request(**request))
    bench.process.drain()
    return future


def save(bench: RosBench, **request: Any) -> bool:
    future = asked_to_save(bench, **request)
    if not future.done():
        bench.advance(2.3)  # it waits for a map
    return bool(future.result().result)


def test_save_map_writes_what_was_on_the_topic(bench: RosBench, tmp_path: Path) -> None:
    activated(bench, MapSaverNode, maps_folder=str(tmp_path), free_thresh_default=0.1)
    bench.publish(OccupancyGridMsg, "map", grid_msg(GRID, "map", 0.0), qos.LATCHED)
    assert save(bench, map_url="sub/room", image_format="png", map_mode="trinary")
    assert "free_thresh: 0.1\n" in (tmp_path / "sub" / "room.yaml").read_text()
    loaded = load_map(tmp_path / "sub" / "room.yaml")
    np.testing.assert_array_equal(loaded.data, GRID.data)
    assert loaded.frame.origin.distance(FRAME.origin) < 1e-9
    assert loaded.frame.origin.theta == pytest.approx(0.3)
    assert save(bench, map_url=str(tmp_path / "other"), map_topic="map")
    assert (tmp_path / "other.pgm").exists()


def test_save_map_refuses_and_writes_nothing(bench: RosBench, tmp_path: Path) -> None:
    folder = tmp_path / "maps"
    activated(bench, MapSaverNode, maps_folder=str(folder))
    assert not save(bench, map_url="room")  # no map has come
    bench.publish(OccupancyGridMsg, "map", grid_msg(GRID, "map", 0.0), qos.LATCHED)
    refused: list[dict[str, Any]] = [
        {"map_url": "../room"},
        {"map_url": "/tmp/elsewhere"},
        {"map_url": "room", "image_format": "jpg"},
        {"map_url": "room", "map_mode": "grey"},
        {"map_url": "room", "free_thresh": 0.9, "occupied_thresh": 0.3},
        *({"map_url": "room", "map_topic": t} for t in ("other_map", "parameter_events", "no//")),
    ]
    for request in refused:
        assert not save(bench, **request), request
    assert not bench.process.guard.tallies
    assert not folder.exists()
    for topic in ("map", "/map", ""):
        assert save(bench, map_url="room", map_topic=topic)


@pytest.mark.parametrize(("timeout", "saved"), [(0.3, False), (1.0, True)])
@pytest.mark.parametrize("topic", ["map", "local_map"])
def test_a_map_is_waited_for_up_to_the_timeout(
    bench: RosBench, tmp_path: Path, topic: str, timeout: float, saved: bool
) -> None:
    values = {"maps_folder": str(tmp_path), "save_map_timeout": timeout}
    activated(bench, MapSaverNode, **values)
    future = asked_to_save(bench, map_url="late", map_topic=topic)
    bench.advance(0.6)
    assert future.done() is not saved
    bench.publish(OccupancyGridMsg, topic, grid_msg(OTHER, "map", 0.0), qos.LATCHED)
    assert future.result().result is saved
    assert (tmp_path / "late.yaml").exists() is saved


@pytest.mark.parametrize("how", ["deactivate", "set_back"])
def test_waiting_clients_are_always_answered(bench: RosBench, tmp_path: Path, how: str) -> None:
    saver = activated(bench, MapSaverNode, maps_folder=str(tmp_path))
    bench.advance(0.5)
    future = asked_to_save(bench, map_url="late")
    if how == "deactivate":
        saver.trigger_deactivate()
    else:
        bench.set_back()
    bench.process.drain()
    assert future.result().result is False


def test_a_latched_map_of_another_topic_is_saved_at_once(bench: RosBench, tmp_path: Path) -> None:
    activated(bench, MapSaverNode, maps_folder=str(tmp_path))
    bench.publish(OccupancyGridMsg, "local_map", grid_msg(OTHER, "map", 0.0), qos.LATCHED)
    assert asked_to_save(bench, map_url="local", map_topic="local_map").result().result
    np.testing.assert_array_equal(load_map(tmp_path / "local.yaml").data, OTHER.data)


def test_the_saver_can_be_cleaned_up_and_started_again(bench: RosBench, tmp_path: Path) -> None:
    saver = activated(bench, MapSaverNode, maps_folder=str(tmp_path))
    for step in ("deactivate", "cleanup", "configure"):
        assert getattr(saver, f"trigger_{step}")() == TransitionCallbackReturn.SUCCESS
        bench.process.drain()
    bench.publish(OccupancyGridMsg, "map", grid_msg(GRID, "map", 0.0), qos.LATCHED)
    assert not save(bench, map_url="room")  # inactive
    saver.trigger_activate()
    assert save(bench, map_url="room")


def test_maps_are_saved_later_through_the_middleware_too(tmp_path: Path) -> None:
    bench = RosBench(transport="dds")
    saver = activated(bench, MapSaverNode, maps_folder=str(tmp_path), save_map_timeout=1.0)
    client = bench.node.create_client(SaveMap, "map_saver/save_map")
    bench.until(client.service_is_ready, "save_map")
    refused, saved = (
        client.call_async(SaveMap.Request(map_url="late", free_thresh=free))
        for free in (float("nan"), 0.0)
    )
    bench.until(refused.done, "a request that cannot be used is refused")
    assert refused.result().result is False
    assert not saved.done()
    bench.publish(OccupancyGridMsg, "map", grid_msg(OTHER, "map", 0.0), qos.LATCHED)
    bench.until(saved.done, "the map is saved")
    assert saved.result().result is True
    saver.trigger_deactivate()
    saver.trigger_cleanup()
    bench.close()
