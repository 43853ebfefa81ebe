"""The displays in the panel: shown or hidden, with their settings, added, removed and saved."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

from arjuna_core.param import info_of
from bringup.viewing.displays.base import DISPLAYS, Display, kinds_of, rviz_name

_NONE = "–"


class DisplayList:
    """A box for each display, and one display's settings.

    Each use queues a call of what its attributes hold; displays are named by their keys.
    """

    show: Callable[[str, bool], None]
    change: Callable[[str, str, Any], None]
    rename: Callable[[str, str], None]
    remove: Callable[[str], None]
    add: Callable[[str, str], None]  # a kind and a topic, empty for its own
    choose: Callable[[str], None]
    save: Callable[[Any], None]  # the browser that asked
    load: Callable[[bytes], None]

    def __init__(self, gui: Any, call: Callable[..., Any]) -> None:
        self._gui, self._call = gui, call
        self._boxes: dict[str, Any] = {}
        self._names: dict[str, str] = {}
        self._topics: dict[str, tuple[str, str]] = {}
        self._folder = gui.add_folder("Displays")
        self._about = gui.add_folder("Settings of a display", expand_by_default=False)
        with self._about:
            self._chosen = gui.add_dropdown("Display", (_NONE,))
            self._status = gui.add_markdown("")
            self._settings = gui.add_folder(None)
            remove = gui.add_button("Remove this display", color="gray")
        self._chosen.on_update(call(lambda: self.choose(self.chosen)))
        remove.on_click(call(lambda: self.remove(self.chosen)))
        with gui.add_folder("Add a display", expand_by_default=False):
            self._topic = gui.add_dropdown("By topic", (_NONE,))
            by_topic = gui.add_button("Add the topic", color="gray")
            self._kind = gui.add_dropdown("By type", tuple(sorted(DISPLAYS.types)))
            by_kind = gui.add_button("Add the type", color="gray")
            save = gui.add_button("Save as .rviz", color="gray")
            load = gui.add_upload_button("Open a .rviz file", mime_type=".rviz,.yaml")
        by_topic.on_click(call(self._add_topic, lambda: self._topic.value))
        by_kind.on_click(call(lambda kind: self.add(kind, ""), lambda: self._kind.value))
        load.on_upload(call(lambda content: self.load(content), lambda: load.value.content))

        async def saved(event: Any) -> None:
            await call(lambda: self.save(event.client))(event)

        save.on_click(saved)

    @property
    def chosen(self) -> str:
        """The key of the display whose settings are shown, or ""."""
        return next((key for key, name in self._names.items() if name == self._chosen.value), "")

    def put(self, key: str, name: str, shown: bool) -> None:
        """Add a box for a display; names that occur twice get a number."""
        number, unique = 2, name
        while unique in self._names.values():
            unique, number = f"{name} {number}", number + 1
        self._names[key] = unique
        with self._folder:
            box = self._boxes[key] = self._gui.add_checkbox(unique, shown)
        box.on_update(self._call(lambda value: self.show(key, value), lambda: box.value))
        self._chosen.options = tuple(self._names.values())

    def drop(self, key: str) -> None:
        """Remove a display's box."""
        self._boxes.pop(key).remove()
        del self._names[key]
        self._chosen.options = tuple(self._names.values()) or (_NONE,)

    def offer(self, topics: Mapping[str, str]) -> None:
        """Offer the topics that displays are for, by the type of each."""
        found = {
            f"{topic} ({kind})": (topic, kind)
            for topic, type_name in sorted(topics.items())
            for kind in kinds_of(type_name)
        }
        if found != self._topics:
            self._topics = found
            self._topic.options = tuple(found) or (_NONE,)

    def _add_topic(self, label: str) -> None:
        if label in self._topics:
            topic, kind = self._topics[label]
            self.add(kind, topic)

    def show_status(self, text: str) -> None:
        """Show how the chosen display fares."""
        if self._status.content != text:
            self._status.content = text

    def select(self, key: str) -> None:
        """Choose a display."""
        self._chosen.value = self._names[key]

    def show_settings(self, key: str, display: Display, topics: Mapping[str, str]) -> None:
        """Show a display's settings in place of another's."""
        self._settings.remove()
        with self._about:
            self._settings = self._gui.add_folder(None, order=self._status.order + 0.5)
        with self._settings:
            if display.types:
                fitting = [name for name, kind in sorted(topics.items()) if kind in display.types]
                names = dict.fromkeys((display.name, *fitting))
                topic = self._gui.add_dropdown(display.property, tuple(names))
                topic.on_update(
                    self._call(lambda value: self.rename(key, value), lambda: topic.value)
                )
            for each in dataclasses.fields(display.config):
                self._add_field(key, each, getattr(display.config, each.name))

    def _add_field(self, key: str, each: dataclasses.Field[Any], value: Any) -> None:
        gui, info, label = self._gui, info_of(each), rviz_name(each.name)
        unit = f" [{info.unit}]" if info.unit and "(" not in label else ""
        common: dict[str, Any] = {"hint": info.description}
        if isinstance(value, bool):
            handle = gui.add_checkbox(label, value, **common)
        elif isinstance(value, (int, float)):
            low, high = info.bounds
            step = 1 if isinstance(value, int) else 0.001
            handle = gui.add_number(label + unit, value, min=low, max=high, step=step, **common)
        elif isinstance(value, tuple):
            handle = gui.add_rgb(label, value, **common)
        elif info.choices:
            handle = gui.add_dropdown(label, info.choices, initial_value=value, **common)
        else:
            handle = gui.add_text(label, value, **common)
        handle.on_update(
            self._call(lambda given: self.change(key, each.name, given), lambda: handle.value)
        )
