"""The map under way, kept in a file: it outlives the process, however that ends."""

from __future__ import annotations

import math
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from arjuna_core.ros.node import ManagedNode
from arjuna_slam.mapping.session import Session
from arjuna_slam.mapping.session_file import SessionFileError, load_session, save_session
from arjuna_slam.slam import Slam


class MapMemory:
    """Keeps the mapper's session, written by a thread of its own: no scan waits for the disk.

    3000 keyframes of 720 beams take it 80 ms, in which a scan's callback waits for 10 ms at most.

    Args:
        node: The slam_toolbox node.
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
        """Keep the session, if it has keyframes that are not kept and no writing is under way."""
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
        """Return the session that was under way when the process ended, if any can be used."""
        if self._file is None or not self._file.exists():
            return None
        try:
            session = load_session(self._file)
            if session.T_odom_base is None:
                raise SessionFileError(self._file, "does not tell where odometry was")
        except SessionFileError as error:
            self._node.get_logger().error(f"the map starts anew: {error}")
            return None
        self._kept = self.recalled_from = session.scans[-1].stamp
        count = len(session.scans)
        self._node.get_logger().info(f"goes on with the map under way, of {count} keyframes")
        return session

    def destroy(self) -> None:
        """End the thread."""
        self._thread.shutdown()
