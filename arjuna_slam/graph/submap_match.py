"""Pose of one submap in another: what is not known of it, and what speaks against it.

A scan in a corridor fits anywhere along it, and in the next corridor too. So whole submaps are
compared; the direction in which they fit as well elsewhere in the window is not known; and where
the beams of one go through what the other has seen, they are not of the same area.

Source: Hess et al., Real-time loop closure in 2D LIDAR SLAM, 2016, section V (search); Olson,
Robust and efficient robotic mapping, 2008, chapter 3 (ambiguity).
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.scan import Scan
from arjuna_core.se2 import SE2
from arjuna_slam.graph.candidates import LoopConfig, Search
from arjuna_slam.graph.rivals import SeenField, Views, rival
from arjuna_slam.graph.submap import Submap
from arjuna_slam.matching.contradiction import longest, seen_and_contradicted
from arjuna_slam.matching.correlative import Window, searching
from arjuna_slam.matching.field import Field
from arjuna_slam.matching.scan_matcher import Match, MatchStatus, ScanMatcher, invert
from arjuna_slam.matching.surface import Surface

_FINE = Window(0.2, 0.02, 2)
_BENT = np.diag([0.03**2, 0.03**2, 0.004**2])  # covariance of what a submap's own bend adds
_DIRECTIONS = np.array(
    [(math.cos(k * math.pi / 6.0), math.sin(k * math.pi / 6.0)) for k in range(6)]
)


@dataclass(frozen=True)
class SubmapMatch:
    """Pose of a submap in a past one, as matched."""

    T_past_query: SE2  # the pose
    covariance: Floats  # of it, in the past one's axes, `(3, 3) float64`
    sure: bool  # whether it fits nowhere else in the window
    # where in the past one lies what holds it in the direction that is least seen, `(2,)
    # float64` [m]
    holds: Floats
    area: float  # of what holds it in each direction, in either submap [m^2]


class SubmapMatcher:
    """Compares submaps."""

    def __init__(self, config: LoopConfig, matcher: ScanMatcher, range_max: float) -> None:
        self._config = config
        self._matcher = matcher
        self._range_max = range_max

    def find(
        self, query: Submap, past: Submap, window: Search, scans: Sequence[Scan]
    ) -> Generator[None, None, SubmapMatch | None]:
        """Look for a submap in a past one; each step of the generator takes a bounded time.

        Returns:
            The match, or None where none fits or something speaks against it.
        """
        points, normals = query.field.surface()
        many = 240  # points of a submap that is searched, a quarter of them at least
        if len(points) < many // 4:
            return None
        surface = Surface(points, normals, np.zeros(len(points), np.bool_))
        coarse, some = past.field.halved(), points[:: -(-len(points) // many)]
        pieces = window.pieces(coarse.resolution)
        best = yield from _best(coarse, some, pieces, self._config.loop_submap_response)
        match = None if best is None else self._refine(past, surface, best[0])
        if best is None or match is None:
            return None
        found = match.T_field_base
        if not window.is_plausible(found):
            return None
        much, wall = self._against(query, past, points, found, scans)
        if much:
            return None
        yield

        other = None
        if window.reaches_beside(best[0]):
            seen = SeenField.of(past.field, coarse, _views(past, SE2(), scans), self._range_max)
            yield
            against = partial(self._is_ruled_out, query, past, points, scans)
            share = self._config.loop_rival_share
            other = yield from rival(seen, some, best[0], pieces, share, against)
        information = invert(match.covariance + _BENT)
        if other is not None:
            information = _along_unknown(information, other, match, surface)
        holds, area = _what_holds(past.field, surface, match), _area(query.field, past.field, found)
        sure = other is None and wall <= self._config.loop_wall_crossed
        return SubmapMatch(found, invert(information), sure, holds, area)

    def _refine(self, past: Submap, surface: Surface, start: SE2) -> Match | None:
        match = self._matcher.match(past.field, surface, start, _FINE, 0.0)
        good = match.response >= self._config.loop_place_response
        return match if good and match.status is MatchStatus.MATCHED else None

    def _is_ruled_out(
        self, query: Submap, past: Submap, points: Floats, scans: Sequence[Scan], T_past_query: SE2
    ) -> bool:
        much, wall = self._against(query, past, points, T_past_query, scans)
        return much or wall > self._config.loop_wall_crossed

    def _against(
        self, query: Submap, past: Submap, points: Floats, T_past_query: SE2, scans: Sequence[Scan]
    ) -> tuple[bool, float]:
        """Return whether the beams of either go through much of what the other has seen.

        And how long the longest piece of wall is that they go through [m].
        """
        theirs = past.field.surface()[0]
        sides = ((points, past, T_past_query.inverse()), (theirs, query, T_past_query))
        much, wall = False, 0.0
        for seen_points, submap, change in sides:
            views = _views(submap, change, scans)
            seen, against = seen_and_contradicted(seen_points, views, self._range_max)
            much |= bool(against.sum() > self._config.loop_contradiction * seen.sum())
            wall = max(wall, longest(seen_points[against]))
        return much, wall


def _views(submap: Submap, change: SE2, scans: Sequence[Scan]) -> Views:
    most = 12  # scans of a submap that are compared
    every = max(1, len(submap.nodes) // most)
    at = zip(submap.nodes[::every], submap.poses[::every], strict=True)
    return [(scans[node], change @ pose) for node, pose in at]


def _best(
    coarse: Field, points: Floats, pieces: Sequence[tuple[SE2, Window]], least: float
) -> Generator[None, None, tuple[SE2, float] | None]:
    best = None
    for prior, piece in pieces:
        found = yield from searching(coarse, points, prior, piece, least)
        if found is not None:
            best, least = found, found[1]
        yield
    return best


def _what_holds(field: Field, surface: Surface, match: Match) -> Floats:
    """Return the middle of the points that fix a match in the direction that it sees least.

    A submap of a corridor may be stretched, and then fits where a corner is seen, not all along.
    """
    points = match.T_field_base.apply(surface.points)
    facing = SE2(0.0, 0.0, match.T_field_base.theta).apply(surface.normals) @ _least_seen(match)
    facing_min = 0.3  # cosine from which on a wall faces a direction
    weight = np.where(np.abs(facing) > facing_min, facing**2, 0.0) * field.likelihood(points)
    if not weight.any():
        weight = np.ones(len(points))
    middle: Floats = weight @ points / weight.sum()
    return middle


def _area(query: Field, past: Field, T_past_query: SE2) -> float:
    """Return the area of the walls that hold one in the other, least over directions [m^2].

    A door holds a submap along a corridor as firmly as a room does, but many doors are alike.
    """
    return min(_squares(query, past, T_past_query), _squares(past, query, T_past_query.inverse()))


def _squares(field: Field, other: Field, T_other_field: SE2) -> int:
    """Return in how many squares of a metre walls that face a direction lie on the other's.

    Of the direction in which they are fewest.
    """
    points, normals = field.surface()
    points = T_other_field.apply(points)
    likely, across = 0.3, 0.5  # of a point on the other's wall; cosine of one that constrains
    on = other.likelihood(points) > likely
    squares, facing = np.floor(points[on]), np.abs(normals[on] @ _DIRECTIONS.T) > across
    return min(len(np.unique(squares[faces], axis=0)) for faces in facing.T)


def _along_unknown(information: Floats, rival: SE2, best: Match, surface: Surface) -> Floats:
    """Remove the information along the direction in which another pose fits as well.

    The direction is that of the walls that run towards the rival, as the rival is known to a cell
    only, which is degrees over 0.8 m. The direction that the match sees least would not do: doors
    hold as firmly as walls.
    """
    gap = rival.array()[:2] - best.T_field_base.array()[:2]
    gap /= np.linalg.norm(gap)
    normals = SE2(0.0, 0.0, best.T_field_base.theta).apply(surface.normals)
    along = np.column_stack((-normals[:, 1], normals[:, 0]))
    parallel, few = 0.95, 0.1  # cosine of a wall that runs towards it; share that says nothing
    along = along[np.abs(along @ gap) > parallel]
    walls = len(along) > few * len(normals)
    direction = np.append(np.linalg.eigh(along.T @ along)[1][:, 1] if walls else gap, 0.0)
    pull = information @ direction
    remainder: Floats = information - np.outer(pull, pull) / (direction @ pull)
    unknown = 1e-4  # information left in that direction, for the inverse
    return remainder + unknown * np.eye(3)


def _least_seen(match: Match) -> Floats:
    """Return the direction in which a match knows least, `(2,) float64`."""
    direction: Floats = np.linalg.eigh(match.covariance[:2, :2])[1][:, 1]
    return direction
