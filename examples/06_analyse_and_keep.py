"""An analysis as an object and as a folder: what it knows, what it leaves on disk, and how it is read back."""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

motion = kx.performer.sun_salutation(fps=60).motion
analysis = kx.analyze(motion)
for stay in analysis.stillness:
    print(f"still from {stay.start / motion.fps:.2f} to {stay.end / motion.fps:.2f} s")

kx.save(analysis, out / "06_sun_salutation", overwrite=True)  # report.html, analysis.json, zz.png, …
again = kx.load(out / "06_sun_salutation")
assert again == analysis

ax = plotting.speed_plot(
    again.speed_curves[0], motion.fps, stillness=[(s.start, s.end) for s in again.stillness], title="Sun salutation"
)
plotting.save_figure(ax.figure, out / "06_analyse_and_keep.png")
