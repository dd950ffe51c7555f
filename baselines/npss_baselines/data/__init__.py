"""Motion: data sets where a user has them, and a generated gait that needs no data. Sources are registered here."""

from npss_baselines.data.motion import Clip
from npss_baselines.data.registry import SOURCES, pose_sources, register_source
from npss_baselines.data.source import PoseSource, Recording, Source

__all__ = ["SOURCES", "Clip", "PoseSource", "Recording", "Source", "pose_sources", "register_source"]
