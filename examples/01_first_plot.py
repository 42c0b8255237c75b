"""The first plot: all moments of a walk compared with all others, and with their mirror images.

Red: the same pose returns (Z). Cyan: its mirror image does (Z*). Walking shows red lines a period apart and cyan ones half a
period between them: left leg forward, right leg forward (§3.5.4).
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

motion = kx.performer.walk(seconds=6, fps=60).motion
sim = kx.similarity(kx.poses(motion))

ax = plotting.similarity_triangle(sim, motion, title="Walking")
plotting.save_figure(ax.figure, out / "01_first_plot.png")
