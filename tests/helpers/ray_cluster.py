"""Ray clusters on loopback for tests: nodes of one CPU each, all on this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

_ENVIRONMENT = {
    "RAY_AUTH_MODE": "token",
    "RAY_AUTH_TOKEN": "0" * 64,
    "RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER": "0",  # listen on loopback
    "RAY_USAGE_STATS_ENABLED": "0",
}


@contextmanager
def ray_cluster(*nodes: dict[str, Any]) -> Iterator[Any]:
    """Yield a `ray.cluster_utils.Cluster`: a head without CPUs, and nodes with some arguments."""
    os.environ.update(_ENVIRONMENT)
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)  # as `cluster_pool` does
    from ray.cluster_utils import Cluster

    head = {"num_cpus": 0, "include_dashboard": False}
    cluster = Cluster(initialize_head=True, head_node_args=head)
    try:
        for node in nodes:
            cluster.add_node(**{"num_cpus": 1, **node})
        yield cluster
    finally:
        cluster.shutdown()
