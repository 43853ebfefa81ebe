"""The functions that are compiled at set-up, and those that are compiled again."""

from __future__ import annotations

import importlib
import json
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("numba", reason="no Numba here")

from numba.core import types

from arjuna_nav.costmap.moving.sightings import Sightings
from scripts import kernels
from scripts.kernels_in_use import decode, encode

TYPES = (
    types.float64,
    types.int64,
    types.boolean,
    types.none,
    types.literal(3),
    types.Array(types.uint8, 2, "C"),
    types.Array(types.float32, 3, "A", readonly=True),
    types.Array(types.boolean, 1, "F"),
    types.UniTuple(types.int64, 2),
    types.Tuple((types.none, types.Array(types.int32, 1, "C"))),
    types.NamedTuple([types.Array(types.float64, 1, "C")] + 5 * [types.int64], Sightings),
    types.NamedUniTuple(types.int64, 6, Sightings),
)


@pytest.mark.parametrize("kind", TYPES, ids=str)
def test_a_type_survives_the_list(kind: Any) -> None:
    assert decode(json.loads(json.dumps(encode(kind)))) == kind


def test_a_type_that_the_list_cannot_hold_is_refused() -> None:
    with pytest.raises(TypeError, match="no encoding for unicode_type"):
        encode(types.unicode_type)


def test_the_list_names_functions_that_are_there() -> None:
    entries = kernels.read_list()
    assert len(entries) > 30
    for module, name, arguments in entries:
        function = getattr(importlib.import_module(module), name)
        assert len(arguments) <= function.py_func.__code__.co_argcount, (module, name)
        assert [encode(decode(each)) for each in arguments] == arguments


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """Four modules: `plan` calls `walk`, which takes `FREE` from `grid`; `other` has its own."""
    folder = tmp_path / "arjuna_nav"
    (folder / "__pycache__").mkdir(parents=True)
    (folder / "plan.py").write_text(
        "from numba import njit\n"
        "from arjuna_nav import walk as w\nfrom arjuna_nav.walk import (\n    walk,\n)\n"
    )
    (folder / "walk.py").write_text("from numba import njit\nfrom arjuna_nav.grid import FREE\n")
    (folder / "grid.py").write_text("from arjuna_nav.words import NAME\nFREE = 0\n")
    (folder / "words.py").write_text("NAME = 'grid'\n")
    (folder / "other.py").write_text("from numba import njit\n")
    for name in ("plan", "walk", "other"):
        (folder / "__pycache__" / f"{name}.run-3.py311.1.nbc").touch()
        (folder / "__pycache__" / f"{name}.run-3.py311.nbi").touch()
    return folder


def compiled(tree: Path) -> set[str]:
    """Return the modules of which something compiled is left."""
    return {path.name.partition(".")[0] for path in tree.glob("__pycache__/*.nb[ic]")}


@pytest.mark.parametrize(
    ("changed", "left"),
    [
        (None, {"plan", "walk", "other"}),
        ("other", {"plan", "walk"}),
        ("plan", {"walk", "other"}),
        ("walk", {"other"}),
        ("grid", {"other"}),
        ("words", {"plan", "walk", "other"}),
    ],
)
def test_a_change_deletes_what_was_compiled_with_it_and_no_more(
    changed: str | None, left: set[str], tree: Path
) -> None:
    state = tree.parent / ".setup" / "kernels.json"
    kernels.forget_stale(tree.parent, state)
    assert compiled(tree) == {"plan", "walk", "other"}
    if changed is not None:
        with (tree / f"{changed}.py").open("a") as file:
            file.write("FREE = 1\n")
    kernels.forget_stale(tree.parent, state)
    assert compiled(tree) == left
    assert kernels.digests(tree.parent).keys() == {
        f"arjuna_nav.{name}" for name in ("plan", "walk", "other")
    }
