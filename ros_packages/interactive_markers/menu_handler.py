"""Menus of interactive markers: entries with titles, check boxes and callbacks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from visualization_msgs.msg import InteractiveMarkerFeedback, MenuEntry

from interactive_markers.interactive_marker_server import Callback, InteractiveMarkerServer


@dataclass
class _Entry:
    title: str
    command: str
    command_type: int
    callback: Callable[[InteractiveMarkerFeedback], object] | None
    visible: bool = True
    check_state: int = 0
    parts: list[int] = field(default_factory=list)


class MenuHandler:
    """A menu that several markers may have."""

    NO_CHECKBOX, CHECKED, UNCHECKED = 0, 1, 2

    def __init__(self) -> None:
        self._entries: dict[int, _Entry] = {}
        self._top: list[int] = []
        self._managed: list[str] = []

    def insert(
        self,
        title: str,
        parent: int | None = None,
        command_type: int = MenuEntry.FEEDBACK,
        command: str = "",
        callback: Callback | None = None,
    ) -> int | None:
        """Add an entry, below another if one is named, and return its handle; None without it."""
        if parent is not None and parent not in self._entries:
            return None
        handle = len(self._entries) + 1
        self._entries[handle] = _Entry(title, command, command_type, callback)
        (self._top if parent is None else self._entries[parent].parts).append(handle)
        return handle

    def setVisible(self, handle: int, visible: bool) -> bool:
        """Show or hide an entry and those below it."""
        if handle not in self._entries:
            return False
        self._entries[handle].visible = visible
        return True

    def setCheckState(self, handle: int, check_state: int) -> bool:
        """Give an entry a check box, filled or empty, or none."""
        if handle not in self._entries:
            return False
        self._entries[handle].check_state = check_state
        return True

    def getCheckState(self, handle: int) -> int | None:
        """Return the state of an entry's check box."""
        return self._entries[handle].check_state if handle in self._entries else None

    def getTitle(self, handle: int) -> str | None:
        """Return an entry's title."""
        return self._entries[handle].title if handle in self._entries else None

    def apply(self, server: InteractiveMarkerServer, marker_name: str) -> bool:
        """Give a marker this menu; False where there is no such marker."""
        marker = server.get(marker_name)
        if marker is None:
            self._managed = [each for each in self._managed if each != marker_name]
            return False
        marker.menu_entries = self._listed(self._top, 0)
        server.insert(marker)
        server.setCallback(marker_name, self._chosen, InteractiveMarkerFeedback.MENU_SELECT)
        if marker_name not in self._managed:
            self._managed.append(marker_name)
        return True

    def reApply(self, server: InteractiveMarkerServer) -> bool:
        """Give this menu, as it is now, to all markers that have it."""
        return all(self.apply(server, name) for name in list(self._managed))

    def _listed(self, handles: list[int], parent: int) -> list[MenuEntry]:
        listed = []
        for handle in handles:
            entry = self._entries[handle]
            if entry.visible:
                box = {self.CHECKED: "[x] ", self.UNCHECKED: "[ ] "}.get(entry.check_state, "")
                shown = MenuEntry(id=handle, parent_id=parent, title=box + entry.title)
                shown.command, shown.command_type = entry.command, entry.command_type
                listed += [shown, *self._listed(entry.parts, handle)]
        return listed

    def _chosen(self, feedback: InteractiveMarkerFeedback) -> None:
        entry = self._entries.get(feedback.menu_entry_id)
        if entry is not None and entry.callback is not None:
            entry.callback(feedback)
