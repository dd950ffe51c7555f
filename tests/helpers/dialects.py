"""Skeletons in the dialects of several programs, all in the same pose."""

import numpy as np

from npss.skeleton import Skeleton
from npss_baselines.data.motion import JOINTS, NAMES

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
