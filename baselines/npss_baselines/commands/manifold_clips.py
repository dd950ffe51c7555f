"""``npss-baselines manifold repair``, ``fill``, ``inbetween`` ...: clips of one's own, from BVH files to BVH files."""

from __future__ import annotations

import argparse
import math
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss.console import Progress, table
from npss.files import check_output, write_figure_atomically, write_text_atomically
from npss_baselines.data import bvh, bvh_writer
from npss_baselines.data import mapping as joint_mapping

if TYPE_CHECKING:
    from npss_baselines.data.bvh import Bvh
    from npss_baselines.data.mapping import JointMapping
    from npss_baselines.manifold import Outcome
    from npss_baselines.manifold.clips.gap import Line
    from npss_baselines.manifold.model.projector import Manifold
    from npss_baselines.manifold.show.side_by_side import Shown

#: The height in metres that lengths are given for: a file does not name its unit.
_HEIGHT = 1.7
_CLIP, _PAGE, _PICTURES = ".bvh", ".html", (".svg", ".pdf", ".png")


def add_parsers(commands: Any) -> None:
    """Add the commands."""
    repair = _add(commands, "repair", "restore what is missing or damaged in a clip", run_repair, restores=True)
    repair.add_argument(
        "--missing",
        nargs="+",
        metavar="JOINT",
        help="restore the places of these joints and of all below them: those right above them turn, too (default: "
        "what is found: values that are nan, joints that are held, joints that jump)",
    )
    repair.add_argument(
        "--only", nargs="+", metavar="JOINT", help="of the joints that are found, restore these (default: all)"
    )
    repair.add_argument(
        "--shortest",
        metavar="TIME",
        help="find joints that are held this long or longer: .25s is in seconds, 10 in frames (default: .1s)",
    )
    repair.add_argument(
        "--insert",
        metavar="TIME",
        help="insert as many frames before --at, where some were deleted: .5s is in seconds, 60 in frames",
    )
    repair.add_argument("--at", metavar="TIME", help="insert before this time: 2s is in seconds, 60 is a frame")
    fill = _add(commands, "fill", "fill in a joint and those below it", run_fill, restores=True)
    fill.add_argument("--joint", required=True, metavar="JOINT", help="fill in this joint, such as RightHand")
    for parser in (repair, fill):
        for option, dest, when in (("--from", "start", "from"), ("--to", "end", "until before")):
            parser.add_argument(
                option,
                dest=dest,
                metavar="TIME",
                help=f"restore {when} this time: 2s is in seconds, 60 is a frame of the file, from 0 on (default: the "
                f"whole clip)",
            )
    inbetween = _add(commands, "inbetween", "make the frames between keys", run_inbetween, restores=True)
    keys = inbetween.add_mutually_exclusive_group()
    keys.add_argument("--every", type=int, metavar="N", help="take every N-th frame of the file as a key")
    keys.add_argument(
        "--keys",
        nargs="+",
        type=int,
        metavar="FRAME",
        help="take these frames of the file as keys, from 0 on (default: those that differ from the frame before)",
    )
    interpolate = _add(commands, "interpolate", "interpolate two clips, on the skeleton of the first", run_interpolate)
    interpolate.add_argument("second", type=Path, metavar="OTHER", help="the second clip, a BVH file")
    interpolate.add_argument(
        "--share", type=float, default=0.5, metavar="S", help="the share of the second, 0 to 1 (default: %(default)s)"
    )
    nearest = _add(commands, "nearest", "list the clips nearest to a clip", run_nearest)
    nearest.add_argument("folder", type=Path, metavar="FOLDER", help="the folder of the other clips, BVH files")
    nearest.add_argument("-n", type=int, default=5, metavar="N", help="list N clips (default: %(default)s)")
    for parser in (interpolate, nearest):
        parser.add_argument(
            "--manifold",
            type=Path,
            metavar="RUN",
            help="use the hidden units of this manifold (default: use features)",
        )
    project = _add(commands, "project", "project a clip onto a manifold", run_project)
    project.add_argument("runs", nargs=1, type=Path, metavar="RUN", help="the folder of a run")
    sample: argparse.ArgumentParser = commands.add_parser(
        "sample",
        help="sample motion from a manifold",
        description="Sample motion from a manifold, on the common skeleton.",
    )
    sample.add_argument("runs", nargs=1, type=Path, metavar="RUN", help="the folder of a run")
    sample.add_argument(
        "--like",
        nargs="+",
        type=Path,
        required=True,
        metavar="CLIP",
        help="draw motion like that of these clips, BVH files with five windows of N frames or more in all, each an "
        "eighth of N after the one before",
    )
    sample.add_argument("--frames", type=int, default=160, metavar="N", help="sample N frames (default: %(default)s)")
    sample.add_argument("--seed", type=int, default=0, metavar="N", help="set the seed (default: %(default)s)")
    _add_output(sample)
    sample.set_defaults(run=run_sample, extra="manifold")
    mapping: argparse.ArgumentParser = commands.add_parser(
        "mapping",
        help="show which joints of a clip are the common ones",
        description="Show which joints of a clip are the 20 common ones, as guessed from names and hierarchy. Edit the "
        "file, and give it to the other commands with --mapping.",
    )
    mapping.add_argument("clip", type=Path, metavar="CLIP", help="the clip, a BVH file")
    mapping.add_argument("-o", "--output", type=Path, metavar="FILE", help="write the mapping to this JSON file")
    mapping.set_defaults(run=run_mapping, extra="manifold")
    example: argparse.ArgumentParser = commands.add_parser(
        "example",
        help="write a generated clip, to try the other commands",
        description="Write a generated walk, to try the other commands.",
    )
    example.add_argument(
        "--damaged", action="store_true", help="hold the left leg from 2 to 3.5 s, and let the head jump at 4.3 s"
    )
    _add_output(example)
    example.set_defaults(run=run_example, extra="manifold")


def _add(commands: Any, name: str, summary: str, run: Any, *, restores: bool = False) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=f"{summary[0].upper()}{summary[1:]}."
    )
    parser.add_argument("clip", type=Path, metavar="CLIP", help="the clip, a BVH file")
    if restores:
        parser.add_argument(
            "--restorer",
            type=Path,
            metavar="FILE",
            help="restore by this file of `npss-baselines train restorer` (default: that of the package, or else "
            "interpolation in time)",
        )
        parser.add_argument(
            "--truth", type=Path, metavar="FILE", help="compare with this BVH file, the clip without damage"
        )
    parser.add_argument(
        "--mapping",
        nargs="+",
        type=Path,
        default=[],
        metavar="FILE",
        help="read the common joints from this file of `npss-baselines manifold mapping`; of two clips, from two "
        "(default: guess them)",
    )
    parser.add_argument(
        "--up", choices=("y", "z"), help="the axis that points up (default: where the head is above the feet)"
    )
    _add_output(parser)
    parser.set_defaults(run=run, extra="manifold")
    return parser


def _add_output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "-o",
        "--output",
        action="append",
        type=Path,
        default=[],
        metavar="FILE",
        help="write the clip (.bvh), a moving page (.html) or a picture (.svg, .pdf or .png); may be given several "
        "times (default: only say what would be written)",
    )


def run_repair(options: argparse.Namespace) -> None:
    """Repair a clip."""
    from npss_baselines.manifold import insert, repair
    from npss_baselines.manifold.clips.finding import HELD

    motion = _read(options)
    start, end = _times(options, motion)
    missing = options.missing
    if (options.insert is None) != (options.at is None):
        raise ValueError("--insert: expected --insert and --at together")
    if options.insert is not None:
        if missing is not None or (start, end) != (0, None):
            raise ValueError("--insert: expected no --missing, --from or --to; repair the clip that is written again")
        at, count = _frame("--at", options.at, motion.fps), _frame("--insert", options.insert, motion.fps)
        motion = insert(motion, at, count)
        missing, start, end = ["Hips"], at, at + count
    elif missing is None and (start, end) != (0, None):
        raise ValueError("--missing JOINT: needed with --from and --to; without it, the whole clip is searched")
    if missing is not None and (options.only is not None or options.shortest is not None):
        raise ValueError("--only, --shortest: choose from what is found; expected no --missing or --insert")
    shortest = HELD if options.shortest is None else _frame("--shortest", options.shortest, motion.fps) / motion.fps
    outcome = repair(
        motion,
        missing=missing,
        start=start,
        end=end,
        only=options.only,
        shortest=shortest,
        restorer=_restorer(options),
        **_read_as(options),
    )
    _restored(options, motion, outcome, searched=missing is None)


def run_fill(options: argparse.Namespace) -> None:
    """Fill in a joint of a clip."""
    from npss_baselines.manifold import fill

    motion = _read(options)
    start, end = _times(options, motion)
    outcome = fill(motion, options.joint, start=start, end=end, restorer=_restorer(options), **_read_as(options))
    _restored(options, motion, outcome)


def run_inbetween(options: argparse.Namespace) -> None:
    """Make the frames between keys of a clip."""
    from npss_baselines.manifold import inbetween

    motion = _read(options)
    outcome = inbetween(
        motion, keys=options.keys, every=options.every, restorer=_restorer(options), **_read_as(options)
    )
    _restored(options, motion, outcome)


def run_interpolate(options: argparse.Namespace) -> None:
    """Interpolate two clips."""
    from npss_baselines.manifold import interpolate
    from npss_baselines.manifold.show.side_by_side import Shown

    _check_outputs(options, [options.clip, options.second, *options.mapping])
    motion, other = bvh.read(options.clip), bvh.read(options.second)
    files = (*options.mapping, None, None)[:2]
    mappings = [_mapping(clip, file) for clip, file in zip((motion, other), files, strict=True)]
    outcome = interpolate(
        motion, other, options.share, manifold=_manifold(options.manifold), mappings=mappings, up=options.up
    )
    n_frames = len(outcome.motion.rotations)
    how = (
        f"interpolated with {options.share:g} of {options.second}, {outcome.way}: both are stretched to {n_frames} "
        f"frames ({n_frames / motion.fps:.2f} s); steps are not aligned, and a T-pose at the beginning stays"
    )
    _say(options, motion, outcome, how)
    shown = {
        f"0: {options.clip.stem}": Shown(motion, mappings[0], outcome.up),
        f"between: {options.share:g}": Shown(outcome.motion, outcome.mapping, outcome.up),
        f"1: {options.second.stem}": Shown(other, mappings[1], options.up or _up(other, mappings[1])),
    }
    _write(options, outcome.motion, shown)


def run_nearest(options: argparse.Namespace) -> None:
    """List the clips nearest to a clip."""
    from npss_baselines.manifold import nearest
    from npss_baselines.manifold.show.side_by_side import Shown

    files = [file for file in sorted(options.folder.rglob("*")) if file.suffix.lower() == ".bvh" and file.is_file()]
    files = [file for file in files if not file.samefile(options.clip)]
    if not files:
        raise ValueError(f"{options.folder}: expected a folder with other BVH files")
    _check_outputs(options, [options.clip, *options.mapping, *files], clip=False)
    motion = bvh.read(options.clip)
    by_name = {file.relative_to(options.folder).as_posix(): file for file in files}

    unread: list[str] = []

    def skip(name: str, error: Exception) -> None:
        print(f"left out: {name}: {str(error).removeprefix(f'{by_name[name]}: ')}", file=sys.stderr)

    def clips() -> Iterator[tuple[str, Bvh]]:
        with Progress("reading clips") as progress:
            for done, (name, file) in enumerate(by_name.items(), 1):
                try:
                    clip = bvh.read(file)
                except (OSError, ValueError) as error:
                    skip(name, error)
                    unread.append(name)
                else:
                    yield name, clip
                progress(done / len(by_name))
        if len(unread) == len(by_name):
            raise ValueError(f"{options.folder}: none of its BVH files can be read")

    ranked = nearest(motion, clips(), manifold=_manifold(options.manifold), skip=skip, **_read_as(options))
    how = "distance G of the manifold" if options.manifold else "extremes of positions and velocities"
    print(f"nearest to {options.clip} of {len(ranked)} clips, by {how}; smaller is more alike, only the order counts:")
    ranked = ranked[: options.n]
    print(table(("clip", "distance"), [(name, f"{distance:.4g}") for name, distance in ranked], "lr"))
    if options.output:
        chosen = {options.clip.stem: motion} | {name: bvh.read(by_name[name]) for name, _ in ranked}
        shown = {}
        for name, clip in chosen.items():
            own = _mapping(clip, *options.mapping[:1])
            shown[name] = Shown(clip, own, options.up or _up(clip, own))
        _write(options, None, shown)


def run_project(options: argparse.Namespace) -> None:
    """Project a clip onto a manifold."""
    from npss_baselines.manifold import project

    _check_outputs(options, [options.clip, *options.mapping])
    motion = bvh.read(options.clip)
    manifold = _manifold(options.runs[0])
    assert manifold is not None
    outcome = project(motion, manifold, **_read_as(options))
    _say(options, motion, outcome, f"projected by {outcome.way}")
    _write(options, outcome.motion, _before_and_after(options, motion, outcome))


def run_sample(options: argparse.Namespace) -> None:
    """Sample motion."""
    import numpy as np

    from npss_baselines.manifold import sample
    from npss_baselines.manifold.clips.search import features_of
    from npss_baselines.manifold.model.prior import NEIGHBOURS
    from npss_baselines.manifold.motion.windows import windows_of
    from npss_baselines.manifold.show.side_by_side import Shown

    _check_outputs(options, options.like)
    if options.frames < 1:
        raise ValueError(f"--frames: expected one or more, got {options.frames}")
    size = {"window": options.frames, "step": max(1, options.frames // 8)}
    real = np.concatenate([windows_of(features_of(bvh.read(clip)), **size)[0] for clip in options.like])
    if len(real) <= NEIGHBOURS:
        raise ValueError(
            f"--like: the clips give {len(real)} {'window' if len(real) == 1 else 'windows'} of {options.frames} "
            f"frames at 30 per second, but {NEIGHBOURS + 1} are needed; give longer or more clips, or fewer --frames"
        )
    manifold = _manifold(options.runs[0])
    assert manifold is not None
    outcome = sample(manifold, n_frames=options.frames, real=real, seed=options.seed)
    print(f"sampled by {outcome.way}: {options.frames} frames, seed {options.seed}")
    _write(options, outcome.motion, {"sample": Shown(outcome.motion, outcome.mapping, outcome.up)})


def run_mapping(options: argparse.Namespace) -> None:
    """Show the common joints of a clip."""
    skeleton = bvh.read(options.clip, missing=True).skeleton
    if options.output:
        check_output(options.output, [options.clip])
    try:
        guessed = joint_mapping.guess(skeleton)
    except ValueError as error:
        if options.output is None:
            raise
        print("the joints of the clip, each below the one that carries it:")
        for line in joint_mapping.tree(skeleton):
            print(f"  {line}")
        joint_mapping.write_blank(options.output)
        print(f"not guessed: {str(error).partition(';')[0]}", file=sys.stderr)
        print(f"{options.output}: fill in the blanks with names of joints of the clip", file=sys.stderr)
        return
    print(guessed)
    if options.output:
        guessed.write(options.output)
        print(options.output, file=sys.stderr)


def run_example(options: argparse.Namespace) -> None:
    """Write a generated clip."""
    from npss_baselines.manifold import damaged, example
    from npss_baselines.manifold.show.side_by_side import Shown

    _check_outputs(options, [])
    walk = example()
    motion = damaged(walk) if options.damaged else walk
    print(f"{len(motion.rotations)} frames, {motion.fps:g} per second; {len(motion.skeleton.names)} joints, y up")
    name = "damaged walk" if options.damaged else "walk"
    _write(options, motion, {name: Shown(motion, joint_mapping.guess(motion.skeleton), "y")})


def _check_outputs(options: argparse.Namespace, inputs: Sequence[Path], *, clip: bool = True) -> None:
    """Check that all outputs can be written: a clip only if the command makes one."""
    kinds = ((_CLIP,) if clip else ()) + (_PAGE, *_PICTURES)
    for output in options.output:
        check_output(output, inputs)
        if output.suffix.lower() not in kinds:
            raise ValueError(f"{output}: expected a name that ends in {', '.join(kinds)}")


def _read(options: argparse.Namespace) -> Bvh:
    """Check the outputs of a restoration, and read its clip."""
    _check_outputs(options, [options.clip, *options.mapping, *filter(None, [options.truth, options.restorer])])
    return bvh.read(options.clip, missing=True)


def _times(options: argparse.Namespace, motion: Bvh) -> tuple[int, int | None]:
    """Return the frames of --from and --to."""
    start, end = (
        None if text is None else _frame(option, text, motion.fps)
        for option, text in (("--from", options.start), ("--to", options.end))
    )
    if start is not None and end is not None and 0 < end - start < 3 and not f"{options.start}{options.end}".count("s"):
        frames = "frame" if end - start == 1 else "frames"
        print(
            f"--from {start} --to {end}: {end - start} {frames}; write {start}s and {end}s for seconds", file=sys.stderr
        )
    return start or 0, end


def _frame(option: str, text: str, fps: float) -> int:
    """Return the frame of a time, or the number of frames of a duration."""
    if re.fullmatch(r"\d+", text):
        return int(text)
    if re.fullmatch(r"(\d+\.?\d*|\.\d+)s", text):
        # Frames from this time on; 2s of 30 frames per second is frame 60.
        return math.ceil(round(float(text[:-1]) * fps, 6))
    raise ValueError(f"{option}: expected seconds such as 2.5s, or a frame such as 75, got {text!r}")


def _mapping(motion: Bvh, file: Path | None = None) -> JointMapping:
    return joint_mapping.guess(motion.skeleton) if file is None else joint_mapping.read(file)


def _read_as(options: argparse.Namespace) -> dict[str, Any]:
    """Return the arguments of functions on a single clip."""
    if len(options.mapping) > 1:
        raise ValueError("--mapping: expected one file")
    return {"mapping": joint_mapping.read(options.mapping[0]) if options.mapping else None, "up": options.up}


def _restorer(options: argparse.Namespace) -> Any:
    from npss_baselines.manifold.restorers import file

    return file.default() if options.restorer is None else file.load(options.restorer)


def _manifold(run: Path | None) -> Manifold | None:
    if run is None:
        return None
    from npss_baselines.manifold.training.folder import load

    return load(run).projector


def _up(motion: Bvh, mapping: JointMapping) -> Any:
    from npss_baselines.data.upright import up_of

    return up_of(motion, mapping)


def _restored(options: argparse.Namespace, motion: Bvh, outcome: Outcome, *, searched: bool = False) -> None:
    """Say what was restored, and write it."""
    from npss_baselines.manifold.clips.comparison import restoration_error
    from npss_baselines.manifold.clips.finding import find, leaps
    from npss_baselines.manifold.clips.gap import Line, lines
    from npss_baselines.manifold.restorers.file import SHIPPED

    said = lines(outcome.gaps, motion)
    found = find(motion) if searched else []
    left_out = dict.fromkeys(gap.joint for gap in found if gap not in outcome.gaps)
    if left_out:
        print(f"found, but not chosen: {', '.join(left_out)}")
    if not said and searched and not left_out:
        how = "no damage found: the clip stays as it is (joints that leap and stay there are not looked for)"
    elif not said:
        how = "nothing to restore: the clip stays as it is"
    elif options.restorer is not None:
        how = f"restored by {options.restorer}"
    elif SHIPPED.exists():
        how = "restored by the restorer of the package"
    else:
        how = "interpolated in time, since no restorer is given and the package has none"
    _say(options, motion, outcome, how, said)
    if any(gap.why == "given" for gap in outcome.gaps):
        _say_turned(motion, outcome)
    if searched:
        for frame in leaps(motion, [*outcome.gaps, *found])[:3]:
            print(
                f"the figure leaps to frame {frame} ({frame / motion.fps:.2f} s) and stays; if N frames were deleted "
                f"there, give --insert N --at {frame}"
            )
    truth = None
    if options.truth is not None:
        truth = bvh.read(options.truth)
        if outcome.gaps:
            error = restoration_error(outcome.motion, truth, outcome)
            # What is restored may be right in the clip: it was only taken to be missing.
            before = f"; before, {_length(restoration_error(motion, truth, outcome))}" if searched else ""
            print(f"joints that were missing are {_length(error)} from the truth on average{before}")
    notes = [Line(f"restored by {outcome.way}")] if said else []
    _write(options, outcome.motion, _before_and_after(options, motion, outcome, truth), [*said, *notes])


def _say_turned(motion: Bvh, outcome: Outcome) -> None:
    """Print which joints turn so that others come to their places."""
    import numpy as np

    with np.errstate(invalid="ignore"):
        trace = np.einsum("tjab,tjab->tj", motion.rotations, outcome.motion.rotations)
    degrees = np.degrees(np.arccos(np.clip((trace - 1) / 2, -1, 1)))
    most = np.nanmax(np.where(np.isnan(degrees), 0, degrees), axis=0)
    turned = [f"{motion.skeleton.names[joint]} ({most[joint]:.0f})" for joint in np.flatnonzero(most > 0.5)]
    if 0 < len(turned) <= 8:
        print(f"joints that turn otherwise than before (by up to so many degrees): {', '.join(turned)}")


def _length(heights: float) -> str:
    """Say a length in body heights, and in centimetres."""
    return f"{heights:.4f} body heights ({100 * _HEIGHT * heights:.1f} cm at a height of {_HEIGHT:g} m)"


def _say(options: argparse.Namespace, motion: Bvh, outcome: Outcome, how: str, said: Sequence[Line] = ()) -> None:
    """Print what is known of a clip and of what was made of it."""
    print(
        f"{options.clip}: {len(motion.rotations)} frames, {motion.fps:g} per second; "
        f"{len(motion.skeleton.names)} joints, {outcome.up} up"
    )
    for line in said:
        print(f"missing: {line.text}")
    print(how)
    if outcome.error.any():
        mean, most = (100 * _HEIGHT * error for error in (outcome.error.mean(), outcome.error.max()))
        print(
            f"bones keep their lengths, so joints are {mean:.1f} cm from the places that were made for them on "
            f"average, {most:.1f} at most, at a height of {_HEIGHT:g} m; this says nothing about the truth"
        )
    if not options.output:
        print("nothing is written; give -o FILE", file=sys.stderr)


def _before_and_after(
    options: argparse.Namespace, motion: Bvh, outcome: Outcome, truth: Bvh | None = None
) -> dict[str, Shown]:
    from npss_baselines.manifold.show.side_by_side import Shown

    shown = {} if truth is None else {"truth": Shown(truth, outcome.mapping, outcome.up)}
    return shown | {
        "before": Shown(motion, outcome.mapping, outcome.up),
        "after": Shown(outcome.motion, outcome.mapping, outcome.up),
    }


def _write(
    options: argparse.Namespace,
    motion: Bvh | None,
    shown: dict[str, Shown],
    said: Sequence[Line] = (),
) -> None:
    """Write the outputs."""
    from npss_baselines.manifold.show import side_by_side

    notes = [line.text for line in said if line.start is None]
    spans = [(line.text, line.start, line.end) for line in said if line.start is not None and line.end is not None]

    clip: Path | None = getattr(options, "clip", None)
    title = " ".join(word for word in (options.parser.prog.split()[-1], clip.name if clip else "") if word)
    for output in options.output:
        suffix = output.suffix.lower()
        if suffix == _PAGE:
            truth = "truth" if "truth" in shown else None
            page = side_by_side.page(shown, title=title, notes=notes, spans=spans, truth=truth)
            write_text_atomically(output, page)
        elif suffix in _PICTURES:
            texts = [line.text for line in said]
            times = [(start, end) for _, start, end in spans]
            write_figure_atomically(output, side_by_side.picture(shown, title, *texts, spans=times))
        elif motion is not None:
            bvh_writer.write(output, motion)
        print(output, file=sys.stderr)
