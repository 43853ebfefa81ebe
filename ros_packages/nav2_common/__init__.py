"""Nav2's `nav2_common`: what its launch files make of parameter files."""
