"""Motors of driven joints that are no wheels: each holds, follows or pushes, as it is commanded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import mujoco
import numpy as np

from arjuna_core.arrays import Bools, Floats, Ints
from arjuna_sim.model.joints import Gains
from arjuna_sim.model.robot import RobotModel
from arjuna_sim.physics.wheels.servo import ServoConfig, actuators, add_servo


class Motored(NamedTuple):
    """A joint that a servo turns.

    Attributes:
        joint: Its name in MuJoCo.
        gains: Of the servo, where the file gives them; else they are derived.
        effort: Its greatest, None for one that is derived [N m or N].
    """

    joint: str
    gains: Gains | None
    effort: float | None


def motored(robot: RobotModel) -> tuple[Motored, ...]:
    """Return a robot's driven joints, in the order of `GazeboSettings.driven`."""
    efforts = (robot.urdf.joints[joint.name].max_effort for joint in robot.settings.driven)
    return tuple(
        Motored(joint.name, joint.gains, effort)
        for joint, effort in zip(robot.settings.driven, efforts, strict=True)
    )


@dataclass(frozen=True)
class JointServos:
    """The servos of some joints, in their order, each `(N,)`.

    Attributes:
        position: Addresses in qpos.
        velocity: Addresses in qvel.
        stiffness: Effort per error of position.
        damping: Effort per error of velocity.
        lead: How far the wanted position runs ahead of the joint's, per speed [s].
        reach: By how much it may be off until the effort is at its limit [rad or m].
        is_derived: Whether its gains are derived, so that it also carries its load.
        motors: Which of all motors are theirs.
        sums: Where MuJoCo keeps the wanted positions.
    """

    position: Ints
    velocity: Ints
    stiffness: Floats
    damping: Floats
    lead: Floats
    reach: Floats
    is_derived: Bools
    motors: slice
    sums: slice

    def drive(
        self,
        model: Any,
        data: Any,
        is_effort: Bools,
        position: Floats,
        velocity: Floats,
        effort: Floats,
    ) -> None:
        """Set what the joints do from now on.

        Args:
            is_effort: Which joints push with an effort instead of following a position.
            position: Positions wanted now [rad or m].
            velocity: How fast they change [rad/s or m/s].
            effort: The efforts [N m or N], of those that follow what is added.
        """
        load = data.qfrc_bias[self.velocity] - data.qfrc_gravcomp[self.velocity]
        carried = load + model.dof_damping[self.velocity] * velocity
        follows = ~is_effort
        ahead = np.clip(position - data.qpos[self.position], -self.reach, self.reach)
        data.act[self.sums] = data.qpos[self.position] + ahead + self.lead * velocity
        data.ctrl[self.motors] = velocity
        model.actuator_gainprm[self.motors, 0] = follows * self.stiffness
        bias = model.actuator_biasprm[self.motors]
        bias[:, 0] = effort + follows * self.is_derived * carried
        bias[:, 1], bias[:, 2] = follows * -self.stiffness, follows * -self.damping


def add_joint_servos(spec: Any, joints: Sequence[Motored]) -> None:
    """Add the motors of joints, one after the other."""
    for each in joints:
        # their limits follow from what they move, which is known when the model is compiled
        add_servo(spec, each.joint, each.effort or 1.0)


def tune_joint_servos(model: Any, joints: Sequence[Motored], config: ServoConfig) -> JointServos:
    """Set the gains of a compiled model's motors by what they move, or as the file gives them.

    A servo is a critically damped spring to the wanted position, stiff enough for the joint's dry
    friction. It is implicit in MuJoCo's step, so that no inertia is too light for it.
    """
    found = [model.joint(each.joint) for each in joints]
    velocity = np.array([joint.dofadr[0] for joint in found], np.int64)
    moved = np.array([_moved(model, int(dof)) for dof in velocity])
    # [rad or m] Dry friction keeps a servo so far from where it is to be.
    slack = 1e-3
    stiffness = np.maximum(
        moved / config.response_time**2, model.dof_frictionloss[velocity] / slack
    )
    damping = 2.0 * np.sqrt(stiffness * moved)
    for i, joint in enumerate(joints):
        if joint.gains is not None:
            stiffness[i], damping[i] = joint.gains.p, joint.gains.d
    # A motor whose file names no limit lifts what it moves, and speeds it up by 100 rad/s^2.
    effort = np.array([j.effort or 200.0 * each for j, each in zip(joints, moved, strict=True)])
    motors, sums = actuators(model, [each.joint for each in joints])
    model.actuator_forcerange[motors] = np.stack([-effort, effort], axis=1)
    model.actuator_gainprm[motors, 0] = stiffness
    model.actuator_biasprm[motors, 1], model.actuator_biasprm[motors, 2] = -stiffness, -damping
    return JointServos(
        np.array([joint.qposadr[0] for joint in found], np.int64),
        velocity,
        stiffness,
        damping,
        # the implicit step is at its end, where the wanted position is that of its start
        damping / np.maximum(stiffness, 1e-9) + model.opt.timestep,
        2.0 * effort / np.maximum(stiffness, 1e-9),
        np.array([joint.gains is None for joint in joints], bool),
        motors,
        sums,
    )


def _moved(model: Any, dof: int) -> float:
    """Return the most inertia that a joint may have to move, with all that it carries stretched."""
    top = int(model.dof_bodyid[dof])
    if int(model.jnt_type[model.dof_jntid[dof]]) == int(mujoco.mjtJoint.mjJNT_SLIDE):
        return float(model.body_subtreemass[top] + model.dof_armature[dof])
    distance = {top: 0.0}
    total = float(model.dof_armature[dof])
    for body in range(top, model.nbody):
        parent = int(model.body_parentid[body])
        if body != top:
            if parent not in distance:
                continue
            distance[body] = distance[parent] + float(np.linalg.norm(model.body_pos[body]))
        arm = distance[body] + float(np.linalg.norm(model.body_ipos[body]))
        total += float(model.body_mass[body]) * arm**2 + float(model.body_inertia[body].max())
    return total
