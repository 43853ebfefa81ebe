"""Nav2's services as actions and conditions, and those that cancel others.

Source: nav2_behavior_tree, plugins/action and plugins/condition.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from arjuna_nav.trees.asking import Asking
from arjuna_nav.trees.node import Status, TreeNode
from arjuna_nav.trees.ports import NUMBER, PATH, POSE, REQUIRED, TEXT, Port

SERVICE_PORTS = {"service_name": Port(TEXT, REQUIRED), "server_timeout": Port(NUMBER, 0.0)}


class ClearEntireCostmap(Asking):
    """Clears a costmap."""

    KIND = "ClearEntireCostmap"
    PORTS: ClassVar[dict[str, Port]] = dict(SERVICE_PORTS)
    IS_RECOVERY = True

    def server(self) -> str:
        """Return the service's name."""
        return str(self.get("service_name"))


class ClearCostmapExceptRegion(ClearEntireCostmap):
    """Clears a costmap but for what is near the robot."""

    KIND = "ClearCostmapExceptRegion"
    PORTS: ClassVar[dict[str, Port]] = {**SERVICE_PORTS, "reset_distance": Port(NUMBER, 1.0)}
    FIELDS: ClassVar[Mapping[str, str]] = {"reset_distance": "reset_distance"}


class ClearCostmapAroundRobot(ClearCostmapExceptRegion):
    """Clears a costmap near the robot."""

    KIND = "ClearCostmapAroundRobot"


class ClearCostmapAroundPose(ClearCostmapExceptRegion):
    """Clears a costmap near a pose."""

    KIND = "ClearCostmapAroundPose"
    PORTS: ClassVar[dict[str, Port]] = {**ClearCostmapExceptRegion.PORTS, "pose": Port(POSE)}
    FIELDS: ClassVar[Mapping[str, str]] = {"reset_distance": "reset_distance", "pose": "pose"}


class IsPathValid(Asking):
    """Whether a path is free."""

    KIND, SERVER = "IsPathValid", "is_path_valid"
    PORTS: ClassVar[dict[str, Port]] = {
        "path": Port(PATH, None),
        "server_timeout": Port(NUMBER, 0.0),
    }
    FIELDS: ClassVar[Mapping[str, str]] = {"path": "path"}

    def tick(self) -> Status:
        """Ask; where there is no path yet, none is free."""
        return Status.FAILURE if self.get("path") is None else super().tick()

    def server(self) -> str:
        """Return the service's name."""
        return self.SERVER


class ReinitializeGlobalLocalization(Asking):
    """Lets the localization look for the robot everywhere."""

    KIND, SERVER = "Empty", "reinitialize_global_localization"
    PORTS: ClassVar[dict[str, Port]] = {
        "service_name": Port(TEXT, ""),
        "server_timeout": Port(NUMBER, 0.0),
    }
    IS_RECOVERY = True

    def server(self) -> str:
        """Return the service's name."""
        return self.get("service_name") or self.SERVER


class _Cancel(TreeNode):
    """Cancels what the tree asked of one action; whoever asked succeeds, as Nav2's nodes do."""

    PORTS: ClassVar[dict[str, Port]] = {
        "server_name": Port(TEXT, ""),
        "server_timeout": Port(NUMBER, 0.0),
    }
    KIND: ClassVar[str]

    def tick(self) -> Status:
        """Cancel it."""
        for node in self.running.asking:
            if isinstance(node, Asking) and node.KIND == self.KIND:
                node.cancel()
        return Status.SUCCESS


class CancelControl(_Cancel):
    """Cancels following."""

    KIND = "FollowPath"


class CancelSpin(_Cancel):
    """Cancels turning."""

    KIND = "Spin"


class CancelBackUp(_Cancel):
    """Cancels driving back."""

    KIND = "BackUp"


class CancelDriveOnHeading(_Cancel):
    """Cancels driving straight."""

    KIND = "DriveOnHeading"


class CancelWait(_Cancel):
    """Cancels waiting."""

    KIND = "Wait"


class CancelAssistedTeleop(_Cancel):
    """Cancels driving by hand."""

    KIND = "AssistedTeleop"


class CancelComputeAndTrackRoute(_Cancel):
    """Cancels tracking a route."""

    KIND = "ComputeAndTrackRoute"
