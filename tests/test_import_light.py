"""`import kinesics` stays light: what it loads is a matter of milliseconds."""

from __future__ import annotations

import json
import subprocess
import sys

HEAVY = {"matplotlib", "cv2", "scipy", "networkx", "rich", "typer", "pooch", "pandas", "PIL"}


def loaded_by(statement: str) -> set[str]:
    """Top-level modules in a fresh interpreter after ``statement``."""
    code = f"import sys, json; {statement}; print(json.dumps(sorted({{m.partition('.')[0] for m in sys.modules}})))"
    paths = f"import sys; sys.path[:0] = {[p for p in sys.path if p]!r}; "
    out = subprocess.run([sys.executable, "-c", paths + code], capture_output=True, text=True, check=True)
    return set(json.loads(out.stdout))


def test_importing_kinesics_loads_nothing_heavy() -> None:
    """No matplotlib, no OpenCV, no SciPy, no networkx: each is loaded by the function that needs it."""
    loaded = loaded_by("import kinesics")
    assert "kinesics" in loaded
    assert not loaded & HEAVY


def test_looking_at_the_front_door_loads_nothing_heavy() -> None:
    """Listing the public names, as an editor does, loads no room."""
    assert not loaded_by("import kinesics; dir(kinesics)") & HEAVY


def test_geometry_and_body_are_light_too() -> None:
    """Reading rotations and skeletons needs NumPy alone."""
    rooms = "kinesics.geometry.euler, kinesics.geometry.twists, kinesics.body.motion, kinesics.body.pose"
    assert not loaded_by(f"import {rooms}") & HEAVY
