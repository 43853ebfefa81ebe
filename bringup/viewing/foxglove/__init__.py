"""A Foxglove WebSocket server: all topics as they are, publications and parameters."""
