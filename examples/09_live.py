"""Live: a performer who is told where to go while it walks, one frame after the other.

The recordings are prepared once; any number of performers begin from that at once. Here the wish changes underway; in a game or an
installation it would come from whoever stands in front of it.
"""

import itertools
import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

straight = kx.performer.walk(seconds=10, fps=30).motion
circle = kx.performer.walk(seconds=16, fps=30, route="circle").motion

material = kx.prepare([straight, circle])  # once: what can be gone over into what, feet planted
avatar = kx.Avatar(material, target=(3.0, 3.0), seed=1)

frames = list(itertools.islice(avatar, 5 * 30))  # each has .rotations (joints, 4) and .root (3,), for avatar.skeleton
avatar.pursue(target=(-3.0, 5.0))  # from the next decision on
while not avatar.attained and len(frames) < 30 * 30:
    frames.append(next(avatar))
frames += itertools.islice(avatar, 15)  # it is decided a third of a second before the body is there
print("; ".join(avatar.outcome))

new = avatar.motion(frames)
kx.write(new, out / "09_live.bvh", overwrite=True)

# at once, of the same material: the same as kx.perform([straight, circle], …), without making it ready again
for seed in range(3):
    kx.write(kx.perform(material, target=(3.0, 3.0), seed=seed), out / f"09_take_{seed + 1}.bvh", overwrite=True)

ax = plotting.trail_plot(new, target=[(3.0, 3.0), (-3.0, 5.0)], title="Live: after five seconds it is sent elsewhere")
plotting.save_figure(ax.figure, out / "09_live.png")
