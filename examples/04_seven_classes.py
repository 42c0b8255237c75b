"""The seven classes of cyclic movement, each with its frieze group, as similarity plots (§3.4, completed).

Red and cyan lines parallel to the diagonal: the same, and mirrored. Lines across it: reversed in time.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting
from kinesics.vocabulary import FRIEZE_GROUPS

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

MOVEMENTS = ("limp", "walk", "butterfly", "wave", "arm_circles", "jog_in_place", "jumping_jacks")

figure = plotting.new_figure(14, 7.6)
for k, name in enumerate(MOVEMENTS):
    performance = getattr(kx.performer, name)(seconds=5, fps=30)
    class_ = performance.truth.class_
    sim = kx.similarity(kx.poses(performance.motion))
    ax = figure.add_axes((0.05 + 0.24 * (k % 4), 0.56 - 0.49 * (k // 4), 0.19, 0.35))
    plotting.similarity_plot(sim, title=f"{name}\n{class_} ({FRIEZE_GROUPS[class_]})", ax=ax)
plotting.save_figure(figure, out / "04_seven_classes.png")
