"""A skeleton whose joints have names that say nothing: understood by its shape, or by a mapping of yours.

The poses are the same, whatever the joints are called.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting
from kinesics.body import anatomy

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

motion = kx.performer.walk(seconds=4, fps=60).motion
bare_names = tuple(f"bone_{k:02d}" for k in range(motion.skeleton.joint_count))
bare = motion.replace(skeleton=motion.skeleton.replace(joint_names=bare_names, anatomy=None))

by_shape = anatomy.resolve(bare)
for role, joint in by_shape.roles.named(bare.skeleton).items():
    print(f"  {role:<16}{joint}")

roles = anatomy.resolve(motion).roles.named(motion.skeleton)
needed = [f"{side}_{part}" for side in ("left", "right") for part in ("femur", "tibia", "humerus", "radius")]
joints = {role: bare_names[motion.skeleton.find(roles[role])] for role in (*needed, "head")}
poses = kx.poses(bare, {"joints": joints})
print(f"greatest D from the poses by name: {kx.distance(poses, kx.poses(motion)).diagonal().max():.1e}")

ax = plotting.similarity_plot(kx.similarity(poses), title="bone_00 … walks")
plotting.save_figure(ax.figure, out / "07_a_skeleton_of_your_own.png")
