"""Rotations and transforms as tf_transformations has them: quaternions are `(x, y, z, w)`.

Every function returns NumPy arrays of float64, or tuples where the original does. Axes are four
letters: `s` (fixed) or `r` (rotating), then the order, as in `sxyz`. On SciPy's Rotation.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation, Slerp

Array = NDArray[np.float64]


def _array(values: ArrayLike) -> Array:
    return np.asarray(values, dtype=float)


def _sequence(axes: str) -> str:
    frame, order = axes[0], axes[1:]
    if frame not in "sr" or len(order) != 3 or not set(order) <= set("xyz"):
        raise ValueError(f"no axes: {axes!r}; valid: 's' or 'r' and an order, as 'sxyz'")
    return order if frame == "s" else order.upper()


def _rotation(quaternion: ArrayLike) -> Rotation:
    """Return the rotation of a quaternion; one without length turns by nothing."""
    values = _array(quaternion)
    return Rotation.from_quat(values) if values.any() else Rotation.identity()


def _as_matrix(rotation: Rotation) -> Array:
    matrix = np.identity(4)
    matrix[:3, :3] = rotation.as_matrix()
    return matrix


def quaternion_from_euler(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Array:
    """Return the quaternion of three angles [rad]."""
    return _array(Rotation.from_euler(_sequence(axes), (ai, aj, ak)).as_quat())


def euler_from_quaternion(quaternion: ArrayLike, axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the three angles of a quaternion [rad]."""
    a, b, c = _rotation(quaternion).as_euler(_sequence(axes))
    return float(a), float(b), float(c)


def euler_matrix(ai: float, aj: float, ak: float, axes: str = "sxyz") -> Array:
    """Return the 4 x 4 matrix of three angles [rad]."""
    return _as_matrix(Rotation.from_euler(_sequence(axes), (ai, aj, ak)))


def euler_from_matrix(matrix: ArrayLike, axes: str = "sxyz") -> tuple[float, float, float]:
    """Return the three angles of a matrix [rad]."""
    return euler_from_quaternion(quaternion_from_matrix(matrix), axes)


def quaternion_matrix(quaternion: ArrayLike) -> Array:
    """Return the 4 x 4 matrix of a quaternion."""
    return _as_matrix(_rotation(quaternion))


def quaternion_from_matrix(matrix: ArrayLike) -> Array:
    """Return the quaternion of a matrix, 3 x 3 or 4 x 4."""
    return _array(Rotation.from_matrix(_array(matrix)[:3, :3]).as_quat())


def quaternion_multiply(quaternion1: ArrayLike, quaternion0: ArrayLike) -> Array:
    """Return the product of two quaternions."""
    x1, y1, z1, w1 = _array(quaternion1)
    x0, y0, z0, w0 = _array(quaternion0)
    return np.array(
        [
            x1 * w0 + y1 * z0 - z1 * y0 + w1 * x0,
            -x1 * z0 + y1 * w0 + z1 * x0 + w1 * y0,
            x1 * y0 - y1 * x0 + z1 * w0 + w1 * z0,
            -x1 * x0 - y1 * y0 - z1 * z0 + w1 * w0,
        ]
    )


def quaternion_conjugate(quaternion: ArrayLike) -> Array:
    """Return the conjugate of a quaternion."""
    return _array(quaternion) * (-1.0, -1.0, -1.0, 1.0)


def quaternion_inverse(quaternion: ArrayLike) -> Array:
    """Return the inverse of a quaternion."""
    q = _array(quaternion)
    return _array(quaternion_conjugate(q) / float(q @ q))


def quaternion_real(quaternion: ArrayLike) -> float:
    """Return w of a quaternion."""
    return float(_array(quaternion)[3])


def quaternion_imag(quaternion: ArrayLike) -> Array:
    """Return x, y, z of a quaternion."""
    return _array(_array(quaternion)[:3].copy())


def quaternion_about_axis(angle: float, axis: ArrayLike) -> Array:
    """Return the quaternion of a rotation [rad] about an axis."""
    return _array(Rotation.from_rotvec(angle * unit_vector(axis)).as_quat())


def quaternion_slerp(quat0: ArrayLike, quat1: ArrayLike, fraction: float) -> Array:
    """Return the quaternion at a fraction of the shorter arc from one to another."""
    return _array(Slerp((0.0, 1.0), Rotation.from_quat([quat0, quat1]))(fraction).as_quat())


def random_quaternion(rand: ArrayLike | None = None) -> Array:
    """Return a quaternion drawn evenly, from three numbers in 0..1 where given (Shoemake, 1992)."""
    u = np.random.default_rng().random(3) if rand is None else _array(rand)
    a, b = np.sqrt(1.0 - u[0]), np.sqrt(u[0])
    s, t = 2.0 * np.pi * u[1], 2.0 * np.pi * u[2]
    return np.array([np.sin(s) * a, np.cos(s) * a, np.sin(t) * b, np.cos(t) * b])


def random_rotation_matrix(rand: ArrayLike | None = None) -> Array:
    """Return the 4 x 4 matrix of a random quaternion."""
    return quaternion_matrix(random_quaternion(rand))


def random_vector(size: int) -> Array:
    """Return numbers drawn evenly from 0..1."""
    return np.random.default_rng().random(size)


def identity_matrix() -> Array:
    """Return the 4 x 4 identity."""
    return np.identity(4)


def translation_matrix(direction: ArrayLike) -> Array:
    """Return the 4 x 4 matrix of a translation."""
    matrix = np.identity(4)
    matrix[:3, 3] = _array(direction)[:3]
    return matrix


def translation_from_matrix(matrix: ArrayLike) -> Array:
    """Return the translation of a 4 x 4 matrix."""
    return _array(_array(matrix)[:3, 3].copy())


def rotation_matrix(angle: float, direction: ArrayLike, point: ArrayLike | None = None) -> Array:
    """Return the 4 x 4 matrix of a rotation [rad] about an axis through a point."""
    matrix = _as_matrix(Rotation.from_rotvec(angle * unit_vector(direction)))
    if point is not None:
        p = _array(point)[:3]
        matrix[:3, 3] = p - matrix[:3, :3] @ p
    return matrix


def scale_matrix(factor: float, origin: ArrayLike | None = None) -> Array:
    """Return the 4 x 4 matrix of a scaling about an origin."""
    matrix = np.diag([factor, factor, factor, 1.0])
    if origin is not None:
        matrix[:3, 3] = (1.0 - factor) * _array(origin)[:3]
    return _array(matrix)


def compose_matrix(
    scale: ArrayLike | None = None,
    shear: ArrayLike | None = None,
    angles: ArrayLike | None = None,
    translate: ArrayLike | None = None,
    perspective: ArrayLike | None = None,
) -> Array:
    """Return the 4 x 4 matrix that scales, shears, rotates (`sxyz`) and translates, in this order.

    Args:
        shear: Of x along y, of x along z, of y along z.
        perspective: The last row, which is applied at the end.
    """
    shearing, projecting = np.identity(4), np.identity(4)
    if shear is not None:
        shearing[0, 1], shearing[0, 2], shearing[1, 2] = _array(shear)
    if perspective is not None:
        projecting[3] = _array(perspective)[:4]
    matrix = concatenate_matrices(
        projecting,
        translation_matrix((0.0, 0.0, 0.0) if translate is None else translate),
        euler_matrix(*((0.0, 0.0, 0.0) if angles is None else _array(angles))),
        shearing,
        np.diag([*((1.0, 1.0, 1.0) if scale is None else _array(scale)), 1.0]),
    )
    return _array(matrix / matrix[3, 3])


def decompose_matrix(
    matrix: ArrayLike,
) -> tuple[Array, list[float], list[float], Array, Array]:
    """Return scale, shear, angles, translation and perspective, as `compose_matrix` takes them.

    Raises:
        ValueError: The matrix has no inverse.
    """
    whole = _array(matrix)
    if not whole[3, 3]:
        raise ValueError("M[3, 3] is zero")
    whole = whole / whole[3, 3]
    affine = np.vstack((whole[:3], (0.0, 0.0, 0.0, 1.0)))
    if not np.linalg.det(affine):
        raise ValueError("matrix is singular")
    rotation, upper = np.linalg.qr(affine[:3, :3])
    signs = np.sign(np.diag(upper))
    rotation, upper = rotation * signs, upper * signs[:, None]
    scale = np.diag(upper).copy()
    shear = [upper[0, 1] / scale[1], upper[0, 2] / scale[2], upper[1, 2] / scale[2]]
    if np.linalg.det(rotation) < 0.0:
        rotation, scale = -rotation, -scale
    angles = list(euler_from_matrix(rotation))
    perspective = whole[3] @ np.linalg.inv(affine)
    return scale, [float(each) for each in shear], angles, affine[:3, 3].copy(), perspective


def concatenate_matrices(*matrices: ArrayLike) -> Array:
    """Return the product of matrices."""
    product = np.identity(4)
    for matrix in matrices:
        product = product @ _array(matrix)
    return product


def inverse_matrix(matrix: ArrayLike) -> Array:
    """Return the inverse of a matrix."""
    return _array(np.linalg.inv(_array(matrix)))


def is_same_transform(matrix0: ArrayLike, matrix1: ArrayLike) -> bool:
    """Return whether two 4 x 4 matrices do the same."""
    a, b = (_array(matrix) for matrix in (matrix0, matrix1))
    return bool(np.allclose(a / a[3, 3], b / b[3, 3]))


def unit_vector(data: ArrayLike) -> Array:
    """Return a vector of length 1 in the direction of another."""
    vector = _array(data)
    return _array(vector / np.linalg.norm(vector))


def vector_norm(data: ArrayLike, axis: int | None = None) -> Any:
    """Return the length of a vector, or of each along an axis."""
    return np.linalg.norm(_array(data), axis=axis)
