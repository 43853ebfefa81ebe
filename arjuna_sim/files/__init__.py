"""Readers of the files of others, which give the model's values."""
