"""Tests of what a launch file describes, by launch_testing's names; see docs/ci.md."""

from __future__ import annotations

from launch.by_file import import_as

from bringup.ros2.verbs.launch import prepare
from launch_testing import actions, asserts, event_handlers, markers, records, tools, util
from launch_testing.markers import parametrize, post_shutdown_test
from launch_testing.records import (
    ActiveIoHandler,
    ActiveProcInfoHandler,
    IoHandler,
    ProcInfoHandler,
)

import_as("launch_testing", dict.fromkeys(("parametrize", "post_shutdown_test"), markers))
import_as("launch_testing", dict.fromkeys(("io_handler", "proc_info_handler"), records))
prepare()  # what a file's own imports look up is there, whoever runs it
