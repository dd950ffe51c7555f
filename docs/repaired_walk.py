"""Draw the moving picture of the page "Repair motion": a damaged walk, repaired, and as it was."""

from __future__ import annotations

from pathlib import Path

from moving import SIZE, figures, svg

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import guess
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold import damaged, example, repair
from npss_baselines.manifold.motion.features import FPS, local_positions
from npss_baselines.manifold.motion.own_clip import prepare_clip

_COLOURS = ("#d55e00", "#0072b2", "#8a8f98")
#: The frames that are drawn: the damage, and a little before and after it.
_DRAWN = slice(45, 145)


def draw(folder: Path) -> None:
    """Draw the picture into a folder."""
    walk = example()
    broken = damaged(walk)
    places = [_places(clip) for clip in (broken, repair(broken).motion, walk)]
    seconds = len(places[0]) / FPS
    (folder / "repaired.svg").write_text(
        svg(3 * SIZE, SIZE, figures(places, _COLOURS, JOINTS.bones, seconds)), encoding="utf-8"
    )


def _places(clip: Bvh) -> Float64:
    """Return the positions of a clip's joints in the character's frame."""
    places: Float64 = local_positions(prepare_clip(clip, guess(clip.skeleton)).features)[_DRAWN]
    return places
