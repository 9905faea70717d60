"""Readers of recorded motion files. Each gives plain arrays; none imports USD."""
