"""Parameters of AMCL: nav2_amcl's names and defaults, and those of the recovery from being lost."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from arjuna_core.config import SEED_MAX, duration_param, fixed, length_param, param, share_param
from arjuna_core.errors import ConfigError
from arjuna_core.plugins import PluginTypes

DIFFERENTIAL = "nav2_amcl::DifferentialMotionModel"
OMNIDIRECTIONAL = "nav2_amcl::OmniMotionModel"
SKID_STEER = "arjuna::SkidSteerMotionModel"
MOTION_MODELS = PluginTypes(
    "motion model",
    {
        DIFFERENTIAL: "arjuna_slam.amcl.motion:differential",
        OMNIDIRECTIONAL: "arjuna_slam.amcl.motion:omnidirectional",
        SKID_STEER: "arjuna_slam.amcl.motion:skid_steer",
    },
    DIFFERENTIAL,
    stands_in=True,
)
PARTICLES_MAX = 100_000  # an update of as many takes a second
SENSOR_MODELS = ("likelihood_field", "likelihood_field_prob", "beam")


@dataclass(frozen=True)
class AmclConfig:
    """Parameters of the particle filter.

    Raises:
        ConfigError: The least number of particles exceeds the greatest, or there is no such
            motion model.
    """

    alpha1: float = param(0.2, "Rotation noise from rotation.", minimum=0.0)
    alpha2: float = param(0.2, "Rotation noise from translation.", minimum=0.0)
    alpha3: float = param(0.2, "Translation noise from translation.", minimum=0.0)
    alpha4: float = param(0.2, "Translation noise from rotation.", minimum=0.0)
    alpha5: float = param(
        0.2, "Sideways noise, from translation (omni) or turning (skid-steer).", minimum=0.0
    )
    robot_model_type: str = param(
        DIFFERENTIAL,
        f"Motion model: {', '.join(MOTION_MODELS.types)}, or module:function.",
        class_of=MOTION_MODELS,
    )
    min_particles: int = param(500, "Least number of particles.", minimum=1, maximum=PARTICLES_MAX)
    max_particles: int = param(
        2000, "Greatest number of particles.", minimum=1, maximum=PARTICLES_MAX
    )
    pf_err: float = param(0.05, "Error between true and estimated distribution.", minimum=1e-3)
    pf_z: float = param(0.99, "Quantile of the normal distribution for pf_err.", minimum=0.0)
    resample_interval: int = param(1, "Filter updates from one resampling to the next.", minimum=1)
    selective_resampling: bool = param(
        False, "Resample only when fewer than half of the particles carry the weight."
    )
    freespace_downsampling: bool = param(
        False, "Draw particles from anywhere in each second free cell only; saves memory."
    )
    update_min_d: float = param(0.25, "Translation that calls for an update.", unit="m")
    update_min_a: float = param(0.2, "Rotation that calls for an update.", unit="rad")

    laser_model_type: str = param("likelihood_field", "Sensor model.", choices=SENSOR_MODELS)
    max_beams: int = param(60, "Beams of a scan that the filter weighs.", minimum=2)
    laser_min_range: float = param(-1.0, "Shortest range used; -1 is the scan's own.", unit="m")
    laser_max_range: float = param(100.0, "Longest range used; up to 0 the scan's own.", unit="m")
    laser_likelihood_max_dist: float = length_param(
        2.0, "Distance to obstacles at which the likelihood stops falling.", minimum=0.1
    )
    sigma_hit: float = length_param(0.2, "Deviation of a hit from the map.", minimum=1e-3)
    z_hit: float = param(0.5, "Share of beams that hit what the map has.", minimum=0.0)
    z_rand: float = param(0.5, "Share of beams of random range.", minimum=0.0)
    z_short: float = param(
        0.05, "Share of beams that something unmapped stops (beam model).", minimum=0.0
    )
    z_max: float = param(0.05, "Share of beams that do not return (beam model).", minimum=0.0)
    lambda_short: float = param(
        0.1, "Decay of what unmapped things stop (beam model).", unit="1/m", minimum=0.0
    )
    do_beamskip: bool = param(
        False, "Leave out beams that fit few particles, once these have converged (prob model)."
    )
    beam_skip_distance: float = length_param(0.5, "Distance at which a beam fits.")
    beam_skip_threshold: float = share_param(
        0.3, "Share of particles that a beam must fit to be used."
    )
    beam_skip_error_threshold: float = share_param(
        0.9, "Share of skipped beams above which all are used."
    )

    recovery_alpha_slow: float = share_param(
        0.001, "Decay of the slow average likelihood; 0 injects no particles.", theirs=0.0
    )
    recovery_alpha_fast: float = share_param(
        0.1, "Decay of the fast average likelihood; 0 injects no particles.", theirs=0.0
    )
    match_scans: bool = param(
        True,
        "Whether the pose is matched to each scan, between updates too; else it is the particles'"
        " mean, and rests between updates.",
        theirs=False,
    )
    agreement_distance: float = length_param(
        0.15, "Distance to an obstacle below which a beam agrees with the map.", minimum=0
    )
    match_deviation: float = length_param(
        0.05, "Deviation of a beam's end in matching; neighbours share an error.", minimum=1e-3
    )
    tracking_share: float = share_param(0.75, "Probability from which a pose is known.")
    relocalize: bool = param(True, "Search the whole map for the scan when lost.", theirs=False)
    relocalize_agreement: float = share_param(0.7, "Agreement with the map below which it is lost.")
    relocalize_doubt: float = share_param(0.85, "Agreement below which a better pose is searched.")
    relocalize_gain: float = share_param(
        0.15, "Greater agreement of another pose; lost: two thirds."
    )
    relocalize_evidence: float = param(
        40.0, "Beams of a scan that err independently: evidence for a pose.", minimum=0.0
    )
    relocalize_patience: float = duration_param(
        1.0, "How long doubt must last before the map is searched."
    )
    relocalize_wait: float = duration_param(
        8.0, "Longest wait between two searches, each waiting twice as long."
    )

    def __post_init__(self) -> None:
        if self.min_particles > self.max_particles:
            raise ConfigError(
                f"min_particles ({self.min_particles}) must not exceed "
                f"max_particles ({self.max_particles})"
            )
        MOTION_MODELS.resolve(self.robot_model_type)


ALWAYS, NEVER, AUTO = "always", "never", "auto"


@dataclass(frozen=True)
class InitialPose:
    """Pose of the base in the map at the start."""

    x: float = param(0.0, "Position.", unit="m")
    y: float = param(0.0, "Position.", unit="m")
    z: float = param(0.0, "Position; unused, for compatibility.", unit="m")
    yaw: float = param(0.0, "Heading.", unit="rad")


@dataclass(frozen=True)
class AmclNodeConfig(AmclConfig):
    """Parameters of amcl: the filter's, and those of the node."""

    base_frame_id: str = fixed("base_footprint", "Frame of the robot's base.")
    global_frame_id: str = fixed("map", "Frame of the map.")
    odom_frame_id: str = fixed("odom", "Frame of the odometry.")
    scan_topic: str = fixed("scan", "Topic of the scans.")
    map_topic: str = fixed("map", "Topic of the map.")
    transform_tolerance: float = duration_param(
        0.2, "How far ahead map -> odom is dated, two periods of the scans at least.", theirs=1.0
    )
    tf_broadcast: bool = param(True, "Whether to broadcast map -> odom.")
    set_initial_pose: bool = param(False, "Whether to start at initial_pose.")
    initial_pose: InitialPose = InitialPose()
    always_reset_initial_pose: bool = param(
        False, "Whether each activation starts afresh instead of at the last known pose."
    )
    first_map_only: bool = param(False, "Whether to ignore maps after the first.")
    global_localization_at_start: str = param(
        AUTO,
        "Search the whole map at the start; auto: where no initial pose is given.",
        choices=(ALWAYS, NEVER, AUTO),
        theirs="never",
    )
    save_pose_rate: float = param(
        0.5, "How often a tracked pose is written to initial_pose; never from 0 down.", unit="Hz"
    )
    seed: int = fixed(0, "Seed of all randomness.", minimum=0, maximum=SEED_MAX)


def filter_part(config: AmclNodeConfig) -> tuple[Any, ...]:
    """Return the values that the filter depends on."""
    return tuple(getattr(config, item.name) for item in fields(AmclConfig))
