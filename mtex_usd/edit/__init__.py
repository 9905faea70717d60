"""Edits of recorded motion: pure functions from clip to clip."""
