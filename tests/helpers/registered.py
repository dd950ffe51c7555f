"""Temporary entries of registries."""

from contextlib import contextmanager


@contextmanager
def restored(*registries):
    """Undo afterwards what is registered, replaced or removed in between."""
    before = [(registry, dict(registry._entries), dict(registry._plugins)) for registry in registries]
    try:
        yield
    finally:
        for registry, entries, plugins in before:
            registry._entries, registry._plugins = entries, plugins


@contextmanager
def registered(registry, **entries):
    """Register entries by name, and remove them afterwards."""
    with restored(registry):
        for name, entry in entries.items():
            registry.register(name, entry)
        yield
