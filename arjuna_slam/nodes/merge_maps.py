"""map_merging: saved graphs that are put beside each other by hand, and made one map.

Source: slam_toolbox, merge_maps_kinematic; its services, topics, frames and markers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from nav_msgs.msg import MapMetaData
from nav_msgs.msg import OccupancyGrid as OccupancyGridMsg
from slam_toolbox.srv import AddSubmap, MergeMaps
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import InteractiveMarkerFeedback, InteractiveMarkerUpdate
from visualization_msgs.srv import GetInteractiveMarkers

from arjuna_core.config import fixed, length_param, param
from arjuna_core.errors import ConfigError
from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.grid import OccupancyGrid
from arjuna_core.ros import qos
from arjuna_core.ros.convert import grid_msg, header, se2_from_pose, transform_msg
from arjuna_core.ros.node import ManagedNode
from arjuna_core.ros.tf import transforms_msg
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.keyframes import Keyframes
from arjuna_slam.mapping.session import SUFFIX, Session, SessionFileError, load_session
from arjuna_slam.nodes.slam_interactive import handle

_TOOL = "merge_maps_tool"
_SIZE = 2.0  # diameter of a map's handle [m]


@dataclass(frozen=True)
class MergeMapsConfig:
    """Parameters of `map_merging`."""

    resolution: float = length_param(0.05, "Edge of a map's cell.", minimum=0.01, maximum=1.0)
    max_laser_range: float = length_param(25.0, "Longest range drawn.", minimum=0.1)
    map_frame: str = fixed("map", "Frame of the merged map.")
    maps_folder: str = param(".", "Folder that add_submap's relative paths are of.", path=True)


@dataclass
class Submap:
    """A saved graph.

    Attributes:
        centre: Pose in its graph's frame of the frame in which its map is shown, its middle.
        pose: Pose of that frame in the merged map, as it was last put.
    """

    session: Session
    centre: SE2
    pose: SE2


class MergeMapsNode(ManagedNode):
    """Shows each graph on `/map_N` in a frame of its own, and all as one on `/map`."""

    Config = MergeMapsConfig
    DEFAULT_NAME = "map_merging"

    def configure(self) -> None:
        self._submaps: list[Submap] = []
        self._sequence = 0
        self._merged = self._outputs("/map", "/map_metadata")
        self._tf = self.publisher(TFMessage, "/tf", qos.TF)
        profile = qos.DEFAULT
        self._updates = self.publisher(InteractiveMarkerUpdate, f"{_TOOL}/update", profile)
        self.subscribe(InteractiveMarkerFeedback, f"{_TOOL}/feedback", self._on_feedback, profile)
        self.serve(GetInteractiveMarkers, f"{_TOOL}/get_interactive_markers", self._on_get)
        self.serve(AddSubmap, "slam_toolbox/add_submap", self._on_add)
        self.serve(MergeMaps, "slam_toolbox/merge_submaps", self._on_merge)
        self.every(0.1, self._broadcast)

    def _outputs(self, topic: str, metadata: str) -> tuple[Any, Any]:
        map_output = self.publisher(OccupancyGridMsg, topic, qos.LATCHED)
        return map_output, self.publisher(MapMetaData, metadata, qos.LATCHED)

    def _publish(self, outputs: tuple[Any, Any], grid: OccupancyGrid, frame: str) -> None:
        message = grid_msg(grid, frame, self.now)
        outputs[0].publish(message)
        outputs[1].publish(message.info)

    def _drawn(self, *placed: tuple[Session, SE2]) -> OccupancyGrid | None:
        """Return the map of sessions, each moved by a pose in the map."""
        keyframes = Keyframes(self.config.resolution, self.config.max_laser_range)
        for session, T_map_session in placed:
            for scan, pose in zip(session.scans, session.poses, strict=True):
                keyframes.add(scan, T_map_session @ SE2.from_array(pose))
        return keyframes.map()

    def _on_add(self, request: Any, response: Any) -> Any:
        try:
            if not request.filename:
                raise ConfigError("filename is empty; valid: the path of a saved graph")
            session = load_session(map_path(self.config.maps_folder, request.filename, SUFFIX))
        except (SessionFileError, MapsFolderError, ConfigError) as error:
            self.get_logger().error(f"graph not added: {error}")
            return response
        grid = self._drawn((session, SE2()))
        if grid is None:
            self.get_logger().error(f"graph not added: {request.filename} has no scan")
            return response
        frame, name = grid.frame, f"map_{len(self._submaps) + 1}"
        half = SE2(frame.width * frame.resolution / 2.0, frame.height * frame.resolution / 2.0)
        centre = frame.origin @ half
        self._submaps.append(Submap(session, centre, centre))
        shown = replace(grid, frame=replace(frame, origin=half.inverse()))
        self._publish(self._outputs(f"/{name}", f"/map_metadata_{name[4:]}"), shown, name)
        self._sequence += 1
        update = InteractiveMarkerUpdate(server_id=_TOOL, seq_num=self._sequence)
        update.type, update.markers = InteractiveMarkerUpdate.UPDATE, self._markers()
        self._updates.publish(update)
        self.get_logger().info(f"{request.filename} is on /{name}: {len(session.scans)} keyframes")
        return response

    def _on_merge(self, request: Any, response: Any) -> Any:
        moved = ((one.session, one.pose @ one.centre.inverse()) for one in self._submaps)
        grid = self._drawn(*moved)
        if grid is None:
            self.get_logger().error("nothing to merge: add_submap adds graphs")
            return response
        self._publish(self._merged, grid, self.config.map_frame)
        self.get_logger().info(f"{len(self._submaps)} graphs merged on /map")
        return response

    def _on_feedback(self, message: Any) -> None:
        name, kind = message.marker_name, message.event_type
        known = {str(k) for k in range(1, len(self._submaps) + 1)}
        if name not in known or kind not in (message.POSE_UPDATE, message.MOUSE_UP):
            return
        try:
            self._submaps[int(name) - 1].pose = se2_from_pose(message.pose)
        except ValueError as error:
            self.get_logger().warning(f"map {name} not moved: {error}")

    def _markers(self) -> list[Any]:
        head = header(self.config.map_frame, self.now)
        named = enumerate(self._submaps, start=1)
        return [handle(head, str(k), one.pose, _SIZE) for k, one in named]

    def _on_get(self, request: Any, response: Any) -> Any:
        response.sequence_number, response.markers = self._sequence, self._markers()
        return response

    def _broadcast(self) -> None:
        if self._submaps:
            frame = self.config.map_frame
            named = enumerate(self._submaps, start=1)
            frames = [transform_msg(one.pose, frame, f"map_{k}", self.now) for k, one in named]
            self._tf.publish(transforms_msg(*frames))
