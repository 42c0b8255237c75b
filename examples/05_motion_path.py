"""The motion path: the same walk, even and limping, in the symmetric and the antisymmetric subspace (§3.2, Figure 9).

A walk's antisymmetric path is its own mirror image; a limp's is not.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

figure = plotting.new_figure(9.6, 9.6)
for row, name in enumerate(("walk", "limp")):
    poses = kx.poses(getattr(kx.performer, name)(seconds=5, fps=60).motion)
    bottom = 0.56 - 0.49 * row
    left, right = figure.add_axes((0.1, bottom, 0.37, 0.37)), figure.add_axes((0.6, bottom, 0.37, 0.37))
    plotting.subspace_plot(poses, axes=(left, right))
    left.set_title(f"{name}: {left.get_title()}".rstrip(": "))
plotting.save_figure(figure, out / "05_motion_path.png")
