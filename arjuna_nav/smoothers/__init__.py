"""Path smoothers."""
