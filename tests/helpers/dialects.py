"""Skeletons in the dialects of several programs, all in the same pose, and motion on them."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from npss.skeleton import Skeleton
from npss_baselines.data import mapping
from npss_baselines.data.bvh import CHANNELS, Bvh
from npss_baselines.data.motion import JOINTS, NAMES
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.motion.bones import normalise_lengths
from npss_baselines.manifold.motion.onto_skeleton import onto_skeleton

#: For each dialect, chains of joints from the root on. A common joint is followed by ``=`` and its common name.
CHAINS = {
    "mixamo": """
        mixamorig:Hips=Hips mixamorig:Spine mixamorig:Spine1=Spine1 mixamorig:Spine2 mixamorig:Neck=Neck \
            mixamorig:Head=Head mixamorig:HeadTop_End
        mixamorig:Spine2 mixamorig:{S}Shoulder mixamorig:{S}Arm={S}Arm mixamorig:{S}ForeArm={S}ForeArm \
            mixamorig:{S}Hand={S}Hand mixamorig:{S}HandIndex1={S}HandIndex mixamorig:{S}HandIndex2
        mixamorig:{S}Hand mixamorig:{S}HandThumb1 mixamorig:{S}HandThumb2
        mixamorig:Hips mixamorig:{S}UpLeg={S}UpLeg mixamorig:{S}Leg={S}Leg mixamorig:{S}Foot={S}Foot \
            mixamorig:{S}ToeBase={S}ToeBase mixamorig:{S}Toe_End
    """,
    "lafan1": """
        Hips=Hips Spine Spine1=Spine1 Spine2 Neck=Neck Head=Head
        Spine2 {S}Shoulder {S}Arm={S}Arm {S}ForeArm={S}ForeArm {S}Hand={S}Hand
        Hips {S}UpLeg={S}UpLeg {S}Leg={S}Leg {S}Foot={S}Foot {S}Toe={S}ToeBase
    """,
    "bandai": """
        joint_Root Hips=Hips Spine=Spine1 Chest Neck=Neck Head=Head
        Chest Shoulder_{s} UpperArm_{s}={S}Arm LowerArm_{s}={S}ForeArm Hand_{s}={S}Hand
        Hips UpperLeg_{s}={S}UpLeg LowerLeg_{s}={S}Leg Foot_{s}={S}Foot Toes_{s}={S}ToeBase
    """,
    "xsens": """
        Hips=Hips Chest Chest2=Spine1 Chest3 Chest4 Neck=Neck Head=Head
        Chest4 {S}Collar {S}Shoulder={S}Arm {S}Elbow={S}ForeArm {S}Wrist={S}Hand
        Hips {S}Hip={S}UpLeg {S}Knee={S}Leg {S}Ankle={S}Foot {S}Toe={S}ToeBase
    """,
    "rokoko": """
        Hips=Hips Spine Spine1=Spine1 Spine2 Spine3 Neck=Neck Head=Head HeadEnd
        Spine3 {S}Shoulder {S}Arm={S}Arm {S}ForeArm={S}ForeArm {S}ForeArmTwist {S}Hand={S}Hand \
            {S}HandMiddle1={S}HandIndex
        Hips {S}Thigh={S}UpLeg {S}Shin={S}Leg {S}Foot={S}Foot {S}Toe={S}ToeBase {S}ToeEnd
    """,
    "cmu": """
        Hips=Hips LowerBack Spine=Spine1 Spine1 Neck=Neck Neck1 Head=Head
        Spine1 {S}Shoulder {S}Arm={S}Arm {S}ForeArm={S}ForeArm {S}Hand={S}Hand {S}FingerBase={S}HandIndex \
            {S}HandIndex1
        Hips {s}HipJoint {S}UpLeg={S}UpLeg {S}Leg={S}Leg {S}Foot={S}Foot {S}ToeBase={S}ToeBase
    """,
}


def dialect(name):
    """Return a skeleton, and the names of its joints by those of the common ones."""
    rest = dict(zip(NAMES, JOINTS.positions(np.tile(np.eye(3), (len(NAMES), 1, 1))), strict=True))
    parents, places, common = {}, {}, {}
    lines = CHAINS[name].split("\n")
    sided = [
        line.format(S=side, s=side[0]) for line in lines for side in (("Left", "Right") if "{" in line else ("-",))
    ]
    for chain in sided:
        words = [word.partition("=")[::2] for word in chain.split()]
        for place, (joint, meaning) in enumerate(words):
            if meaning:
                common[meaning] = joint
            if joint in parents:
                continue
            parents[joint] = words[place - 1][0] if place else None
            known = [i for i, (other, of) in enumerate(words) if of or other in places]
            before = max((i for i in known if i < place), default=None)
            after = min((i for i in known if i > place), default=None)

            def at(i, words=words):
                other, of = words[i]
                return places[other] if other in places else rest[of]

            if meaning:
                places[joint] = rest[meaning]
            elif before is None:
                places[joint] = at(after) * [1, 0, 1]  # a root on the ground
            elif after is None:
                places[joint] = at(before) + [0, 0.05, 0.01]
            else:
                share = (place - before) / (after - before)
                places[joint] = (1 - share) * at(before) + share * at(after)
    names = list(parents)
    tree = [-1 if parents[joint] is None else names.index(parents[joint]) for joint in names]
    offsets = [places[joint] - (places[parents[joint]] if parents[joint] else 0) for joint in names]
    return Skeleton(names, tree, offsets), {meaning: common.get(meaning) for meaning in NAMES}


def swaying(name, fps=60.0, seconds=2.0, size=100.0):
    """Return smooth motion on the skeleton of a dialect, in centimetres, that turns and goes ahead."""
    skeleton, _ = dialect(name)
    rng = np.random.default_rng(0)
    t = np.arange(round(seconds * fps)) / fps
    n = len(skeleton.names)
    phase, axes = rng.uniform(0, 6, n), rng.normal(size=(n, 3))
    turns = 0.15 * np.sin(2 * np.pi * 0.8 * t[:, np.newaxis] + phase)[..., np.newaxis] * axes
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(len(t), n, 3, 3)
    root = skeleton.parents.index(-1)
    rotations[:, root] = Rotation.from_rotvec(np.outer(0.8 + 0.3 * t, [0, 1, 0])).as_matrix()
    offsets = skeleton.offsets * size
    translations = np.tile(offsets, (len(t), 1, 1))
    translations[:, root, 2] += 90 * t
    scaled = type(skeleton)(skeleton.names, skeleton.parents, offsets)
    return Bvh(scaled, tuple(("Zrotation", "Xrotation", "Yrotation") for _ in range(n)), rotations, translations, fps)


def resting(name, n_frames, fps=30.0, size=100.0):
    """Return the rest pose on the skeleton of a dialect as a clip, in centimetres."""
    skeleton, _ = dialect(name)
    scaled = Skeleton(skeleton.names, skeleton.parents, skeleton.offsets * size)
    turns = ("Zrotation", "Xrotation", "Yrotation")
    channels = [turns if parent >= 0 else (*CHANNELS[:3], *turns) for parent in skeleton.parents]
    rotations = np.tile(np.eye(3), (n_frames, len(channels), 1, 1))
    return Bvh(scaled, tuple(channels), rotations, np.tile(scaled.offsets, (n_frames, 1, 1)), fps)


def walking(name, n_frames=120, fps=30.0, size=100.0, seed=0):
    """Return a generated walk on the skeleton of a dialect, in centimetres."""
    rest = resting(name, n_frames, fps, size)
    (clip,) = synthetic_clips(1, n_frames, seed=seed, fps=fps)
    places = size * normalise_lengths(clip.positions, JOINTS)
    joints = mapping.guess(rest.skeleton)
    return onto_skeleton(places, rest, joints).motion


def with_z_up(motion):
    """Return a clip turned so that z is up."""
    turn = Rotation.from_rotvec([np.pi / 2, 0, 0]).as_matrix()
    root = motion.skeleton.parents.index(-1)
    rotations, translations = motion.rotations.copy(), motion.translations.copy()
    rotations[:, root] = turn @ rotations[:, root]
    translations[:, root] = translations[:, root] @ turn.T
    return replace(motion, rotations=rotations, translations=translations)
