"""Dubins' and Reeds and Shepp's curves: the shortest of arcs and straights between two poses.

Lengths are in turning radii; a curve is up to five pieces, each a kind (1 left, -1 right, 0
straight) and a length, negative where it is driven backwards.

Source: Dubins 1957; Reeds and Shepp, Optimal paths for a car that goes both forwards and backwards,
    Pacific Journal of Mathematics 1990, section 8, whose formulas' numbers are named.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from arjuna_core.arrays import Floats

_HALF = 0.5 * math.pi
_TINY = 1e-9
_KINDS = np.array(
    [
        [1, 0, 1, 0, 0],
        [1, 0, -1, 0, 0],
        [1, -1, 1, 0, 0],
        [1, -1, 1, -1, 0],
        [1, -1, 1, -1, 0],
        [1, -1, 0, 1, 0],
        [1, -1, 0, -1, 0],
        [1, -1, 0, 1, -1],
    ],
    np.float64,
)
_PIECES = np.array([3, 3, 3, 4, 4, 4, 4, 5])
_TURNED = np.array([False, False, True, False, False, True, True, False])
"""Words that are others when driven from their end."""
Lengths = tuple[float, float, float, float, float]
_NONE: Lengths = (math.nan, 0.0, 0.0, 0.0, 0.0)


@njit(cache=True)
def shortest(x: float, y: float, phi: float, reverse: bool) -> Floats:
    """Return the shortest curve from the origin, facing x, to a pose: `(2, 5)` kinds and lengths.

    Args:
        phi: Heading [rad].
        reverse: Whether it may be driven backwards: Reeds and Shepp's, else Dubins'.
    """
    _, word, variant, lengths = _best(x, y, phi, reverse, 0.0)
    found, count = np.zeros((2, 5)), _PIECES[word]
    for i in range(count):
        j = count - 1 - i if variant & 4 else i
        found[0, i] = -_KINDS[word, j] if variant & 2 else _KINDS[word, j]
        found[1, i] = -lengths[j] if variant & 1 else lengths[j]
    return found


@njit(cache=True)
def length_to(x: float, y: float, phi: float, reverse: bool, enough: float) -> float:
    """Return the length of the shortest curve, or of the first one no longer than is enough.

    See `shortest`. Where a search knows a greater bound, most words need no look.
    """
    total: float = _best(x, y, phi, reverse, enough)[0]
    return total


@njit(cache=True)
def _best(
    x: float, y: float, phi: float, reverse: bool, enough: float
) -> tuple[float, int, int, Lengths]:
    """Return the length of the shortest word, its number, its variant and its pieces' lengths.

    A word that is no longer than `enough` ends the search for a shorter one.

    A variant's bits say whether it is driven backwards, mirrored, and from its end.
    """
    c, s = math.cos(phi), math.sin(phi)
    ends = (x, y), (x * c + y * s, x * s - y * c)
    best, best_word, best_variant, best_lengths = np.inf, 0, 0, _NONE
    for word in range(8 if reverse else 3):
        for variant in range(8):
            flip, mirror, turned = variant & 1, variant & 2, variant & 4
            if (turned and not _TURNED[word]) or ((flip or turned) and not reverse):
                continue
            u, v = ends[1] if turned else ends[0]
            opposite = (flip > 0) != (mirror > 0)
            angle, sine = (-phi, -s) if opposite else (phi, s)
            pose = -u if flip else u, -v if mirror else v, angle, c, sine
            if reverse and _least(word, pose) >= best:
                continue
            exists, lengths = _short_word(word, pose) if word < 3 else _long_word(word, pose)
            if not reverse:
                exists, lengths = _forwards(word, lengths, exists)
            total = 0.0
            for one in lengths:
                total += abs(one)
            if exists and total < best:
                best, best_word, best_variant, best_lengths = total, word, variant, lengths
                if best <= enough:
                    return best, best_word, best_variant, best_lengths
    return best, best_word, best_variant, best_lengths


@njit(cache=True)
def _least(word: int, pose: Lengths) -> float:
    """Return a lower bound of a word's length, inf where its arcs would go the other way.

    Their sines tell, without an angle: four words in five are looked at no further.
    """
    x, y, _, c, s = pose
    inner = word == 0 or word == 2 or word == 5
    dx, dy = (x - s, y - 1.0 + c) if inner else (x + s, y - 1.0 - c)
    squared = dx * dx + dy * dy
    if word == 2 or word == 3 or word == 4:  # arcs alone reach no farther, by a little
        return 0.0 if squared <= (16.1 if word == 2 else 4.1 if word == 3 else 20.1) else np.inf
    if squared < 4.0 and word != 0:
        return np.inf
    far, tangent = math.sqrt(squared), math.sqrt(max(squared - 4.0, 0.0))
    # Of the first arc cosine and sine, of the last its sine; each times a length.
    if word == 0:
        least, cos, sin = far, dx, dy
        last = s * cos - c * sin
    elif word == 1:
        least, cos, sin = tangent, dx * tangent - 2.0 * dy, dy * tangent + 2.0 * dx
        last = c * sin - s * cos
    elif word == 5:
        least, cos, sin = tangent + _HALF - 2.0, -2.0 * dx - tangent * dy, tangent * dx - 2.0 * dy
        last = c * cos + s * sin
    elif word == 6:
        least, cos, sin = far + _HALF - 2.0, -dy, dx
        last = -c * cos - s * sin
    else:
        least, cos, sin = tangent + math.pi - 4.0, -2.0 * dx - tangent * dy, tangent * dx - 2.0 * dy
        last = c * sin - s * cos
    slack = -1e-8 * (1.0 + squared)
    return least - 1e-9 if sin >= slack and last >= slack else np.inf


@njit(cache=True)
def _forwards(word: int, lengths: Lengths, exists: bool) -> tuple[bool, Lengths]:
    """Make a word's arcs go forwards, which ends at the same pose; return whether it ends."""
    first, second, third = lengths[0], lengths[1], _ahead(lengths[2])
    if word == 2:
        second = _ahead(second)
    exists = exists or (not math.isnan(first) and second >= 0.0)
    return exists, (_ahead(first), second, third, 0.0, 0.0)


@njit(cache=True)
def _ahead(arc: float) -> float:
    arc = arc % (2.0 * math.pi)
    return 0.0 if arc > 2.0 * math.pi - 1e-6 else arc


@njit(cache=True)
def _short_word(word: int, pose: Lengths) -> tuple[bool, Lengths]:
    """Return whether a word of three pieces leads to `(x, y, phi, cos, sin)`, and its lengths.

    The first is NaN where there is no such word.
    """
    x, y, phi, c, s = pose
    lengths = _NONE
    exists = False
    if word == 0:  # 8.1
        near_x, near_y = x - s, y - 1.0 + c
        t = math.atan2(near_y, near_x)
        v = _wrapped(phi - t)
        exists = t >= -_TINY and v >= -_TINY
        lengths = t, math.hypot(near_x, near_y), v, 0.0, 0.0
    elif word == 1:  # 8.2
        far_x, far_y = x + s, y - 1.0 - c
        far = math.hypot(far_x, far_y)
        if far >= 2.0:
            u = math.sqrt(far * far - 4.0)
            t = _wrapped(math.atan2(far_y, far_x) + math.atan2(2.0, u))
            v = _wrapped(t - phi)
            exists = t >= -_TINY and v >= -_TINY
            lengths = t, u, v, 0.0, 0.0
    else:  # 8.3 and 8.4
        near_x, near_y = x - s, y - 1.0 + c
        near = math.hypot(near_x, near_y)
        if near <= 4.0:
            u = -2.0 * math.asin(0.25 * near)
            t = _wrapped(math.atan2(near_y, near_x) + 0.5 * u + math.pi)
            exists = t >= -_TINY and u <= _TINY
            lengths = t, u, _wrapped(phi - t + u), 0.0, 0.0
    return exists, lengths


@njit(cache=True)
def _long_word(word: int, pose: Lengths) -> tuple[bool, Lengths]:
    """Return the same for the words of four and five pieces."""
    x, y, phi, c, s = pose
    far_x, far_y = x + s, y - 1.0 - c
    far = math.hypot(far_x, far_y)
    if word == 3 and far <= 2.0:  # 8.7
        u = math.acos(0.25 * (2.0 + far))
        t, v = _ends(u, -u, far_x, far_y, phi)
        return t >= -_TINY and v <= _TINY, (t, u, -u, v, 0.0)
    if word == 4 and 4.0 <= far * far <= 20.0:  # 8.8
        u = -math.acos((20.0 - far * far) / 16.0)
        t, v = _ends(u, u, far_x, far_y, phi)
        return u >= -_HALF and t >= -_TINY and v >= -_TINY, (t, u, u, v, 0.0)
    if word == 5:  # 8.9
        near_x, near_y = x - s, y - 1.0 + c
        near = math.hypot(near_x, near_y)
        if near >= 2.0:
            r = math.sqrt(near * near - 4.0)
            t = _wrapped(math.atan2(near_y, near_x) + math.atan2(r, -2.0))
            v = _wrapped(phi - _HALF - t)
            exists = t >= -_TINY and 2.0 - r <= _TINY and v <= _TINY
            return exists, (t, -_HALF, 2.0 - r, v, 0.0)
    if word == 6 and far >= 2.0:  # 8.10
        t = math.atan2(far_x, -far_y)
        v = _wrapped(t + _HALF - phi)
        exists = t >= -_TINY and 2.0 - far <= _TINY and v <= _TINY
        return exists, (t, -_HALF, 2.0 - far, v, 0.0)
    if word == 7 and far >= 2.0:  # 8.11
        u = 4.0 - math.sqrt(far * far - 4.0)
        t = _wrapped(math.atan2((4.0 - u) * far_x - 2.0 * far_y, -2.0 * far_x + (u - 4.0) * far_y))
        v = _wrapped(t - phi)
        exists = u <= _TINY and t >= -_TINY and v >= -_TINY
        return exists, (t, -_HALF, u, -_HALF, v)
    return False, _NONE


@njit(cache=True)
def _ends(u: float, v: float, xi: float, eta: float, phi: float) -> tuple[float, float]:
    """Return the first and last arc round two middle ones."""
    delta = _wrapped(u - v)
    a, b = math.sin(u) - math.sin(delta), math.cos(u) - math.cos(delta) - 1.0
    t = math.atan2(eta * a - xi * b, xi * a + eta * b)
    if 2.0 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3.0 < 0.0:
        t += math.pi
    t = _wrapped(t)
    return t, _wrapped(t - u + v - phi)


@njit(cache=True)
def _wrapped(angle: float) -> float:
    result: float = (angle + math.pi) % (2.0 * math.pi) - math.pi
    return result


@njit(cache=True)
def along(pose: Floats, curve: Floats, radius: float, spacing: float) -> Floats:
    """Return poses `(N, 3)` on a curve from a pose, at most a spacing apart, the start left out.

    Args:
        pose: `(x, y, theta)`.
        curve: Of `shortest`.
        radius: Turning radius, in the poses' unit.
        spacing: In the poses' unit.
    """
    total = 1
    for i in range(curve.shape[1]):
        total += int(abs(curve[1, i]) * radius / spacing) + 1
    poses = np.empty((total, 3))
    x, y, theta = pose
    count = 0
    for i in range(curve.shape[1]):
        length = curve[1, i]
        if abs(length) < _TINY:
            continue
        steps = int(abs(length) * radius / spacing) + 1
        for _ in range(steps):
            x, y, theta = moved(x, y, theta, curve[0, i], length * radius / steps, radius)
            poses[count, 0], poses[count, 1], poses[count, 2] = x, y, theta
            count += 1
    return poses[:count]


@njit(cache=True)
def moved(
    x: float, y: float, theta: float, kind: float, length: float, radius: float
) -> tuple[float, float, float]:
    """Return the pose after a straight or an arc; lengths have the poses' unit."""
    if kind == 0.0:
        return x + length * math.cos(theta), y + length * math.sin(theta), theta
    after = theta + kind * length / radius
    side = kind * radius
    return (
        x + side * (math.sin(after) - math.sin(theta)),
        y - side * (math.cos(after) - math.cos(theta)),
        after,
    )
