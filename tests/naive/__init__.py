"""Slow, obvious twins of the fast code: loops from the paper, no cleverness."""
