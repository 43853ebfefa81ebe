"""Learning to drive: Gymnasium's environments, and the task behind them."""

from __future__ import annotations


def register() -> None:
    """Make the environments known to Gymnasium, which must be installed."""
    import gymnasium

    gymnasium.register("arjuna/Navigate-v0", "arjuna_sim.learning.navigate:Navigate")
