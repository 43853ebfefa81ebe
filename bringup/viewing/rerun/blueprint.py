"""How rerun's window is laid out."""

from __future__ import annotations

import rerun.blueprint as rrb

from bringup.viewing.rerun import curves


def blueprint(frame: str) -> rrb.Blueprint:
    """Return the layout: the room on the left, pictures, curves and words on the right.

    Args:
        frame: The frame that everything is drawn in.
    """
    room = rrb.Spatial3DView(
        name="Room",
        origin="/",
        contents=["+ /**", "- /camera/**", "- /curves/**", "- /logs/**", "- /states/**"],
        spatial_information=rrb.archetypes.SpatialInformation(target_frame=frame),
        eye_controls=rrb.archetypes.EyeControls3D(
            position=(-4.0, -6.0, 9.0), look_target=(0.0, 0.0, 0.0), eye_up=(0.0, 0.0, 1.0)
        ),
        line_grid=False,
    )
    right = rrb.Vertical(
        rrb.Spatial2DView(name="Camera", origin="/camera"),
        rrb.Tabs(
            rrb.TimeSeriesView(name="Speed [m/s]", origin=f"/{curves.SPEED}"),
            rrb.TimeSeriesView(name="Turn rate [rad/s]", origin=f"/{curves.TURN}"),
        ),
        rrb.Tabs(
            rrb.TimeSeriesView(name="Error [m], [rad]", origin=f"/{curves.ERROR}"),
            rrb.TimeSeriesView(name="To the goal", origin=f"/{curves.GOAL}"),
        ),
        rrb.StateTimelineView(name="Actions", origin="/states"),
        rrb.TextLogView(name="Words", origin="/logs"),
        row_shares=[3, 3, 3, 2, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(room, right, column_shares=[3, 2]),
        rrb.TimePanel(timeline="time"),
        collapse_panels=True,
    )
