"""What a performer has to perform with ([Schultz2012] §4.4).

- how frames can be played, and what they are then called: `strands`
- all recordings on one skeleton and at one rate, with their mirror images: `Repertoire` (stock.py)
- made by `repertoire` (gathering.py), which mends what the capture got wrong for some frames (`kinesics.body.mending`), asks
  whether the frame rates will do (rates.py), brings recordings onto the body to perform on (bodies.py), and tells where limbs
  pass through each other there (depths.py)
"""

from kinesics.synthesis.repertoire.bodies import ROOT_PUT
from kinesics.synthesis.repertoire.gathering import LEAST_SECONDS, THROWN, repertoire
from kinesics.synthesis.repertoire.rates import LEAST_FPS, MOST_FPS, check_rate
from kinesics.synthesis.repertoire.stock import Repertoire
from kinesics.synthesis.repertoire.strands import BACKWARD_STRANDS, MIRRORED_STRANDS, STRANDS, FrameStrand

__all__ = [
    "BACKWARD_STRANDS",
    "LEAST_FPS",
    "LEAST_SECONDS",
    "MIRRORED_STRANDS",
    "MOST_FPS",
    "ROOT_PUT",
    "STRANDS",
    "THROWN",
    "FrameStrand",
    "Repertoire",
    "check_rate",
    "repertoire",
]
