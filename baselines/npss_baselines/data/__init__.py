"""Sources of motion: data sets that a user has, a generated gait, and a registry for more."""

from npss_baselines.data.motion import Clip
from npss_baselines.data.registry import SOURCES, pose_sources, register_source
from npss_baselines.data.source import PoseSource, Recording, Source
from npss_baselines.data.tasks import Task

__all__ = ["SOURCES", "Clip", "PoseSource", "Recording", "Source", "Task", "pose_sources", "register_source"]
