"""Temporary entries of a registry."""

from contextlib import contextmanager


@contextmanager
def registered(registry, **entries):
    """Register entries by name, and remove them afterwards."""
    for name, entry in entries.items():
        registry.register(name, entry)
    try:
        yield
    finally:
        for name in entries:
            del registry._entries[name]
