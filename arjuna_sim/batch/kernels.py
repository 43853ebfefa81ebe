"""Warp's kernels: what a batch does on its device beside MuJoCo Warp's own physics and rays."""

from __future__ import annotations

import warp as wp

from arjuna_sim.physics.contacts import GRAZED, LEVEL, SUNK

wp.config.log_level = wp.LOG_WARNING  # else a line for each of a hundred kernels


@wp.kernel(enable_backward=False)
def aim_beams(
    site: int,
    beams: wp.array[wp.vec3],
    positions: wp.array2d[wp.vec3],
    rotations: wp.array2d[wp.mat33],
    starts: wp.array2d[wp.vec3],
    directions: wp.array2d[wp.vec3],
) -> None:
    """Put each robot's beams where its lidar is."""
    robot, beam = wp.tid()
    starts[robot, beam] = positions[robot, site]
    directions[robot, beam] = rotations[robot, site] @ beams[beam]


@wp.kernel(enable_backward=False)
def measure(
    distances: wp.array2d[float],
    seeds: wp.array[int],
    scan: int,
    noise: float,
    dropout: float,
    nearest: float,
    furthest: float,
    ranges: wp.array2d[float],
) -> None:
    """Turn distances, below 0 for none, into ranges by REP 117, with noise and dropouts.

    The noise of a beam depends on its robot's seed and on the number of the scan alone.
    """
    robot, beam = wp.tid()
    state = wp.rand_init(seeds[robot], scan * distances.shape[1] + beam)
    distance = distances[robot, beam]
    if distance < 0.0:
        distance = wp.inf
    distance += noise * wp.randn(state)
    if distance < nearest:
        distance = -wp.inf
    elif distance > furthest:
        distance = wp.inf
    if wp.randf(state) < dropout:
        distance = wp.inf
    ranges[robot, beam] = distance


@wp.kernel(enable_backward=False)
def find_touched(
    count: wp.array[int],
    pairs: wp.array[wp.vec2i],
    robots: wp.array[int],
    frames: wp.array[wp.mat33],
    distances: wp.array[float],
    is_solid: wp.array[int],
    is_obstacle: wp.array[int],
    touched: wp.array[int],
) -> None:
    """Mark the robots that touch what they do not stand on, as `scene.touched` names it."""
    k = wp.tid()
    if k >= count[0]:
        return
    a, b = pairs[k][0], pairs[k][1]
    meets = is_solid[a] * is_obstacle[b] + is_solid[b] * is_obstacle[a]
    distance = distances[k]
    stands = wp.abs(frames[k][0, 2]) > wp.static(LEVEL) and distance > -wp.static(SUNK)
    if meets > 0 and not stands and distance <= -wp.static(GRAZED):
        touched[robots[k]] = 1
