"""The same body frame by frame, as the paths are chosen: `renderer.LiveRenderer`.

`foresight` knows beforehand how recordings go on; `poses`, `cuts`, `blends` put the body together; `treading` and `leg` its feet.
"""
