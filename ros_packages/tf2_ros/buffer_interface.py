"""The interface of every buffer, and the registry of messages that can be transformed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.duration import Duration
from rclpy.time import Time
from tf2_py import TransformException


class TypeException(TransformException):
    """A message of this type cannot be transformed: no package registered how."""

    def __init__(self, errstr: str) -> None:
        super().__init__(errstr)
        self.errstr = errstr


class NotImplementedException(TransformException):
    """A buffer lacks a method."""

    def __init__(self) -> None:
        super().__init__("CanTransform or LookupTransform not implemented")


class TransformRegistration:
    """The transform for each message type; packages such as tf2_geometry_msgs add theirs."""

    __type_map: dict[Any, Callable[[Any, Any], Any]] = {}  # noqa: RUF012 - shared by all on purpose

    def print_me(self) -> None:
        print(TransformRegistration.__type_map)  # noqa: T201 - the original's

    def add(self, key: Any, callback: Callable[[Any, Any], Any]) -> None:
        """Register how a type is transformed."""
        TransformRegistration.__type_map[key] = callback

    def get(self, key: Any) -> Callable[[Any, Any], Any]:
        """Return how a type is transformed.

        Raises:
            TypeException: No package registered it.
        """
        if key not in TransformRegistration.__type_map:
            raise TypeException(f"Type {key} is not loaded or supported")
        return TransformRegistration.__type_map[key]


class BufferInterface:
    """Transforms messages by what `lookup_transform` says."""

    def __init__(self) -> None:
        self.registration = TransformRegistration()

    def transform(
        self,
        object_stamped: Any,
        target_frame: str,
        timeout: Duration = Duration(),  # noqa: B008 - the original's signature
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame.

        Raises:
            TransformException: The transform is not known.
            TypeException: The type is not supported; import tf2_geometry_msgs.
        """
        do_transform = self._transformation(object_stamped, new_type)
        header = object_stamped.header
        asked = target_frame, header.frame_id, header.stamp
        return do_transform(object_stamped, self.lookup_transform(*asked, timeout))

    def transform_full(
        self,
        object_stamped: Any,
        target_frame: str,
        target_time: Time,
        fixed_frame: str,
        timeout: Duration = Duration(),  # noqa: B008 - the original's signature
        new_type: Any = None,
    ) -> Any:
        """Return a stamped message in another frame at another time, as `transform` does."""
        do_transform = self._transformation(object_stamped, new_type)
        header = object_stamped.header
        asked = target_time, header.frame_id, header.stamp, fixed_frame
        found = self.lookup_transform_full(target_frame, *asked, timeout)
        return do_transform(object_stamped, found)

    def _transformation(self, object_stamped: Any, new_type: Any) -> Callable[[Any, Any], Any]:
        found = self.registration.get(type(object_stamped))
        if new_type is None or new_type is type(object_stamped):
            return found
        raise TypeException(f"Type {new_type} is not loaded or supported")

    def lookup_transform(self, *arguments: Any, **options: Any) -> Any:
        """Return a transform; a buffer's own."""
        raise NotImplementedException

    def lookup_transform_full(self, *arguments: Any, **options: Any) -> Any:
        """Return a transform between two times; a buffer's own."""
        raise NotImplementedException

    def can_transform(self, *arguments: Any, **options: Any) -> Any:
        """Return whether a transform is known; a buffer's own."""
        raise NotImplementedException
