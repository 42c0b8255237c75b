"""Small motion files with everything in them that real ones have, made of numbers drawn at random, and how they are damaged."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

BVH_TREE = """HIERARCHY
ROOT Hips
{
\tOFFSET 0 0 0
\tCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
\tJOINT mixamorig:Spine
\t{
\t\tOFFSET 0 12.5 -1.25
\t\tCHANNELS 3 Xrotation Yrotation Zrotation
\t\tJOINT Left Arm
\t\t{
\t\t\tOFFSET 18 16 0
\t\t\tCHANNELS 6 Xposition Yposition Zposition Yrotation Zrotation Xrotation
\t\t\tJOINT LeftForeArm
\t\t\t{
\t\t\t\tOFFSET 28 0 0
\t\t\t\tCHANNELS 1 Yrotation
\t\t\t\tJOINT LeftThumb
\t\t\t\t{
\t\t\t\t\tOFFSET 24 1 3
\t\t\t\t\tCHANNELS 2 Zrotation Yrotation
\t\t\t\t\tEnd Site
\t\t\t\t\t{
\t\t\t\t\t\tOFFSET 2 0 2
\t\t\t\t\t}
\t\t\t\t\tEnd Site
\t\t\t\t\t{
\t\t\t\t\t\tOFFSET 3 0 1
\t\t\t\t\t}
\t\t\t\t}
\t\t\t}
\t\t}
\t\tJOINT Head
\t\t{
\t\t\tOFFSET 0 30 0
\t\t\tCHANNELS 4 Zrotation Yposition Yrotation Xrotation
\t\t\tEnd Site
\t\t\t{
\t\t\t\tOFFSET 0 20 0
\t\t\t}
\t\t}
\t}
\tJOINT LeftUpLeg
\t{
\t\tOFFSET 10 -4 0
\t\tCHANNELS 3 Zrotation Yrotation Xrotation
\t\tJOINT Skirt
\t\t{
\t\t\tOFFSET 0 -10 0
\t\t\tCHANNELS 0
\t\t}
\t\tJOINT LeftLeg
\t\t{
\t\t\tOFFSET 0 -42 0
\t\t\tCHANNELS 3 Zrotation Xrotation Yrotation
\t\t\tEnd Site
\t\t\t{
\t\t\t\tOFFSET 0 -41 0
\t\t\t}
\t\t}
\t}
}
"""
BVH_COLUMNS = 6 + 3 + 6 + 1 + 2 + 4 + 3 + 0 + 3
BVH_LINES_BEFORE_FRAMES = BVH_TREE.count("\n") + 3


def bvh(rng: np.random.Generator, frames: int = 5, *, frame_time: str = "0.01", tree: str = BVH_TREE) -> str:
    """A BVH with several orders of rotation, positions within rotations, hinges, two tips on one joint."""
    columns = sum(int(line.split()[1]) for line in tree.splitlines() if line.split()[:1] == ["CHANNELS"])
    values = rng.uniform(-180.0, 180.0, (frames, columns))
    rows = "".join(" ".join(f"{v:.6f}" for v in row) + "\n" for row in values)
    return f"{tree}MOTION\nFrames: {frames}\nFrame Time: {frame_time}\n{rows}"


ASF = """# made for a test
:version 1.10
:name tiny
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   lengths, and the like
   :
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 0 0
   orientation 0 0 0
:bonedata
  begin
     id 1
     name lhipjoint
     direction 0.6 -0.8 0
     length 2.5
     axis 0 0 0 XYZ
  end
  begin
     id 2
     name lfemur
     direction 0.34202 -0.939693 0
     length 7.1
     axis 10 -20 30 XYZ
     dof rx ry rz
     limits (-160.0 20.0)
            (-70.0 70.0)
            (-60.0 inf)
  end
  begin
     id 3
     name ltibia
     direction 0.34202 -0.939693 0
     length 7.5
     axis 5 6 20 ZXY
     dof rx
     limits (-10.0 170.0)
  end
  begin
     id 4
     name lfoot
     direction 0 0 1
     length 2.1
     axis -90 7.62852e-016 20 YXZ
     dof rz rx
  end
  begin
     id 5
     name lowerback
     direction 0 1 0
     length 2
     axis 0 0 0 XYZ
     dof tx tz ry rx rz
  end
:hierarchy
  begin
    root lhipjoint lowerback
    lhipjoint lfemur
    lfemur ltibia
    ltibia lfoot
  end
"""
AMC_BONES = {"root": 6, "lowerback": 5, "lfemur": 3, "ltibia": 1, "lfoot": 2}
AMC_LINES_BEFORE_FRAMES = 3


def amc(
    rng: np.random.Generator, frames: int = 5, *, header: str = "#!OML:ASF tiny\n:FULLY-SPECIFIED\n:DEGREES\n"
) -> str:
    """The movement of `ASF`."""
    scale = 180.0 if ":DEGREES" in header else np.pi
    lines = []
    for frame in range(1, frames + 1):
        lines.append(str(frame))
        lines += [
            " ".join([bone, *(f"{v:.6f}" for v in rng.uniform(-scale, scale, count))])
            for bone, count in AMC_BONES.items()
        ]
    return header + "\n".join(lines) + "\n"


@st.composite
def spoilt(draw: st.DrawFn, raw: bytes) -> bytes:
    """Bytes of a file cut off, or with three of them changed."""
    data = bytearray(raw)
    if draw(st.booleans()):
        del data[draw(st.integers(0, len(data) - 1)) :]
    else:
        for _ in range(3):
            data[draw(st.integers(0, len(data) - 1))] = draw(st.integers(0, 255))
    return bytes(data)
