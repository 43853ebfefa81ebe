"""Drives other than by two sides of wheels: mecanum, omni and steered wheels."""
