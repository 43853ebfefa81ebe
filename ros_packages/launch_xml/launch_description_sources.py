"""The source of XML files, by its name in `launch_xml`."""

from launch.launch_description_sources import AnyLaunchDescriptionSource

XMLLaunchDescriptionSource = AnyLaunchDescriptionSource
