"""The figure's feet: they stand on the floor where those of the movement do, however the skeleton rests."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kinesics as kx
from kinesics.body import contacts, figure
from kinesics.body.anatomy import understood
from kinesics.body.figure_template import mannequin
from kinesics.geometry import quaternion
from kinesics.report.performances import save_performance
from naive import skinning

SIDES = ("left", "right")


def tilted(pitch: float, roll: float, toes: float) -> kx.Motion:
    """A walk of a body whose feet and toes rest turned by so many degrees, and move as ever."""
    motion = kx.performer.walk(seconds=3, fps=30).motion
    skeleton = motion.skeleton
    roles = understood(motion).skeleton.anatomy.roles
    turns = quaternion.identity((skeleton.joint_count,))
    for side, sign in (("left", 1.0), ("right", -1.0)):
        foot = quaternion.from_rotvec(np.radians([pitch, 0.0, sign * roll]))
        turns[getattr(roles, f"{side}_foot")] = foot
        turns[getattr(roles, f"{side}_toes")] = quaternion.multiply(
            foot, quaternion.from_rotvec(np.radians([toes, 0, 0]))
        )
    parents = list(skeleton.parents[1:])
    offsets, rotations = skeleton.offsets.copy(), motion.rotations.copy()
    # resting otherwise, seen from turned parents, is moving the other way round
    offsets[1:] = quaternion.rotate(turns[parents], offsets[1:])
    rotations[:, 1:] = quaternion.multiply(turns[parents], rotations[:, 1:])
    rotations = quaternion.multiply(rotations, quaternion.conjugate(turns))
    sites = tuple(
        dataclasses.replace(s, offset=tuple(quaternion.rotate(turns[s.parent], np.array(s.offset))))
        for s in skeleton.end_sites
    )
    out = motion.replace(skeleton=skeleton.replace(offsets=offsets, end_sites=sites, anatomy=None), rotations=rotations)
    np.testing.assert_allclose(out.positions(), motion.positions(), atol=1e-9)
    return understood(contacts.grounded(out))


def lowest(fitted: figure.Figure, motion: kx.Motion) -> np.ndarray:
    """Height of the lowest vertex of each foot, shape (frames, 2)."""
    template = mannequin()
    out = []
    for side in SIDES:
        rows = np.flatnonzero(template.bones[f"{side}_foot"] + template.bones[f"{side}_toes"] > 0.3)
        part = dataclasses.replace(
            fitted, vertices=fitted.vertices[rows], joints=fitted.joints[rows], weights=fitted.weights[rows]
        )
        out.append(part.posed(motion)[..., 1].min(axis=1))
    return np.stack(out, axis=1)


turned = st.tuples(st.floats(-25.0, 25.0), st.floats(-6.0, 6.0), st.floats(-20.0, 20.0))


@settings(max_examples=20, deadline=None)
@given(turned)
def test_feet_that_stand_flat_lie_on_the_floor(away: tuple[float, float, float]) -> None:
    """However they rest: within 6 mm of it while heel, ball and tip bear, in the median within 3 mm."""
    motion = tilted(*away)
    found = contacts.contacts(motion)
    flat = found.points.all(axis=2)
    assert flat.any(axis=0).all()
    height = lowest(figure.fit(motion.skeleton, soles=found.soles), motion)[flat]
    assert np.abs(height).max() < 0.006
    assert abs(np.median(height)) < 0.003


def test_feet_that_rest_tilted_sink_without_their_soles() -> None:
    """The movement is the same; 15° put the toes of a figure that knows nothing of it more than a centimetre into the floor."""
    motion = tilted(15.0, 0.0, 0.0)
    found = contacts.contacts(motion)
    flat = found.points.all(axis=2)
    assert np.median(lowest(figure.fit(motion.skeleton), motion)[flat]) < -0.01
    assert np.median(lowest(figure.fit(motion.skeleton, soles=found.soles), motion)[flat]) > -0.003


@settings(max_examples=10, deadline=None)
@given(turned)
def test_the_skin_of_the_feet_is_mirrored(away: tuple[float, float, float]) -> None:
    """The figure of the mirrored motion on its own soles is the mirror image, within a micrometre."""
    motion = tilted(*away)
    seen = kx.mirror(motion)
    first, second = (figure.fit(m.skeleton, soles=contacts.soles(m)) for m in (motion, seen))
    image = first.posed(motion)[:, first.partner] * [-1.0, 1.0, 1.0]
    assert np.abs(second.posed(seen) - image).max() < 1e-6


@pytest.mark.parametrize("away", [(0.0, 0.0, 0.0), (25.0, 6.0, -20.0), (-25.0, -6.0, 20.0)])
def test_feet_stay_feet(away) -> None:
    """However they rest: 22 to 29 cm long and 7 to 11 wide at 1.75 m, toes 1 to 4 cm thick, and no skin goes through other."""
    motion = tilted(*away)
    fitted = figure.fit(motion.skeleton, soles=contacts.soles(motion))
    template = mannequin()
    size = 1.75 / np.ptp(fitted.vertices[:, 1])
    foot = fitted.vertices[template.bones["left_foot"] + template.bones["left_toes"] > 0.5]
    assert 0.22 < np.ptp(foot[:, 2]) * size < 0.29
    assert 0.07 < np.ptp(foot[:, 0]) * size < 0.11
    end = foot[foot[:, 2] > foot[:, 2].max() - 0.02]
    assert 0.01 < np.ptp(end[:, 1]) * size < 0.04
    assert not skinning.crossings(fitted.vertices, fitted.triangles)


@pytest.mark.parametrize(
    ("name", "deepest", "share"),
    [("86_01", 0.015, 0.05), ("14_06", 0.03, 0.10), ("16_35", 0.007, 0.0), ("91_01", 0.009, 0.0)],
)
def test_performers_stand_on_the_floor(shared_data, name, deepest, share) -> None:
    """10 s of new movement: how deep the figure is in the floor at most, and how often deeper than 1 cm.

    In 14_06 a boxer turns on the ball of the right foot, which as recorded leans by up to 42°: an edge 4 cm from the middle
    of the sole is 2.5 cm below the floor then, for the movement stands on that middle.
    """
    motion = kx.read(shared_data / "cmu" / name.split("_")[0] / f"{name}.amc")
    piece = kx.performance(motion, seconds=10)
    seen = understood(piece.motion[::4])
    height = lowest(figure.fit(seen.skeleton, soles=piece.performance.soles), seen)
    assert height.min() > -deepest
    assert np.mean(height.min(axis=1) < -0.01) <= share
    borne = piece.performance.feet[::4]
    for k in range(2):
        assert abs(np.median(height[borne[:, k], k])) < 0.005


def test_a_saved_performance_stands_on_its_own_soles(tmp_path) -> None:
    """The .glb beside the provenance is the one written with the soles that the movement was made on."""
    piece = kx.performance(tilted(15.0, 0.0, 0.0), seconds=2)
    for name in ("saved", "given", "found"):
        (tmp_path / name).mkdir()
    save_performance(piece, tmp_path / "saved" / "a.glb")
    kx.formats.write(piece.motion, tmp_path / "given" / "a.glb", soles=piece.performance.soles)
    kx.formats.write(piece.motion, tmp_path / "found" / "a.glb")
    saved, given_, found = ((tmp_path / name / "a.glb").read_bytes() for name in ("saved", "given", "found"))
    assert saved == given_
    assert saved != found
