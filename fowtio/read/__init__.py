"""Readers: one module a format, each returning what the file says."""
