"""What others wrote, read into the model's values."""
