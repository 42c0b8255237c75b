"""Live: a performer who is told where to go while it walks, one frame after the other.

The controller decides for paths, a third of a second ahead; the renderer makes frames of them. Here the wish changes
underway; in a game or an installation it would come from whoever stands in front of it.
"""

import itertools
import sys
from pathlib import Path

import numpy as np

import kinesics as kx
from kinesics import plotting
from kinesics.synthesis.control.controller import Controller
from kinesics.synthesis.goals import Target
from kinesics.synthesis.live.renderer import LiveRenderer
from kinesics.synthesis.paths.network import network
from kinesics.synthesis.repertoire import repertoire

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

straight = kx.performer.walk(seconds=10, fps=30).motion
circle = kx.performer.walk(seconds=16, fps=30, route="circle").motion

net = network(repertoire([straight, circle]))  # once: what can be gone over into what
controller = Controller(net, Target((3.0, 3.0)), seed=1)
live = LiveRenderer(net, controller)

frames = list(itertools.islice(live, 5 * 30))
controller.pursue(Target((-3.0, 5.0)))  # from the next decision on
while not controller.attained and len(frames) < 30 * 30:
    frames.append(next(live))

new = kx.Motion(
    net.repertoire.skeleton, np.stack([f.rotations for f in frames]), np.stack([f.root for f in frames]), 30.0
)
print("; ".join(controller.outcome()))
kx.write(new, out / "09_live.bvh", overwrite=True)

ax = plotting.trail_plot(new, target=[(3.0, 3.0), (-3.0, 5.0)], title="Live: after five seconds it is sent elsewhere")
plotting.save_figure(ax.figure, out / "09_live.png")
