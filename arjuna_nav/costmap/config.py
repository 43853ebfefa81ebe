"""Parameters of a costmap, by Nav2's names."""

from __future__ import annotations

from dataclasses import dataclass, field

from arjuna_core.config import param
from arjuna_core.errors import ConfigError
from arjuna_nav.costmap.footprint import Footprint

LAYERS = ("static_layer", "obstacle_layer", "range_layer", "denoise_layer", "inflation_layer")
_DEFAULT = ("static_layer", "obstacle_layer", "inflation_layer")


@dataclass(frozen=True)
class StaticConfig:
    """The layer that holds the map."""

    plugin: str = param(
        "nav2_costmap_2d::StaticLayer",
        "Nav2's name of what is used.",
        choices=("nav2_costmap_2d::StaticLayer",),
    )
    enabled: bool = param(True, "Whether the layer takes part.")
    map_topic: str = param("", "Topic of the map; empty takes the costmap's own.", read_only=True)
    map_subscribe_transient_local: bool = param(
        True, "Whether the map's publisher latches.", read_only=True
    )


@dataclass(frozen=True)
class SourceConfig:
    """One scan the obstacle layer listens to."""

    topic: str = param("scan", "Topic of the scan.", read_only=True)
    data_type: str = param("LaserScan", "Type of the data.", choices=("LaserScan",), read_only=True)
    marking: bool = param(True, "Whether returns mark obstacles.")
    clearing: bool = param(True, "Whether rays clear obstacles.")
    expected_update_rate: float = param(
        0.0, "Longest silence borne, as Nav2 names it; 0 bears any.", unit="s", minimum=0.0
    )
    inf_is_valid: bool = param(True, "Whether a beam without return clears its ray.")
    obstacle_max_range: float = param(2.5, "Longest range that marks.", unit="m", minimum=0.0)
    obstacle_min_range: float = param(0.0, "Shortest range that marks.", unit="m", minimum=0.0)
    raytrace_max_range: float = param(3.0, "Longest range cleared.", unit="m", minimum=0.0)
    raytrace_min_range: float = param(0.0, "Shortest range cleared.", unit="m", minimum=0.0)


@dataclass(frozen=True)
class CloudConfig(SourceConfig):
    """One cloud of points the obstacle layer listens to; by its height too."""

    topic: str = param("depth/points", "Topic of the cloud.", read_only=True)
    data_type: str = param(
        "PointCloud2", "Type of the data.", choices=("PointCloud2",), read_only=True
    )
    min_obstacle_height: float = param(0.0, "Lowest point that marks.", unit="m")
    max_obstacle_height: float = param(2.0, "Highest point that marks.", unit="m")


@dataclass(frozen=True)
class ObstacleConfig:
    """The layer that marks and clears what scans and clouds see."""

    plugin: str = param(
        "nav2_costmap_2d::ObstacleLayer",
        "Nav2's name of what is used.",
        choices=("nav2_costmap_2d::ObstacleLayer",),
    )
    enabled: bool = param(True, "Whether the layer takes part.")
    footprint_clearing_enabled: bool = param(True, "Whether the robot's own place is set free.")
    moving_time: float = param(
        1.5,
        "How far ahead the ways of what moves cost, and its old marks fade; 0 takes all for"
        " standing.",
        unit="s",
        minimum=0.0,
    )
    observation_sources: str = param(
        "scan", "The sources.", choices=("scan", "cloud", "scan cloud"), read_only=True
    )
    scan: SourceConfig = field(default_factory=SourceConfig)
    cloud: CloudConfig = field(default_factory=CloudConfig)
    origin_z: float = param(0.0, "Height of the lowest voxel of clouds.", unit="m")
    z_resolution: float = param(0.2, "Height of a voxel.", unit="m", minimum=0.01)
    z_voxels: int = param(10, "Voxels one above the other.", minimum=1, maximum=32)
    mark_threshold: int = param(
        0, "Marked voxels above a cell that is yet free.", minimum=0, maximum=32
    )


@dataclass(frozen=True)
class RangeConfig:
    """The layer that holds what sonars and infrared sensors tell."""

    plugin: str = param(
        "nav2_costmap_2d::RangeSensorLayer",
        "Nav2's name of what is used.",
        choices=("nav2_costmap_2d::RangeSensorLayer",),
    )
    enabled: bool = param(True, "Whether the layer takes part.")
    topics: tuple[str, ...] = param((), "Topics of the readings.", read_only=True)
    input_sensor_type: str = param(
        "ALL",
        "Which readings are taken: VARIABLE distances, those of a FIXED one, or both.",
        choices=("ALL", "VARIABLE", "FIXED"),
    )
    phi: float = param(1.2, "Distance beyond which a sensor is believed less.", unit="m")
    inflate_cone: float = param(
        1.0, "Share of a cone's area that cells may lie beside it.", minimum=0.0, maximum=1.0
    )
    clear_threshold: float = param(
        0.2, "Probability below which a cell is free.", minimum=0.0, maximum=1.0
    )
    mark_threshold: float = param(
        0.8, "Probability above which a cell is lethal.", minimum=0.0, maximum=1.0
    )
    clear_on_max_reading: bool = param(False, "Whether a reading of nothing frees its cone.")
    no_readings_timeout: float = param(
        0.0, "Longest silence of all sensors borne; 0 bears any.", unit="s", minimum=0.0
    )


@dataclass(frozen=True)
class DenoiseConfig:
    """The layer that sets small groups of lethal cells free; before the inflation."""

    plugin: str = param(
        "nav2_costmap_2d::DenoiseLayer",
        "Nav2's name of what is used.",
        choices=("nav2_costmap_2d::DenoiseLayer",),
    )
    enabled: bool = param(True, "Whether the layer takes part.")
    minimal_group_size: int = param(
        2, "Cells of the smallest group that stays.", minimum=0, maximum=100
    )
    group_connectivity_type: int = param(
        8, "Neighbours that a cell is in a group with.", choices=(4, 8)
    )


@dataclass(frozen=True)
class InflationConfig:
    """The layer that spreads cost round obstacles."""

    plugin: str = param(
        "nav2_costmap_2d::InflationLayer",
        "Nav2's name of what is used.",
        choices=("nav2_costmap_2d::InflationLayer",),
    )
    enabled: bool = param(True, "Whether the layer takes part.")
    inflation_radius: float = param(
        0.55, "Distance over which cost is spread.", unit="m", minimum=0.0, maximum=20.0
    )
    cost_scaling_factor: float = param(
        10.0, "Decay of the cost beyond the inscribed radius.", unit="1/m", minimum=0.0
    )
    inflate_unknown: bool = param(False, "Whether unknown cells take inflated cost.")


@dataclass(frozen=True)
class CostmapConfig:
    """A costmap and its layers.

    Raises:
        ConfigError: A layer does not exist, the static layer is asked for in a rolling window, or
            the footprint is none.
    """

    global_frame: str = param("map", "Frame of the grid.", read_only=True)
    robot_base_frame: str = param("base_link", "Frame of the robot.", read_only=True)
    map_topic: str = param("map", "Topic of the map.", read_only=True)
    update_frequency: float = param(
        5.0, "Updates a second.", unit="Hz", minimum=0.1, read_only=True
    )
    publish_frequency: float = param(
        1.0, "Publications a second.", unit="Hz", minimum=0.0, read_only=True
    )
    width: int = param(5, "Width without a map.", unit="m", minimum=1, read_only=True)
    height: int = param(5, "Height without a map.", unit="m", minimum=1, read_only=True)
    resolution: float = param(0.1, "Edge of a cell.", unit="m", minimum=0.005, read_only=True)
    origin_x: float = param(0.0, "Lower left corner without a map.", unit="m", read_only=True)
    origin_y: float = param(0.0, "Lower left corner without a map.", unit="m", read_only=True)
    rolling_window: bool = param(False, "Whether the grid follows the robot.", read_only=True)
    track_unknown_space: bool = param(False, "Whether unknown differs from free.", read_only=True)
    lethal_cost_threshold: int = param(
        100, "Occupancy from which a map's cell is lethal.", unit="%", minimum=1, maximum=100
    )
    trinary_costmap: bool = param(True, "Whether occupancy below the threshold is free.")
    robot_radius: float = param(0.1, "Radius of a circular robot.", unit="m", minimum=0.01)
    footprint: str = param("[]", "Corners [[x, y], ...] of a robot that is no circle.", unit="m")
    footprint_padding: float = param(0.01, "Added to the footprint.", unit="m", minimum=0.0)
    transform_tolerance: float = param(0.3, "Age of the transform borne.", unit="s", minimum=0.0)
    always_send_full_costmap: bool = param(
        True,
        "Whether the whole grid is published each time, beside what has changed in it; else only"
        " where its size or place changes and where someone subscribes.",
    )
    plugins: tuple[str, ...] = param(_DEFAULT, "Layers in order.", choices=LAYERS, read_only=True)
    static_layer: StaticConfig = field(default_factory=StaticConfig)
    obstacle_layer: ObstacleConfig = field(default_factory=ObstacleConfig)
    range_layer: RangeConfig = field(default_factory=RangeConfig)
    denoise_layer: DenoiseConfig = field(default_factory=DenoiseConfig)
    inflation_layer: InflationConfig = field(default_factory=InflationConfig)

    def __post_init__(self) -> None:
        if self.rolling_window and "static_layer" in self.plugins:
            layers = ", ".join(LAYERS[1:])
            raise ConfigError(f"a rolling_window has no static_layer; valid plugins: {layers}")
        Footprint.parse(self.footprint, self.robot_radius, self.footprint_padding)
