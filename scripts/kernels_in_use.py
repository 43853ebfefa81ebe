"""The Numba functions that a demo calls, with the types of their arguments, as plain values."""

from __future__ import annotations

import importlib
import json
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

from numba.core import types
from numba.core.dispatcher import Dispatcher

from scripts.kernels import PACKAGES

Entry = tuple[str, str, list[Any]]
_ARRAY = re.compile(r"(\w+)\[(\d)([ACF])(r?)\]")


def of_a_demo() -> list[Entry]:
    """Run a demo in this process; return what it called, sorted."""
    from bringup.demo.demo import Demo, DemoOptions
    from bringup.parameters.files import shipped_parameters
    from bringup.terminal import Progress

    with tempfile.TemporaryDirectory() as folder:
        Demo(DemoOptions(0, Path(folder), shipped_parameters()), Progress()).run()
    return in_use()


def in_use() -> list[Entry]:
    """Return the functions that this process has compiled or loaded, with each one's types."""
    found: dict[int, tuple[str, str, Any]] = {}
    for module in sorted(name for name in sys.modules if name.split(".")[0] in PACKAGES):
        for name, value in vars(sys.modules[module]).items():
            if isinstance(value, Dispatcher) and _caches(value):
                own = value.py_func.__module__ == module
                if own or id(value) not in found:
                    found[id(value)] = (module, name, value)
    entries = [
        (module, name, [encode(each) for each in arguments])
        for module, name, function in found.values()
        for arguments in function.overloads
    ]
    return sorted(entries, key=json.dumps)


def _caches(function: Any) -> bool:
    return hasattr(function._cache, "cache_path")


def encode(kind: Any) -> Any:
    """Return a Numba type as what JSON holds.

    Raises:
        TypeError: It is of a sort that `decode` does not know.
    """
    if isinstance(kind, types.Array) and kind.aligned:
        return f"{encode(kind.dtype)}[{kind.ndim}{kind.layout}{'' if kind.mutable else 'r'}]"
    if isinstance(kind, types.BaseTuple):
        cls = getattr(kind, "instance_class", None)  # a named tuple's
        head = "tuple" if cls is None else f"{cls.__module__}:{cls.__name__}"
        parts: Any = kind
        return [head, *map(encode, parts)]
    if isinstance(kind, types.IntegerLiteral):
        return ["literal", kind.literal_value]
    if isinstance(kind, types.Number | types.Boolean | types.NoneType):
        return str(kind)
    raise TypeError(f"no encoding for {kind!r}")


def decode(value: Any) -> Any:
    """Return the Numba type that `encode` made a value of."""
    if isinstance(value, str):
        return _decode_word(value)
    head, *rest = value
    if head == "literal":
        return types.literal(rest[0])
    parts = [decode(each) for each in rest]
    if head == "tuple":
        return types.Tuple(parts)
    module, _, name = head.partition(":")
    cls = getattr(importlib.import_module(module), name)
    same = len(set(parts)) == 1
    return types.NamedUniTuple(parts[0], len(parts), cls) if same else types.NamedTuple(parts, cls)


def _decode_word(word: str) -> Any:
    if array := _ARRAY.fullmatch(word):
        layout: Any = array[3]
        return types.Array(_decode_word(array[1]), int(array[2]), layout, readonly=bool(array[4]))
    return {"bool": types.boolean, "none": types.none}.get(word) or getattr(types, word)
