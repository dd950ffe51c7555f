"""Entries of a registry that are there for a while."""

from contextlib import contextmanager


@contextmanager
def registered(registry, **entries):
    """Register entries by name, and forget them afterwards."""
    for name, entry in entries.items():
        registry.register(name, entry)
    try:
        yield
    finally:
        for name in entries:
            del registry._entries[name]
