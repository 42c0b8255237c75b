"""The body: skeleton, motion, kinematics, any humanoid skeleton onto the 15 links ([Schultz2012] §2.6-2.16).

- `kinesics.body.skeleton`, `kinesics.body.motion`: what a file holds
- `kinesics.body.kinematics`: from joint rotations to positions
- `kinesics.body.anatomy`: which joint is which link, and in which frame
- `kinesics.body.pose`: the 15 quaternions, their mirror, the parts S and A
- `kinesics.body.quality`, `kinesics.body.limits`: what looks wrong in a recording, and what a body cannot do (C_free)
"""
