"""What a costmap is made of: one file a layer, the registry of all, and what they share."""
