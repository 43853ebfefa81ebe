"""What a beam meets first."""
