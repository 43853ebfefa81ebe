"""The buffer of transforms that a TransformListener fills."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.clock import Clock
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time
from tf2_py import BufferCore
from tf2_py import LookupException as LookupException
from tf2_py import TransformException as TransformException

from tf2_ros.buffer_interface import BufferInterface


class Buffer(BufferCore, BufferInterface):
    """Transforms between any two frames, now or at a time of the last 10 s, or `cache_time`."""

    def __init__(self, cache_time: Duration | None = None, node: Node | None = None) -> None:
        BufferCore.__init__(self, cache_time)
        BufferInterface.__init__(self)
        self.clock = node.get_clock() if node is not None else Clock()
        self._lock = threading.RLock()
        self._waiting: list[tuple[Callable[[], TransformStamped], Future]] = []

    def _set(self, transform: TransformStamped, authority: str, static: bool) -> bool:
        """Take a transform, and answer those who wait for it."""
        with self._lock:
            kept = super()._set(transform, authority, static)
        self._answer()
        return kept

    def _answer(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
            for lookup, future in waiting:
                if future.cancelled():
                    continue
                try:
                    future.set_result(lookup())
                except TransformException:
                    self._waiting.append((lookup, future))

    def lookup_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008 - the original's signature
    ) -> TransformStamped:
        """Return the transform that maps source into target at a time; `Time()` is the latest.

        Waiting needs another thread that spins (`TransformListener(..., spin_thread=True)`).

        Raises:
            TransformException: It is not known in time; the kind says why.
        """
        self.can_transform(target_frame, source_frame, time, timeout)
        with self._lock:
            return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Time,
        source_frame: str,
        source_time: Time,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
    ) -> TransformStamped:
        """Return the transform between two times, through a frame that does not move."""
        self.can_transform(fixed_frame, source_frame, source_time, timeout)
        self.can_transform(target_frame, fixed_frame, target_time, timeout)
        with self._lock:
            return self.lookup_transform_full_core(
                target_frame, target_time, source_frame, source_time, fixed_frame
            )

    def can_transform(
        self,
        target_frame: str,
        source_frame: str,
        time: Time,
        timeout: Duration = Duration(),  # noqa: B008
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether a transform is known, waiting up to a time for it."""
        end = self.clock.now() + timeout
        with self._lock:
            known, why = self.can_transform_core(target_frame, source_frame, time)
        while not known and self.clock.now() < end and self.clock.sleep_for(Duration(seconds=0.02)):
            with self._lock:
                known, why = self.can_transform_core(target_frame, source_frame, time)
        return (known, why) if return_debug_tuple else known

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Time,
        source_frame: str,
        source_time: Time,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return whether a transform between two times is known, waiting up to a time for it."""
        known = self.can_transform(fixed_frame, source_frame, source_time, timeout, True)
        if known[0]:
            known = self.can_transform(target_frame, fixed_frame, target_time, timeout, True)
        return known if return_debug_tuple else known[0]

    def wait_for_transform_async(self, target_frame: str, source_frame: str, time: Time) -> Future:
        """Return a future that is done with the transform as soon as it is known."""
        return self._wait(partial(self.lookup_transform_core, target_frame, source_frame, time))

    def wait_for_transform_full_async(self, *asked: Any, **named: Any) -> Future:
        """Return a future that is done with `lookup_transform_full` as soon as that is known."""
        return self._wait(partial(self.lookup_transform_full_core, *asked, **named))

    def _wait(self, lookup: Callable[[], TransformStamped]) -> Future:
        future: Future = Future()
        with self._lock:
            self._waiting.append((lookup, future))
        self._answer()
        return future

    async def lookup_transform_async(
        self, target_frame: str, source_frame: str, time: Time
    ) -> TransformStamped:
        return await self.wait_for_transform_async(target_frame, source_frame, time)

    async def lookup_transform_full_async(self, *asked: Any, **named: Any) -> TransformStamped:
        return await self.wait_for_transform_full_async(*asked, **named)

    def get_frame_names(self) -> list[str]:
        """Return every frame that has a parent."""
        with self._lock:
            return sorted(self._tree.edges)
