"""Rotations and transforms as tf_transformations has them: quaternions are `(x, y, z, w)`.

By C. Gohlke's transformations.py, of which the original is a copy too, as trimesh has it: there
quaternions are `(w, x, y, z)`. Axes are four letters: `s` (fixed) or `r` (rotating), then the
order, as in `sxyz`.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any

import numpy as np
from trimesh import transformations
from trimesh.transformations import (
    affine_matrix_from_points,
    angle_between_vectors,
    clip_matrix,
    compose_matrix,
    concatenate_matrices,
    decompose_matrix,
    identity_matrix,
    inverse_matrix,
    is_same_transform,
    orthogonalization_matrix,
    projection_from_matrix,
    projection_matrix,
    random_vector,
    reflection_from_matrix,
    reflection_matrix,
    rotation_from_matrix,
    rotation_matrix,
    scale_from_matrix,
    scale_matrix,
    shear_from_matrix,
    shear_matrix,
    translation_from_matrix,
    translation_matrix,
    unit_vector,
    vector_norm,
    vector_product,
)


def _x_first(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function whose quaternions, given or returned, have w last."""
    signature = inspect.signature(function)
    returns = function.__name__ not in ("quaternion_matrix", "quaternion_real", "quaternion_imag")

    @functools.wraps(function)
    def run(*arguments: Any, **named: Any) -> Any:
        given = signature.bind(*arguments, **named).arguments
        axes = given.get("axes", "sxyz")
        if isinstance(axes, str) and axes not in transformations._AXES2TUPLE:
            raise ValueError(f"no axes: {axes!r}; valid: 's' or 'r' and an order, as 'sxyz'")
        for name, value in given.items():
            if name.startswith("quat"):
                given[name] = np.roll(value, 1)
            elif name == "rand" and value is not None:
                given[name] = np.asarray(value)
        found = function(**given)
        return np.roll(found, -1) if returns and np.shape(found) == (4,) else found

    run.__doc__ = f"Do as trimesh's `{function.__name__}`, quaternions as `(x, y, z, w)`."
    return run


euler_from_matrix = _x_first(transformations.euler_from_matrix)
euler_from_quaternion = _x_first(transformations.euler_from_quaternion)
euler_matrix = _x_first(transformations.euler_matrix)
quaternion_about_axis = _x_first(transformations.quaternion_about_axis)
quaternion_conjugate = _x_first(transformations.quaternion_conjugate)
quaternion_from_euler = _x_first(transformations.quaternion_from_euler)
quaternion_from_matrix = _x_first(transformations.quaternion_from_matrix)
quaternion_imag = _x_first(transformations.quaternion_imag)
quaternion_inverse = _x_first(transformations.quaternion_inverse)
quaternion_matrix = _x_first(transformations.quaternion_matrix)
quaternion_multiply = _x_first(transformations.quaternion_multiply)
quaternion_real = _x_first(transformations.quaternion_real)
quaternion_slerp = _x_first(transformations.quaternion_slerp)
random_quaternion = _x_first(transformations.random_quaternion)
random_rotation_matrix = _x_first(transformations.random_rotation_matrix)
