"""Learning to drive: Gymnasium's environments, and the task behind them."""

from __future__ import annotations


def register() -> None:
    """Make the environments known to Gymnasium, which must be installed."""
    import gymnasium

    gymnasium.register("arjuna/Navigate-v0", "arjuna_sim.learning.navigate:Navigate")
    gymnasium.register(
        "arjuna/NavigateBatch-v0",
        vector_entry_point="arjuna_sim.learning.navigate_batch:NavigateBatch",
    )
