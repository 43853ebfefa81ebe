"""The source of YAML files, by its name in `launch_yaml`."""

from launch.launch_description_sources import AnyLaunchDescriptionSource

YAMLLaunchDescriptionSource = AnyLaunchDescriptionSource
