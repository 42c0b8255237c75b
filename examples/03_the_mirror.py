"""The mirror: how far a body is from its own mirror image, D*(a, a), moment by moment (§2.14).

A body that swims the butterfly stroke is symmetric throughout. Arms that circle against each other pass two symmetric poses
a cycle, hanging and overhead. A body that walks never is symmetric, and least so when the feet are farthest apart.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting
from kinesics.similarity import symmetry_residual

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

figure = plotting.new_figure(8, 7)
for row, name in enumerate(("butterfly", "arm_circles", "walk")):
    motion = getattr(kx.performer, name)(seconds=5, fps=60).motion
    asymmetry = symmetry_residual(kx.poses(motion))
    print(f"{name}: D*(a, a) is at most {asymmetry.max():.4f}")
    ax = figure.add_axes((0.1, 0.72 - 0.32 * row, 0.86, 0.22))
    plotting.symmetry_plot(asymmetry, motion.fps, title=name, ax=ax)
    ax.set_ylim(0, max(0.02, 1.1 * asymmetry.max()))
plotting.save_figure(figure, out / "03_the_mirror.png")
