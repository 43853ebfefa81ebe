"""Foxglove's protocol: topics as they are, publications, services, parameters, the graph."""
