"""Parameters of a costmap, by Nav2's names; those of its layers stand in the layers' files."""

from __future__ import annotations

from dataclasses import dataclass

from arjuna_core.config import duration_param, fixed, length_param, param, plugin_names
from arjuna_nav.costmap.footprint import Footprint
from arjuna_nav.costmap.layers.observations import sources_of
from arjuna_nav.costmap.layers.plugins import LAYERS

_DEFAULT = ("static_layer", "obstacle_layer", "inflation_layer")


@dataclass(frozen=True)
class CostmapConfig:
    """A costmap; `arjuna_core.config.load` adds a field for each of its layers.

    Raises:
        ConfigError: The footprint is none.
    """

    global_frame: str = fixed("map", "Frame of the grid.")
    robot_base_frame: str = fixed("base_link", "Frame of the robot.")
    map_topic: str = fixed("map", "Topic of the map.")
    map_vis_z: float = param(0.0, "Height at which the costmap is shown.", unit="m")
    update_frequency: float = fixed(5.0, "Updates a second.", unit="Hz", minimum=0.1)
    publish_frequency: float = fixed(1.0, "Publications a second; none from 0 down.", unit="Hz")
    width: int = length_param(5, "Width without a map.", minimum=1, read_only=True)
    height: int = length_param(5, "Height without a map.", minimum=1, read_only=True)
    resolution: float = length_param(0.1, "Edge of a cell.", minimum=0.005, read_only=True)
    origin_x: float = fixed(0.0, "Lower left corner without a map.", unit="m")
    origin_y: float = fixed(0.0, "Lower left corner without a map.", unit="m")
    rolling_window: bool = fixed(False, "Whether the grid follows the robot.")
    track_unknown_space: bool = fixed(False, "Whether unknown differs from free.")
    unknown_cost_value: int = param(
        255, "Occupancy that a map's unknown cells have, of 0 to 255; -1 is 255."
    )
    lethal_cost_threshold: int = param(
        100, "Occupancy from which a map's cell is lethal, of 0 to 100.", unit="%"
    )
    trinary_costmap: bool = param(True, "Whether occupancy below the threshold is free.")
    use_maximum: bool = param(
        False, "Whether the map's costs count only where they are greater than those below them."
    )
    robot_radius: float = length_param(0.1, "Radius of a circular robot.")
    footprint: str = param("[]", "Corners [[x, y], ...] of a robot that is no circle.", unit="m")
    footprint_padding: float = param(0.01, "Added to the footprint.", unit="m")
    axle: float = param(
        0.0,
        "Where along x of its frame a robot's axle is, about whose points it turns: paths are"
        " planned and followed for it.",
        unit="m",
    )
    body: str = param(
        "",
        "The robot's own outline, [[x, y], ...], as its file says, where it stands out of the"
        " footprint without its padding: what stands beside it is kept, and the collision monitor,"
        " the final approach and the escape keep it free.",
        unit="m",
    )
    leave_obstacles: bool = param(
        True,
        "Whether a robot that touches an obstacle may move away; as Nav2 does, each motion from"
        " there collides.",
        theirs=False,
    )
    transform_tolerance: float = duration_param(0.3, "Oldest transform of the robot that is used.")
    initial_transform_timeout: float = duration_param(
        0.0,
        "How long a costmap that was activated waits for the robot's pose, and is inactive then; "
        "0: for ever.",
        theirs=60.0,
    )
    always_send_full_costmap: bool = param(
        False,
        "Whether the whole grid is published each time, beside what has changed in it; else only"
        " where its size or place changes and where someone subscribes.",
    )
    observation_sources: str = fixed(
        "", "Unused, as in Nav2: each obstacle layer has sources of its own."
    )
    plugins: tuple[str, ...] = plugin_names(_DEFAULT, "Layers in order.", LAYERS)
    filters: tuple[str, ...] = plugin_names((), "Layers after them, as zones are.", LAYERS)

    @property
    def scan_topics(self) -> dict[str, str]:
        """The topics of its layers' scans, by the parameters that name them."""
        return {
            f"{name}.{source}.topic": one.topic
            for name in self.plugins
            for source, one in sources_of(getattr(self, name)).items()
            if one.data_type == "LaserScan"
        }

    def __post_init__(self) -> None:
        self.outline()
        self.own_body()

    def outline(self) -> Footprint:
        """Return the robot's outline with its padding."""
        return Footprint.parse(self.footprint, self.robot_radius, self.footprint_padding, self.axle)

    def own_body(self) -> Footprint | None:
        """Return the robot's own outline where it is given."""
        return Footprint.parse(self.body, 0.0, 0.0, self.axle) if self.body else None
