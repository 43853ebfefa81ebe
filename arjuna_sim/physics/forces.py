"""Forces that clients ask for: efforts on joints and wrenches on links, each for its time."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np

from arjuna_core.arrays import Floats
from arjuna_core.errors import nearest
from arjuna_sim.model.entities import EntityError, UnknownEntityError, body_name

_HARDEST = 1e4  # acceleration beyond which MuJoCo's steps make no sense [m/s^2 or rad/s^2]


class _Push(NamedTuple):
    """An effort, or force and torque in the world at a centre of mass, from one time to another."""

    value: Floats
    begin: float  # [s]
    end: float  # [s]


class Forces:
    """What pushes joints and links from outside, as Gazebo Classic's force system.

    A joint is known by its name, below any robot; a link as `MODEL::LINK` or by itself.
    """

    def __init__(self) -> None:
        self._efforts: dict[str, list[_Push]] = {}
        self._wrenches: dict[str, list[_Push]] = {}

    def __bool__(self) -> bool:
        """Return whether anything pushes, or will."""
        return bool(self._efforts or self._wrenches)

    def bind(self, model: Any, data: Any) -> None:
        """Push in a MuJoCo model from now on."""
        self._model, self._data = model, data

    def push_joint(self, name: str, effort: float, begin: float, end: float) -> None:
        """Push a joint from one time to another [N or N m, s].

        Raises:
            UnknownEntityError: There is none of this name; the message names the nearest.
            EntityError: The effort is not finite.
        """
        push = _Push(_finite(np.array([effort])), begin, end)
        self._efforts.setdefault(self._joint(name), []).append(push)

    def push_link(
        self, name: str, wrench: Floats, frame: str, point: Floats, begin: float, end: float
    ) -> None:
        """Push a link at its centre of mass from one time to another.

        Args:
            wrench: Force and torque, `(6,) float64` [N, N m].
            frame: The link whose axes, as they are now, and point that is in; "" for the world's.
            point: Where the force acts in that frame, `(3,) float64`; not used in the world's.

        Raises:
            UnknownEntityError: One is not there; the message names the nearest.
            EntityError: The wrench or the point is not finite.
        """
        body, origin, _ = self._link(name)
        force, torque, point = _finite(wrench[:3]), _finite(wrench[3:]), _finite(point)
        if frame:
            _, start, turned = self._link(frame)
            force = turned @ force
            torque = turned @ torque + np.cross(start + turned @ point - origin, force)
        push = _Push(np.concatenate((force, torque)), begin, end)
        self._wrenches.setdefault(body, []).append(push)

    def clear_joint(self, name: str) -> None:
        """Let nothing push a joint any more.

        Raises:
            UnknownEntityError: There is none of this name.
        """
        joint = self._joint(name)
        if joint in self._efforts:
            self._efforts[joint] = []

    def clear_link(self, name: str) -> None:
        """Let nothing push a link any more.

        Raises:
            UnknownEntityError: There is none of this name.
        """
        body = self._link(name)[0]
        if body in self._wrenches:
            self._wrenches[body] = []

    def clear(self) -> None:
        """Let nothing push anything any more."""
        self._efforts, self._wrenches = {}, {}

    def apply(self, now: float) -> None:
        """Push in the step that begins now [s]."""
        model, data = self._model, self._data
        for name, total in _sums(self._efforts, now):
            if (joint := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)) >= 0:
                rate = model.jnt_dofadr[joint]
                most = _HARDEST * model.dof_M0[rate]
                data.qfrc_applied[rate] = np.clip(total, -most, most).item()
        for name, total in _sums(self._wrenches, now):
            if (body := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, name)) >= 0:
                mass, inertia = model.body_mass[body], model.body_inertia[body].max()
                most = _HARDEST * np.repeat((mass, inertia), 3)
                data.xfrc_applied[body] = np.clip(total, -most, most)

    def _joint(self, name: str) -> str:
        names: list[str] = [self._model.joint(i).name for i in range(self._model.njnt)]
        found = next((each for each in names if _is_below(each, name)), None)
        if found is None:
            short = [each.rpartition("//")[2] for each in names if ":" not in each]
            raise UnknownEntityError(f"joint '{name}' does not exist; {nearest(name, short)}")
        return found

    def _link(self, name: str) -> tuple[str, Floats, Floats]:
        """Return the body of a link, and the link's origin and axes in the world."""
        model, data = self._model, self._data
        holder, _, link = name.rpartition("::")
        for whole in (body_name(name), body_name(holder)):
            if (body := mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, whole)) >= 0:
                return whole, data.xpos[body], data.xmat[body].reshape(3, 3)
        names = {i: model.site(i).name for i in range(model.nsite)}
        sites = [i for i, each in names.items() if _is_below(each, link)]
        for site in sorted(sites, key=lambda i: not names[i].startswith(f"{holder}//")):
            body = model.body(model.site_bodyid[site]).name
            return body, data.site_xpos[site], data.site_xmat[site].reshape(3, 3)
        known = [each.rpartition("//")[2] for each in names.values()]
        raise UnknownEntityError(f"link '{name}' does not exist; {nearest(link, known)}")


def _finite(value: Floats) -> Floats:
    if not np.isfinite(value).all():
        raise EntityError(f"a push of {value.tolist()} is not finite")
    return value


def _is_below(name: str, wanted: str) -> bool:
    return name == wanted or name.endswith(f"//{wanted}")


def _sums(pushes: dict[str, list[_Push]], now: float) -> list[tuple[str, Floats]]:
    """Return what pushes each; what has ended is forgotten, after a last sum of nothing."""
    sums = []
    for name in list(pushes):
        pushes[name] = [push for push in pushes[name] if now < push.end]
        acting = [push.value for push in pushes[name] if push.begin <= now]
        sums.append((name, np.sum(acting, axis=0) if acting else np.zeros(1)))
        if not pushes[name]:
            del pushes[name]
    return sums
