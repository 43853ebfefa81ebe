"""aggregator_node: /diagnostics as a tree on /diagnostics_agg."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from arjuna_core.config import NoParameters, fixed, param
from arjuna_core.plugins import with_configs, with_values
from arjuna_core.ros import qos
from arjuna_core.ros.convert import header
from arjuna_core.ros.node import ManagedNode
from arjuna_sim.processing.diagnostics import (
    Aggregator,
    Analyzer,
    AnalyzerConfig,
    Status,
    analyzers,
)


@dataclass(frozen=True)
class AggregatorConfig:
    """Parameters of the node `analyzers`; each analyzer adds its own, as `arms.type`."""

    path: str = fixed("", "What stands before all names in the tree.")
    pub_rate: float = param(1.0, "Rate of the output.", unit="Hz", minimum=0.01, maximum=100.0)
    other_as_errors: bool = fixed(False, "Whether statuses that no analyzer takes are errors.")

    critical: bool = param(False, "Whether what is worse than before is published at once.")

    @classmethod
    def config_for(cls, values: Mapping[str, Any]) -> type[AggregatorConfig]:
        """Return the class with the analyzers that values name."""
        return with_configs(cls, _analyzers(values))


def _analyzers(values: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    names = [key.partition(".")[0] for key in values if "." in key]
    found = []
    for name in dict.fromkeys(filter(str.isidentifier, names)):
        below = f"{name}."
        own = {k.removeprefix(below): v for k, v in values.items() if k.startswith(below)}
        config: Any = NoParameters
        if name != "analyzers" or "type" in own:
            texts = tuple(sorted(_texts(own)))
            config = with_values(AnalyzerConfig, texts, "", "The only one of them.", True)
        found.append((name, with_configs(config, _analyzers(own))))
    return tuple(found)


def _texts(values: Mapping[str, Any]) -> list[str]:
    """Return which names of an analyzer are one text, not a list, as both are valid."""
    keys = (item.name for item in dataclasses.fields(AnalyzerConfig) if item.default == ())
    return [key for key in keys if isinstance(values.get(key), str)]


class DiagnosticAggregatorNode(ManagedNode):
    """Publishes the tree of diagnostics, and the worst level of all."""

    Config = AggregatorConfig
    DEFAULT_NAME = "analyzers"

    def configure(self) -> None:
        """Build the tree and create the topics."""
        config: AggregatorConfig = self.config
        base = f"/{config.path.strip('/')}" if config.path.strip("/") else ""
        other = Analyzer(AnalyzerConfig(), f"{base}/Other")
        self._tree = Aggregator(tuple(analyzers(config, base)), other, config.other_as_errors)
        self._out = self.publisher(DiagnosticArray, "/diagnostics_agg", qos.DEFAULT)
        self._whole = self.publisher(DiagnosticStatus, "/diagnostics_toplevel_state", qos.DEFAULT)
        self._worst = 0
        self.subscribe(DiagnosticArray, "/diagnostics", self._on_diagnostics, qos.TF)
        self.every(1.0 / config.pub_rate, self._publish)

    def _on_diagnostics(self, message: Any) -> None:
        worse = self._worst
        for one in message.status:
            values = tuple((item.key, item.value) for item in one.values)
            level = int.from_bytes(one.level, "big")
            self._tree.take(Status(one.name, level, one.message, one.hardware_id, values, self.now))
            worse = max(worse, level)
        if self.config.critical and worse > self._worst:
            self._publish()

    def _publish(self) -> None:
        statuses, level = self._tree.report(self.now)
        self._worst = level
        found = DiagnosticArray(header=header("", self.now))
        found.status = [
            DiagnosticStatus(
                level=bytes((one.level,)),
                name=one.name,
                message=one.message,
                hardware_id=one.hardware_id,
                values=[KeyValue(key=key, value=value) for key, value in one.values],
            )
            for one in statuses
        ]
        self._out.publish(found)
        self._whole.publish(DiagnosticStatus(name="toplevel_state", level=bytes((level,))))
