"""A goal of your own: whatever can be measured in a motion, near to what is wished for. Here, hands first high and then low.

The function is asked once for each recording, and for its mirror image; `goals.Measured` does the rest.
"""

import sys
from pathlib import Path

import kinesics as kx
from kinesics import plotting
from kinesics.synthesis import goals

out = Path(sys.argv[1] if len(sys.argv) > 1 else "out")
out.mkdir(parents=True, exist_ok=True)

kata = kx.performer.kata(fps=30).motion


def hands(motion):
    """How high the hands are, metres: a number for every frame."""
    left, right = motion.skeleton.find("LeftHand"), motion.skeleton.find("RightHand")
    return motion.positions()[:, [left, right], 1].mean(axis=1)


def wish(now):
    """What is wished for at that time; a plain number would do where it stays the same."""
    return 1.8 if now.time < 10.0 else 0.8


new = kx.perform(kata, goal=goals.Measured(hands, wish), seconds=20, seed=1)
first, then = hands(new[:300]).mean(), hands(new[300:]).mean()
print(f"hands {first:.2f} m high at first, {then:.2f} m afterwards; {hands(kata).mean():.2f} m in the recording")

figure = plotting.new_figure(8.0, 3.5)
ax = figure.add_axes((0.1, 0.16, 0.87, 0.8))
ax.plot([k / new.fps for k in range(new.frame_count)], hands(new), label="performed")
ax.step([0.0, 10.0, 20.0], [1.8, 0.8, 0.8], where="post", color="0.6", linestyle="--", label="wished for")
ax.set_xlabel("time (s)")
ax.set_ylabel("height of the hands (m)")
ax.legend(frameon=False)
plotting.save_figure(figure, out / "10_a_goal_of_your_own.png")
