"""Restorers: ways to restore motion that see which of its values are missing."""
