"""The exceptions of tf2."""

from __future__ import annotations


class TransformException(Exception):
    """Any error of tf2."""


class ConnectivityException(TransformException):
    """Two frames are in trees that are not connected."""


class LookupException(TransformException):
    """A frame does not exist."""


class ExtrapolationException(TransformException):
    """A transform is asked for at a time that its data does not reach."""


class InvalidArgumentException(TransformException):
    """An argument is not valid."""


class TimeoutException(TransformException):
    """A transform did not come in time."""
