"""rosbag2's recorder and player in Python: `ros2 bag record` and `play` by their options."""

from __future__ import annotations

import signal
import threading
from argparse import Namespace
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, replace
from datetime import timedelta
from enum import Enum
from pathlib import Path
from signal import SIGINT, SIGTERM
from typing import Any, ClassVar

from rclpy.qos import QoSProfile
from rclpy.signals import (
    get_current_signal_handlers_options,
    install_signal_handlers,
    uninstall_signal_handlers,
)

from arjuna_core.bags.reader import Bag
from arjuna_core.errors import ArjunaError
from bringup.recording.convert import convert, read_outputs
from bringup.recording.play import play
from bringup.recording.record import record
from bringup.ros2.verbs.bag import logged, until
from bringup.ros2.verbs.bag import play_options as played
from bringup.ros2.verbs.bag import record_options as recorded
from rosbag2_py.options import StorageOptions
from rosbag2_py.writer import new_folder

_WORDS = {
    "topics": "topics_to_filter",
    "services": "services_to_filter",
    "regex": "regex_to_filter",
    "exclude_regex": "exclude_regex_to_filter",
    "exclude_topics": "exclude_topics_to_filter",
    "exclude_services": "exclude_service_events_to_filter",
    "remap": "topic_remapping_options",
    "clock": "clock_publish_frequency",
    "clock_topics_all": "clock_publish_on_topic_publish",
    "wait_for_all_acked": "wait_acked_timeout",
    "playback_until_nsec": "playback_until_timestamp",
}
"""Names of a player's options by those of `ros2 bag play`, where they differ."""


@dataclass(slots=True)
class RecordOptions:
    """Options of a recorder, by rosbag2_transport's names; those of `ros2 bag record`."""

    all_topics: bool = False
    all_services: bool = False
    is_discovery_disabled: bool = False
    topics: list[str] = field(default_factory=list)
    topic_types: list[str] = field(default_factory=list)
    services: list[str] = field(default_factory=list)
    exclude_topics: list[str] = field(default_factory=list)
    exclude_topic_types: list[str] = field(default_factory=list)
    exclude_service_events: list[str] = field(default_factory=list)
    rmw_serialization_format: str = ""
    topic_polling_interval: timedelta = timedelta(milliseconds=100)
    regex: str = ""
    exclude_regex: str = ""
    node_prefix: str = ""
    compression_mode: str = ""
    compression_format: str = ""
    compression_queue_size: int = 1
    compression_threads: int = 0
    compression_threads_priority: int = 0
    topic_qos_profile_overrides: dict[str, QoSProfile] = field(default_factory=dict)
    include_hidden_topics: bool = False
    include_unpublished_topics: bool = False
    ignore_leaf_topics: bool = False
    start_paused: bool = False
    use_sim_time: bool = False
    disable_keyboard_controls: bool = False

    @property
    def all(self) -> bool:
        """All topics, by the option's name before Jazzy."""
        return self.all_topics

    @all.setter
    def all(self, value: bool) -> None:
        self.all_topics = value

    @property
    def exclude(self) -> str:
        """The topics left out, by the option's name before Jazzy."""
        return self.exclude_regex

    @exclude.setter
    def exclude(self, value: str) -> None:
        self.exclude_regex = value


class ServiceRequestsSource(str, Enum):
    """The side of a service whose requests are asked again."""

    SERVICE_INTROSPECTION = "service_introspection"
    CLIENT_INTROSPECTION = "client_introspection"


@dataclass(slots=True)
class PlayOptions:
    """Options of a player, by rosbag2_transport's names; those of `ros2 bag play`."""

    read_ahead_queue_size: int = 1000
    node_prefix: str = ""
    rate: float = 1.0
    topics_to_filter: list[str] = field(default_factory=list)
    services_to_filter: list[str] = field(default_factory=list)
    regex_to_filter: str = ""
    exclude_regex_to_filter: str = ""
    exclude_topics_to_filter: list[str] = field(default_factory=list)
    exclude_service_events_to_filter: list[str] = field(default_factory=list)
    topic_qos_profile_overrides: dict[str, QoSProfile] = field(default_factory=dict)
    loop: bool = False
    topic_remapping_options: list[str] = field(default_factory=list)
    clock_publish_frequency: float = 0.0
    clock_publish_on_topic_publish: bool = False
    clock_topics: list[str] = field(default_factory=list)
    delay: float = 0.0
    playback_duration: float = -1.0
    playback_until_timestamp: int = -1
    start_paused: bool = False
    start_offset: float = 0.0
    disable_keyboard_controls: bool = False
    wait_acked_timeout: int = -1
    disable_loan_message: bool = False
    publish_service_requests: bool = False
    service_requests_source: str = ServiceRequestsSource.SERVICE_INTROSPECTION


class _Cancelled:
    """Runs something until it is cancelled, in the main thread also by signals."""

    _stop: ClassVar[threading.Event | None] = None

    def __init__(self, log_level: str = "info") -> None:
        self._level = log_level

    @classmethod
    def cancel(cls) -> None:
        """End what runs, from any thread."""
        if cls._stop is not None:
            cls._stop.set()

    @classmethod
    @contextmanager
    def _running(cls) -> Iterator[threading.Event]:
        """Yield what ends it; a signal that does is the program's own thereafter, as all later.

        rclpy's handlers are put back too: they wake a program that spins.
        """
        stop = cls._stop = threading.Event()
        if threading.current_thread() is not threading.main_thread():
            yield stop
            return
        came: list[int] = []

        def take(number: int, _: object) -> None:
            came.append(number)
            stop.set()

        options = get_current_signal_handlers_options()
        uninstall_signal_handlers()
        before = {number: signal.signal(number, take) for number in (SIGINT, SIGTERM)}
        try:
            yield stop
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
            install_signal_handlers(options)
        for one in came[:1]:
            signal.raise_signal(one)


class Recorder(_Cancelled):
    """Records topics into a new folder."""

    def record(
        self,
        storage_options: StorageOptions,
        record_options: RecordOptions,
        node_name: str = "rosbag2_recorder",
    ) -> None:
        """Record until `cancel`, or a signal.

        Raises:
            RuntimeError: The folder exists, an option is not known, or the disk refuses.
        """
        given, storage = record_options, storage_options
        words = Namespace(
            **_values(given),
            topics_positional=[],
            all=False,
            exclude_services=given.exclude_service_events,
            node_name=f"{given.node_prefix}{node_name}",
            qos_profile_overrides_path="",
            no_discovery=given.is_discovery_disabled,
            polling_interval=given.topic_polling_interval.total_seconds() * 1000.0,
            snapshot_mode=storage.snapshot_mode,
            max_cache_size=storage.max_cache_size,
        )
        overrides = _named(given.topic_qos_profile_overrides)
        try:
            options = replace(recorded(words), overrides=overrides)
            folder = new_folder(storage, given.compression_mode, given.compression_threads)
            with self._running() as stop:
                record(folder, options, logged(options.node_name, self._level), stop)
        except ArjunaError as error:
            raise RuntimeError(str(error)) from error


class Player(_Cancelled):
    """Publishes recordings."""

    def play(
        self, storage_options: StorageOptions | list[StorageOptions], play_options: PlayOptions
    ) -> None:
        """Play one or several recordings until their end, `cancel`, or a signal.

        Raises:
            RuntimeError: One cannot be read, or nothing is left to play.
        """
        self._play(storage_options, play_options, None)

    def burst(
        self,
        storage_options: StorageOptions | list[StorageOptions],
        play_options: PlayOptions,
        num_messages: int,
    ) -> None:
        """Publish the next messages at once, 0 for all, then stand still until `cancel`.

        Raises:
            RuntimeError: As `play`.
        """
        self._play(storage_options, play_options, num_messages)

    def _play(
        self, storages: StorageOptions | list[StorageOptions], given: PlayOptions, burst: int | None
    ) -> None:
        words = Namespace(
            **_values(given),
            **{word: getattr(given, name) for word, name in _WORDS.items()},
            qos_profile_overrides_path="",
            playback_until_sec=-1.0,
        )
        every = storages if isinstance(storages, list) else [storages]
        try:
            bags = [Bag(Path(each.uri.removeprefix("file://"))) for each in every]
            options = replace(
                until(played(words), bags, words),
                overrides=_named(given.topic_qos_profile_overrides),
                node_name=f"{given.node_prefix}rosbag2_player",
                paused=given.start_paused or burst is not None,
                burst=burst,
            )
            with self._running() as stop:
                play(bags, options, logged(options.node_name, self._level), stop)
        except ArjunaError as error:
            raise RuntimeError(str(error)) from error


def bag_rewrite(input_options: list[StorageOptions], output_config_file: str) -> None:
    """Write recordings again, as `ros2 bag convert` does by a file of output options.

    Raises:
        RuntimeError: One cannot be read, or the file or an output is not as it should be.
    """
    try:
        bags = [Bag(Path(each.uri.removeprefix("file://"))) for each in input_options]
        convert(bags, read_outputs(Path(output_config_file)))
    except ArjunaError as error:
        raise RuntimeError(str(error)) from error


def _values(options: RecordOptions | PlayOptions) -> dict[str, Any]:
    return {each.name: getattr(options, each.name) for each in fields(options)}


def _named(profiles: Mapping[str, QoSProfile]) -> dict[str, QoSProfile]:
    return {f"/{name.lstrip('/')}": profile for name, profile in profiles.items()}
