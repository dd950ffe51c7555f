"""Pin ``npss-metric`` to the version of ``npss-baselines``: the two are released together."""

from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface


class PinnedMetadataHook(MetadataHookInterface):
    """Add the pin to the dependencies that pyproject.toml lists."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Set the dependencies."""
        metadata["dependencies"] = [f"npss-metric[h5]=={metadata['version']}", *self.config["dependencies"]]
