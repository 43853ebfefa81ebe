"""Bytes of a file changed at random: flipped, cut, and words put where numbers and tags are."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

WORDS = (
    *("nan", "inf", "-1", "0", "1e9", "1e308", "-1e-308", "1000000000", "", "../../../etc/passwd"),
    *("__model__", "base", "true", "%s", "1 2", "\N{SNOWMAN}", "package://", "0x10", "--", "]]>"),
)
NUMBER = re.compile(rb"-?\d+(\.\d+)?(e-?\d+)?")
TAG = re.compile(rb"<(\w+)[^<>]*/>|<(\w+)[^<>]*>[^<]*</\2>")


def _flip(text: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(text)
    for place in rng.integers(len(text), size=rng.integers(1, 6)):
        changed[place] = rng.integers(256)
    return bytes(changed)


def _cut(text: bytes, rng: np.random.Generator) -> bytes:
    first, last = np.sort(rng.integers(len(text) + 1, size=2))
    return text[:last] if rng.random() < 0.5 else text[:first] + text[last:]


def _replace(pattern: re.Pattern[bytes], text: bytes, rng: np.random.Generator) -> bytes:
    found = list(pattern.finditer(text))
    if not found:
        return _flip(text, rng)
    hit = found[rng.integers(len(found))]
    if pattern is NUMBER:
        new = WORDS[rng.integers(len(WORDS))].encode()
    else:
        new = b"" if rng.random() < 0.5 else found[rng.integers(len(found))].group() * 2
    return text[: hit.start()] + new + text[hit.end() :]


def _number(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(NUMBER, text, rng)


def _tag(text: bytes, rng: np.random.Generator) -> bytes:
    return _replace(TAG, text, rng)


MUTATIONS: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    *(_flip, _cut, _number, _number, _number, _tag, _tag),
)


def mutated(text: bytes, rng: np.random.Generator, most: int = 3) -> bytes:
    """Return a text after a few changes."""
    for _ in range(int(rng.integers(1, most + 1))):
        text = MUTATIONS[int(rng.integers(len(MUTATIONS)))](text or b" ", rng)
    return text
