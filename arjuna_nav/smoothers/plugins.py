"""Which smoothers there are, by Nav2's class names."""

from __future__ import annotations

from arjuna_core.plugins import PluginTypes

_SIMPLE = "nav2_smoother::SimpleSmoother"

SMOOTHERS = PluginTypes(
    "smoother",
    {
        _SIMPLE: "arjuna_nav.smoothers.simple:SimpleSmoother",
        "nav2_smoother::SavitzkyGolaySmoother": (
            "arjuna_nav.smoothers.savitzky_golay:SavitzkyGolaySmoother"
        ),
    },
    _SIMPLE,
)
