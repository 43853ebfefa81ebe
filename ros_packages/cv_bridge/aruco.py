"""Functions of `cv2.aruco` as Jazzy's OpenCV 4.6 has them, for programs written for it.

Later releases dropped them one by one, and no release of pip's that has all of them goes with
NumPy 2. https://docs.opencv.org/4.6.0/d9/d6a/group__aruco.html
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def complete(cv2: Any) -> None:
    """Give an OpenCV the functions that it lacks."""
    aruco = getattr(cv2, "aruco", None)
    if not hasattr(aruco, "ArucoDetector"):
        return  # 4.6 itself, or an OpenCV without markers
    for name, function in _functions(cv2, aruco).items():
        if not hasattr(aruco, name):
            setattr(aruco, name, function)


def _functions(cv2: Any, aruco: Any) -> dict[str, Callable[..., Any]]:
    def detect(
        image: Any, dictionary: Any, corners: Any = None, ids: Any = None, parameters: Any = None,
        *rest: Any, **others: Any,
    ) -> Any:  # fmt: skip
        chosen = aruco.DetectorParameters() if parameters is None else parameters
        return aruco.ArucoDetector(dictionary, chosen).detectMarkers(image)

    def poses(
        corners: Sequence[Any], side: float, camera: Any, distortion: Any, *outputs: Any
    ) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
        square = np.array([(-1, 1, 0), (1, 1, 0), (1, -1, 0), (-1, -1, 0)], np.float32)
        points = (square * side / 2.0).reshape(4, 1, 3)
        found = [cv2.solvePnP(points, one, camera, distortion)[1:] for one in corners]
        turned, moved = (np.array(part).reshape(-1, 1, 3) for part in zip(*found, strict=True))
        return turned, moved, points

    return {
        "Dictionary_get": aruco.getPredefinedDictionary,
        "DetectorParameters_create": aruco.DetectorParameters,
        "detectMarkers": detect,
        "drawAxis": cv2.drawFrameAxes,
        "drawMarker": aruco.generateImageMarker,
        "estimatePoseSingleMarkers": poses,
    }
