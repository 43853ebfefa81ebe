"""Transforms over time: what tf2's C++ core offers to Python."""

from tf2_py.buffer_core import (
    BufferCore,
    ConnectivityException,
    ExtrapolationException,
    InvalidArgumentException,
    LookupException,
    TimeoutException,
    TransformException,
)
