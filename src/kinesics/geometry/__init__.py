"""Rotations, rigid motions and twists ([Schultz2012] §2.1-2.4).

- `kinesics.geometry.quaternion`: unit quaternions, scalar first; matrices, rotation vectors, Euler pole and angle
- `kinesics.geometry.euler`: Euler angles in every order, Fick angles among them
- `kinesics.geometry.rigid`: SE(3): composition, inverse, adjoint, exponential and logarithm
- `kinesics.geometry.twists`: body- and space-frame velocities of a sampled motion
"""
