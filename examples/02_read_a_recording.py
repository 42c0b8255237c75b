"""A file in, what it says and what it does not, and what the body looks like.

Give your own as the second argument: python examples/02_read_a_recording.py out walk.bvh
"""

import sys
from pathlib import Path

import numpy as np

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

if len(sys.argv) > 2:
    recording = Path(sys.argv[2])
else:
    recording = out / "jumping_jacks.bvh"
    kx.write(kx.performer.jumping_jacks(seconds=4, fps=60).motion, recording, overwrite=True)

motion = kx.read(recording)
print(f"{motion.name}: {motion.frame_count} frames at {motion.fps:g} fps, {motion.skeleton.joint_count} joints")
for line in motion.assumptions:
    print("  assumed:", line)
for line in motion.warnings:
    print("  looks wrong:", line)

ax = plotting.stick_figure_row(
    motion, np.linspace(0, min(motion.frame_count - 1, 2 * motion.fps), 12, dtype=int), view="front"
)
plotting.save_figure(ax.figure, out / "02_read_a_recording.png")
