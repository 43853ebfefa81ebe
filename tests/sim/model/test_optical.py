"""A camera's optical frame is the robot's own where it has one, in all the ways files say so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arjuna_core.pose3 import Pose3
from arjuna_sim.model.joints import Joint
from arjuna_sim.model.optical import T_BODY_OPTICAL, OpticalFrame, optical_frame
from arjuna_sim.model.urdf import Link, Urdf

ASIDE = Pose3((0.0, 0.02, 0.0), T_BODY_OPTICAL.quaternion)


def robot(**children: Pose3) -> Urdf:
    """Return a robot with a link `camera` and fixed children of it."""
    links = {name: Link(name, None, (), ()) for name in ("camera", *children)}
    joints = {name: Joint(name, "fixed", "camera", name, T) for name, T in children.items()}
    return Urdf(Path("r.urdf"), "r", "", "camera", links, joints)


@pytest.mark.parametrize(
    ("urdf", "named", "expected"),
    [
        (robot(), "camera", OpticalFrame("camera_optical_frame", "camera")),
        (robot(), "eye_optical", OpticalFrame("eye_optical", "camera")),
        (robot(), "left_eye", OpticalFrame("camera_optical_frame", "camera")),
        (robot(eye=ASIDE), "eye", OpticalFrame("eye", None)),
        (robot(eye=ASIDE), "camera", OpticalFrame("eye", None)),
        (robot(eye=Pose3()), "eye", OpticalFrame("eye_optical_frame", "eye")),
        (robot(eye=Pose3()), "camera", OpticalFrame("camera_optical_frame", "camera")),
    ],
)
def test_frame_of_pictures(urdf: Urdf, named: str, expected: OpticalFrame) -> None:
    assert optical_frame(urdf, "camera", named) == expected


def test_optical_axes_are_right_down_and_ahead() -> None:
    axes = T_BODY_OPTICAL.rotation()
    np.testing.assert_allclose(axes, [[0, 0, 1], [-1, 0, 0], [0, -1, 0]], atol=1e-12)
