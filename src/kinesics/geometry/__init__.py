"""Rotations, rigid motions and twists ([Schultz2012] §2.1-2.4).

- `kinesics.geometry.quaternion`: unit quaternions, scalar first.
"""
