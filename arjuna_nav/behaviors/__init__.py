"""Recovery behaviours."""
