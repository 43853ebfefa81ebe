"""map_server: a map from a file, latched on a topic."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from nav2_msgs.srv import LoadMap
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from nav_msgs.srv import GetMap

from arjuna_core.config import param
from arjuna_core.errors import MapError
from arjuna_core.files.maps import load_map
from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.files.shipped import shipped_file
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg
from arjuna_core.ros.node import ManagedNode


@dataclass(frozen=True)
class MapServerConfig:
    """Parameters of map_server."""

    yaml_filename: str = param("", "Map to serve; none until load_map if empty.")
    topic_name: str = param("map", "Topic of the map.", read_only=True)
    frame_id: str = param("map", "Frame of the map.")
    maps_folder: str = param(".", "Folder that load_map's relative paths are of.")


class MapServerNode(ManagedNode):
    """Publishes a map and hands it out on request, as nav2_map_server does."""

    Config: ClassVar[type[Any]] = MapServerConfig
    DEFAULT_NAME = "map_server"

    def configure(self) -> None:
        """Read the map and offer it."""
        name: str = self.config.yaml_filename
        self._map: OccupancyGrid | None = self._load(_find(name)) if name else None
        self._publisher = self.publisher(OccupancyGridMsg, self.config.topic_name, qos.LATCHED)
        self.serve(GetMap, f"{self.get_name()}/map", self._on_get)
        self.serve(LoadMap, f"{self.get_name()}/load_map", self._on_load)

    def activate(self) -> None:
        """Publish the map."""
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
    """Return the map of that path, else the shipped one."""
    return Path(name) if Path(name).exists() else shipped_file(name)


def _result_if_refused(path: Path) -> int:
    """Return the result code that tells a missing file from a broken one."""
    if not path.exists():
        return int(LoadMap.Response.RESULT_MAP_DOES_NOT_EXIST)
    return int(LoadMap.Response.RESULT_INVALID_MAP_METADATA)
