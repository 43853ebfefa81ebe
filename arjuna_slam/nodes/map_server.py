"""map_server, map_saver and costmap_filter_info_server: maps and what their masks mean."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from nav2_msgs.msg import CostmapFilterInfo
from nav2_msgs.srv import LoadMap, SaveMap
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.srv import GetMap
from rclpy.exceptions import InvalidTopicNameException
from rclpy.impl.implementation_singleton import rclpy_implementation

from arjuna_core.config import duration_param, fixed, param, share_param
from arjuna_core.errors import MapError
from arjuna_core.files.map_image import MODES, MapOptions
from arjuna_core.files.maps import load_map, save_map, unnamed
from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_from_msg, grid_msg, header
from arjuna_core.ros.node import ManagedNode


@dataclass(frozen=True)
class MapServerConfig:
    """Parameters of map_server."""

    yaml_filename: str = param("", "Map to serve; none until load_map if empty.", path=True)
    topic_name: str = fixed("map", "Topic of the map.")
    frame_id: str = param("map", "Frame of the map.")
    maps_folder: str = param(".", "Folder that load_map's relative paths are of.", path=True)


class MapServerNode(ManagedNode):
    """Publishes a map and hands it out on request, as nav2_map_server does."""

    Config: ClassVar[type[Any]] = MapServerConfig
    DEFAULT_NAME = "map_server"

    def configure(self) -> None:
        name: str = self.config.yaml_filename
        self._map: OccupancyGrid | None = self._load(_find(name)) if name else None
        self._publisher = self.publisher(OccupancyGridMsg, self.config.topic_name, qos.LATCHED)
        self.serve(GetMap, f"{self.get_name()}/map", self._on_get)
        self.serve(LoadMap, f"{self.get_name()}/load_map", self._on_load)

    def activate(self) -> None:
        if self._map is None:
            self.get_logger().info("no yaml_filename is set: waiting for load_map")
        else:
            self._publisher.publish(self._message(self._map))

    def _load(self, path: Path) -> OccupancyGrid:
        return replace(load_map(path, self.get_logger().warning), stamp=self.now)

    def _message(self, grid: OccupancyGrid) -> OccupancyGridMsg:
        return grid_msg(grid, self.config.frame_id, self.now)

    def _on_get(self, request: Any, response: Any) -> Any:
        if self.active and self._map is not None:
            response.map = self._message(self._map)
        else:
            self.get_logger().warning("map requested, but none is loaded or the node is inactive")
        return response

    def _on_load(self, request: Any, response: Any) -> Any:
        response.result = LoadMap.Response.RESULT_UNDEFINED_FAILURE
        if not self.active:
            self.get_logger().warning("load_map requested, but the node is inactive")
            return response
        try:
            path = map_path(self.config.maps_folder, request.map_url)
            response.result = _result_if_refused(path)
            self._map = self._load(path)
        except (MapError, MapsFolderError) as error:
            self.get_logger().error(str(error))
            return response
        response.map = self._message(self._map)
        response.result = LoadMap.Response.RESULT_SUCCESS
        self._publisher.publish(response.map)
        return response


def _find(name: str) -> Path:
    return Path(name) if Path(name).exists() else shipped_file(name)


def _result_if_refused(path: Path) -> int:
    if not path.exists():
        return int(LoadMap.Response.RESULT_MAP_DOES_NOT_EXIST)
    return int(LoadMap.Response.RESULT_INVALID_MAP_METADATA)


@dataclass(frozen=True)
class MapSaverConfig:
    """Parameters of map_saver."""

    free_thresh_default: float = share_param(
        0.25, "Occupancy up to which a cell is free, if unasked."
    )
    occupied_thresh_default: float = share_param(
        0.65, "Occupancy from which a cell is occupied, if unasked."
    )
    map_subscribe_transient_local: bool = fixed(True, "Whether maps published before are wanted.")
    save_map_timeout: float = duration_param(2.0, "How long save_map waits for a topic's map.")
    maps_folder: str = param(".", "Folder that save_map's relative paths are of.", path=True)


class _Waiting(NamedTuple):
    topic: str
    request: Any
    respond: Callable[[Any], None]
    until: float


class MapSaverNode(ManagedNode):
    """Writes maps, as nav2_map_server's map_saver_server does.

    It listens to `map` from the start, to another topic once that was asked for.
    """

    Config: ClassVar[type[Any]] = MapSaverConfig
    DEFAULT_NAME = "map_saver"

    def configure(self) -> None:
        self._maps: dict[str, OccupancyGridMsg] = {}
        self._topics: set[str] = set()
        self._waiting: list[_Waiting] = []
        self._listen(self.full_topic("map"))
        self.serve_later(SaveMap, f"{self.get_name()}/save_map", self._on_save)
        self.every(0.1, self._give_up)  # [s]

    def deactivate(self) -> None:
        self._refuse(self._waiting, "the node is inactive")

    def on_time_jump(self) -> None:
        self._refuse(getattr(self, "_waiting", []), "time was set back")

    def _listen(self, topic: str) -> None:
        profile = qos.LATCHED if self.config.map_subscribe_transient_local else qos.LATEST

        def keep(message: Any) -> None:
            self._maps[topic] = message
            for each in [each for each in self._waiting if each.topic == topic]:
                self._waiting.remove(each)
                each.respond(SaveMap.Response(result=self._save(message, each.request)))

        self.subscribe(OccupancyGridMsg, topic, keep, profile, while_inactive=True)
        self._topics.add(topic)

    def _on_save(self, request: Any, respond: Callable[[Any], None]) -> None:
        problem, topic = "", ""
        try:
            topic = self.full_topic(request.map_topic or "map")
            if self.active and topic not in self._topics:
                self._listen(topic)
        except (InvalidTopicNameException, rclpy_implementation.RCLError) as error:
            problem = f"{request.map_topic[:80]!r} is no topic, or not of maps: {error}"
        if not self.active:
            problem = "save_map requested, but the node is inactive"
        until = self.now + self.config.save_map_timeout
        waiting = _Waiting(topic, request, respond, until)
        if problem:
            self._refuse([waiting], problem)
        elif topic in self._maps:
            respond(SaveMap.Response(result=self._save(self._maps[topic], request)))
        else:
            self._waiting.append(waiting)

    def _give_up(self) -> None:
        late = [each for each in self._waiting if self.now > each.until]
        limit = self.config.save_map_timeout
        for each in late:
            self._refuse([each], f"no map has come on '{each.topic}' within {limit:g} s")

    def _refuse(self, waiting: Iterable[_Waiting], problem: str) -> None:
        for each in list(waiting):
            if each in self._waiting:
                self._waiting.remove(each)
            self.get_logger().error(problem)
            each.respond(SaveMap.Response(result=False))

    def _save(self, message: OccupancyGridMsg, request: Any) -> bool:
        options = MapOptions(
            request.map_mode or MODES[0],
            occupied_thresh=_given(request.occupied_thresh, self.config.occupied_thresh_default),
            free_thresh=_given(request.free_thresh, self.config.free_thresh_default),
        )
        image_format = request.image_format or ("png" if options.mode == "scale" else "pgm")
        try:
            stem = map_path(self.config.maps_folder, request.map_url or unnamed(self.now))
            path, _ = save_map(grid_from_msg(message), stem, image_format, options)
        except (MapError, MapsFolderError, ValueError) as error:
            self.get_logger().error(str(error))
            return False
        self.get_logger().info(f"map saved to {path}")
        return True


def _given(asked: float, default: float) -> float:
    """Return what was asked for; zero on the wire means nothing was. Undoes float32's rounding."""
    return round(asked, 6) if asked > 0.0 else default


@dataclass(frozen=True)
class FilterInfoServerConfig:
    """Parameters of costmap_filter_info_server, by Nav2's names."""

    filter_info_topic: str = fixed("costmap_filter_info", "Topic of what it says.")
    type: int = fixed(
        0, "0 keeps out, 1 limits speed in %, 2 in m/s, 3 switches.", minimum=0, maximum=255
    )
    mask_topic: str = fixed("filter_mask", "Topic of the mask.")
    base: float = fixed(0.0, "Added to a value of the mask times the multiplier.")
    multiplier: float = fixed(1.0, "Of a value of the mask.")


class FilterInfoServerNode(ManagedNode):
    """Publishes, latched, where a mask is and what it means.

    Source: nav2_map_server, CostmapFilterInfoServer.
    """

    Config: ClassVar[type[Any]] = FilterInfoServerConfig
    DEFAULT_NAME = "costmap_filter_info_server"

    def configure(self) -> None:
        topic = self.config.filter_info_topic
        self._publisher = self.publisher(CostmapFilterInfo, topic, qos.LATCHED)

    def activate(self) -> None:
        config: FilterInfoServerConfig = self.config
        self._publisher.publish(
            CostmapFilterInfo(
                header=header("map", self.now),
                type=config.type,
                filter_mask_topic=self.process.absolute(config.mask_topic),
                base=config.base,
                multiplier=config.multiplier,
            )
        )
