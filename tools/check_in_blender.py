"""Whether Blender shows a .glb or .bvh as kinesics reads it: every joint's place, and the figure's skin, at moments all over
the file.

    python tools/check_in_blender.py FILE --blender PYTHON

PYTHON is a Python that can ``import bpy``: Blender's own, or one with the package ``bpy`` installed.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

MOMENTS = 20
"""At which joints are compared."""
TOLERANCE = 1e-4
"""Metres."""
BVH_UNIT = 0.01
"""Metres: the .bvh files of kinesics are in centimetres."""


def compare(file: Path, known: Path) -> float:
    """In Blender: the greatest distance of a joint, or a vertex of the skin, from where it should be, metres."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    glb = file.suffix == ".glb"
    if glb:
        bpy.ops.import_scene.gltf(filepath=str(file))
    else:
        bpy.ops.import_anim.bvh(filepath=str(file), update_scene_fps=True, use_fps_scale=False)
    stored = np.load(known)
    names, fps, times = [str(n) for n in stored["names"]], float(stored["fps"]), stored["times"]
    armature = next(o for o in bpy.data.objects if o.type == "ARMATURE")
    meshes = [o for o in bpy.data.objects if any(m.type == "ARMATURE" for m in o.modifiers)]
    print(f"{bpy.app.version_string}: {len(armature.data.bones)} bones, {len(meshes)} skinned mesh(es)")
    scene = bpy.context.scene
    worst = 0.0
    skins = stored["skins"] if glb else np.zeros((len(times), 0, 3))
    for seconds, joints, skin in zip(times, stored["positions"], skins, strict=True):
        # a .glb begins at frame 0 and keeps its seconds; a .bvh has one of its frames in each of the scene's, from 1 on
        at = seconds * scene.render.fps if glb else seconds * fps + 1.0
        scene.frame_set(int(at + 1e-6), subframe=max(0.0, at - int(at + 1e-6)))
        bpy.context.view_layer.update()
        found = np.array([armature.matrix_world @ armature.pose.bones[n].head for n in names])
        worst = max(worst, float(np.abs(found * (1.0 if glb else BVH_UNIT) - in_blender(joints)).max()))
        if len(meshes) == 1 and len(skin):
            seen = meshes[0].evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            places = np.array([meshes[0].matrix_world @ v.co for v in seen.vertices])
            worst = max(worst, float(np.abs(places - in_blender(skin)).max()))
    return worst


def in_blender(places: np.ndarray) -> np.ndarray:
    """Blender's z is up, and its -y is ahead."""
    return places[:, [0, 2, 1]] * [1.0, -1.0, 1.0]


def main() -> int:
    """Read the file here, and again in Blender."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=Path)
    parser.add_argument("--blender", metavar="PYTHON", help="a Python that can import bpy")
    parser.add_argument("--known", type=Path, help=argparse.SUPPRESS)
    told = parser.parse_args()
    if told.known:
        worst = compare(told.file, told.known)
        print(f"worst place: {worst:.2e} m off")
        return int(worst > TOLERANCE)
    if not told.blender:
        parser.error("--blender PYTHON is wanted: a Python that can import bpy")

    import kinesics as kx
    from kinesics.body import figure

    motion = kx.read(told.file)
    frames = np.unique(np.linspace(0, motion.frame_count - 1, MOMENTS).round().astype(int))
    skins = np.zeros((len(frames), 0, 3))
    if motion.skeleton.anatomy is not None:
        body = figure.fit(motion.skeleton)
        skins = np.concatenate([body.posed(motion[int(f)]) for f in frames])
    with tempfile.TemporaryDirectory() as folder:
        known = Path(folder) / "known.npz"
        np.savez(
            known,
            positions=motion.positions()[frames],
            skins=skins,
            times=frames / motion.fps,
            fps=motion.fps,
            names=np.array(motion.skeleton.joint_names),
        )
        environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
        command = [told.blender, __file__, str(told.file.resolve()), "--known", str(known)]
        return subprocess.run(command, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
