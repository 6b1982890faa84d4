"""The gateway's commands, one per file; see :mod:`scenarios.cli`."""
