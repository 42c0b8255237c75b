"""New movement from two walks: to a place, with its trail on the floor, and where every frame comes from.

Whoever has walked only to the left can walk to the right, too: mirror images are performed as well.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

straight = kx.performer.walk(seconds=10, fps=30).motion
to_the_left = kx.performer.walk(seconds=16, fps=30, route="circle").motion
target = (-3.0, 2.0)  # x, z in metres: to the right and ahead

piece = kx.performance([straight, to_the_left], target=target, seed=2)  # kx.perform gives piece.motion alone
print("; ".join(piece.outcome))
print(f"{piece.mirrored_share:.0%} mirrored, {len(piece.crossings)} transitions, nearest {piece.nearest:.2f} m")
for span in piece.spans[:5]:
    source, image = piece.sources[span.source].name, " mirrored" if span.mirrored else ""
    print(f"frames {span.start}-{span.end}: {source} {span.source_start:.0f}-{span.source_end:.0f}{image}")
kx.write(piece.motion, out / "08_perform.bvh", overwrite=True)

ax = plotting.trail_plot(piece.motion, target=target, title="New movement from a straight walk and a circle")
plotting.save_figure(ax.figure, out / "08_perform.png")
