"""The services of slam_toolbox that save maps and graphs, and continue saved ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

from slam_toolbox.srv import DeserializePoseGraph, SaveMap, SerializePoseGraph

from arjuna_core.errors import ConfigError, MapError
from arjuna_core.files.maps import save_map, unnamed
from arjuna_core.files.maps_folder import MapsFolderError, map_path
from arjuna_core.ros.node import ManagedNode
from arjuna_core.se2 import SE2
from arjuna_slam.mapping.session import (
    SUFFIX,
    Session,
    SessionFileError,
    Start,
    StartKind,
    load_session,
    save_session,
)
from arjuna_slam.slam import Slam

_KINDS = {
    DeserializePoseGraph.Request.UNSET: StartKind.ANYWHERE,
    DeserializePoseGraph.Request.START_AT_FIRST_NODE: StartKind.FIRST_NODE,
    DeserializePoseGraph.Request.START_AT_GIVEN_POSE: StartKind.NEAR_POSE,
    DeserializePoseGraph.Request.LOCALIZE_AT_POSE: StartKind.NEAR_POSE,
}


class MapMemory:
    """Keeps the mapper's session, written by a thread of its own: no scan waits for the disk.

    3000 keyframes of 720 beams take it 80 ms, in which a scan's callback waits for 10 ms at most.

    Args:
        file: Where the session is kept; empty: it is not.

    Attributes:
        recalled_from: Stamp of the last keyframe of the session gone on with [s]; -inf: of none.
    """

    def __init__(self, node: ManagedNode, file: str) -> None:
        self._node = node
        self._file = Path(file) if file else None
        self._thread = ThreadPoolExecutor(1, thread_name_prefix="map_memory")
        self._writing: Future[None] | None = None
        self._kept = self.recalled_from = -math.inf

    def remember(self, slam: Slam) -> None:
        """Keep the session, if it has keyframes that are not kept and no writing is in progress."""
        if self._file is None or (self._writing is not None and not self._writing.done()):
            return
        self.settle()
        session = slam.session()
        if session is None or session.T_odom_base is None:
            return
        newest = session.scans[-1].stamp
        if newest != self._kept:
            self._kept = newest
            self._writing = self._thread.submit(save_session, self._file, session)

    def settle(self) -> None:
        """Wait until what is being written is written; say so where it cannot be."""
        writing, self._writing = self._writing, None
        try:
            if writing is not None:
                writing.result()
        except SessionFileError as error:
            self._node.get_logger().warning(f"the map under way is not kept: {error}", once=True)

    def forget(self) -> None:
        """Keep nothing: the map is not gone on with."""
        self.settle()
        self._kept = self.recalled_from = -math.inf
        if self._file is not None:
            self._file.unlink(missing_ok=True)

    def recall(self) -> Session | None:
        """Return the session that was running when the process ended, if any can be used."""
        if self._file is None or not self._file.exists():
            return None
        try:
            session = load_session(self._file)
            if session.T_odom_base is None:
                raise SessionFileError(self._file, "does not tell where odometry was")
        except SessionFileError as error:
            self._node.get_logger().error(f"a new map begins: {error}")
            return None
        self._kept = self.recalled_from = session.scans[-1].stamp
        count = len(session.scans)
        self._node.get_logger().info(f"continues the map under way, of {count} keyframes")
        return session

    def destroy(self) -> None:
        """End the thread."""
        self._thread.shutdown()


Resume = Callable[[Session, Start, bool], None]


class SlamFiles:
    """Offers `save_map`, `serialize_map` and `deserialize_map` of the paths that `map_path` has.

    `resume` is called with a session, the start pose and whether only to localize.
    """

    def __init__(self, node: ManagedNode, resume: Resume) -> None:
        self._node: Any = node
        self._resume = resume
        if node.config.use_map_saver:
            node.serve(SaveMap, "slam_toolbox/save_map", self._on_save_map)
        node.serve(SerializePoseGraph, "slam_toolbox/serialize_map", self._on_serialize)
        node.serve(DeserializePoseGraph, "slam_toolbox/deserialize_map", self._on_deserialize)

    def load_at_start(self) -> None:
        """Continue the graph that the parameters name, if any.

        Raises:
            ArjunaError: It cannot be used, or the start pose is none.
        """
        c = self._node.config
        if not c.map_file_name:
            if c.mode == "localization":
                self._node.get_logger().warning(
                    "localization without a graph: set map_file_name or call deserialize_map; "
                    "until then it maps"
                )
            return
        path = _with_suffix(Path(c.maps_folder) / c.map_file_name)
        self._resume(load_session(path), start_of(c), c.mode == "localization")
        self._node.get_logger().info(f"continues from {path}")

    def _on_save_map(self, request: Any, response: Any) -> Any:
        grid = self._node.slam.map()
        if grid is None:
            response.result = SaveMap.Response.RESULT_NO_MAP_RECEIEVD
            return response
        try:
            name = request.name.data or unnamed(self._node.now)
            path, _ = save_map(grid, map_path(self._node.config.maps_folder, name))
            self._node.get_logger().info(f"map saved as {path}")
            response.result = SaveMap.Response.RESULT_SUCCESS
        except (MapError, MapsFolderError) as error:
            self._node.get_logger().error(f"map not saved: {error}")
            response.result = SaveMap.Response.RESULT_UNDEFINED_FAILURE
        return response

    def _on_serialize(self, request: Any, response: Any) -> Any:
        response.result = SerializePoseGraph.Response.RESULT_FAILED_TO_WRITE_FILE
        session = self._node.slam.session()
        if session is None:
            self._node.get_logger().error("graph not saved: no scan has come yet")
            return response
        try:
            path = map_path(self._node.config.maps_folder, request.filename, SUFFIX)
            save_session(path, session)
            self._node.get_logger().info(f"graph of {len(session.scans)} keyframes saved as {path}")
            response.result = SerializePoseGraph.Response.RESULT_SUCCESS
        except (SessionFileError, MapsFolderError) as error:
            self._node.get_logger().error(f"graph not saved: {error}")
        return response

    def _on_deserialize(self, request: Any, response: Any) -> Any:
        localize = request.match_type == DeserializePoseGraph.Request.LOCALIZE_AT_POSE
        pose = request.initial_pose
        try:
            least = 0 if self._node.config.start_anywhere else 1
            if request.match_type not in _KINDS or request.match_type < least:
                raise ConfigError(f"match_type {request.match_type} is none; valid: {least} to 3")
            start = Start(_KINDS[request.match_type], SE2(pose.x, pose.y, pose.theta))
            if not request.filename:
                raise ConfigError("filename is empty; valid: the path of a saved graph")
            path = map_path(self._node.config.maps_folder, request.filename, SUFFIX)
            session = load_session(path)
        except (SessionFileError, MapsFolderError, ConfigError) as error:
            self._node.get_logger().error(f"graph not loaded: {error}")
            return response
        self._resume(session, start, localize or self._node.config.mode == "localization")
        self._node.get_logger().info(f"continues from {path}, the robot {start.kind.value}")
        return response


def _with_suffix(path: Path) -> Path:
    return path if path.suffix == SUFFIX else path.with_name(path.name + SUFFIX)


def start_of(c: Any) -> Start:
    """Return where the parameters say that the robot starts on the graph."""
    if len(c.map_start_pose) not in (0, 3):
        raise ConfigError(f"'map_start_pose' is {list(c.map_start_pose)}; valid: [x, y, theta]")
    if c.map_start_pose:
        return Start(StartKind.NEAR_POSE, SE2(*c.map_start_pose))
    if c.map_start_at_dock:
        return Start(StartKind.FIRST_NODE)
    return Start(StartKind.ANYWHERE if c.start_anywhere else StartKind.NEAR_POSE)
