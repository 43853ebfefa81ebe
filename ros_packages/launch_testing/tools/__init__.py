"""Processes that a test starts by itself, and comparisons of their output."""

from launch_testing.tools.output import (
    basic_output_filter,
    expect_output,
    expected_output_from_file,
    get_default_filtered_patterns,
    get_default_filtered_prefixes,
)
from launch_testing.tools.process import ProcessProxy, launch_process
from launch_testing.tools.text import normalize_lineseps
