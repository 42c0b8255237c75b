"""The plots: what is drawn where, on whose axes, and the same bytes every time."""

from __future__ import annotations

import io
import itertools
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from PIL import Image

import bodies
import kinesics as kx
from kinesics import plotting
from kinesics.errors import InputError
from kinesics.plotting.canvas import figure_bytes, show_pixels


def _image(ax: Axes) -> np.ndarray:
    (image,) = (child for child in ax.get_children() if isinstance(child, AxesImage))
    values = image.get_array()
    assert values is not None
    return np.asarray(values)


def _checkered() -> tuple[np.ndarray, np.ndarray]:
    """Z on the diagonal blocks, Z* off them, both in the last frame with itself."""
    z, z_mirror = np.zeros((4, 4)), np.zeros((4, 4))
    z[:2, :2] = z[2:, 2:] = 1.0
    z_mirror[:2, 2:] = z_mirror[2:, :2] = 1.0
    z_mirror[3, 3] = 1.0
    return z, z_mirror


def test_the_square_shows_time_running_right_and_up() -> None:
    """Column is i, row is j counted from below; red, cyan and white stand where Z, Z* and both are."""
    ax = plotting.similarity_plot(_checkered())
    image = _image(ax)
    assert tuple(image[0, 0]) == (255, 0, 0)
    assert tuple(image[0, 3]) == (0, 255, 255)
    assert tuple(image[3, 3]) == (255, 255, 255)
    (child,) = ax.images
    assert child.origin == "lower"
    assert ax.get_xlim() == (0.0, 4.0)


@pytest.mark.parametrize(("kind", "colour"), [("z", (255, 0, 0)), ("z_mirror", (0, 0, 0)), ("both", (255, 0, 0))])
def test_one_matrix_can_be_shown_alone(kind: str, colour: tuple[int, int, int]) -> None:
    """Only the layer asked for is lit."""
    assert tuple(_image(plotting.similarity_plot(_checkered(), kind=kind))[0, 0]) == colour


def test_the_triangle_lays_the_identity_axis_along_time() -> None:
    """The lowest row is the diagonal, the tip compares the last frame with the first, the corners above are paper."""
    image = _image(plotting.similarity_triangle(_checkered()))
    assert (image[0, : len(image[0]) // 3] == (255, 0, 0)).all()
    assert tuple(image[-1, image.shape[1] // 2]) == (0, 255, 255)
    assert (image[-1, 0] == 255).all()
    assert (image[-1, -1] == 255).all()


def test_axes_are_in_seconds_where_the_rate_is_known() -> None:
    """Else they count frames and say so; β is in the title."""
    sim = kx.similarity(kx.poses(bodies.arms_swinging(120, fps=60.0)))
    for ax in (plotting.similarity_plot(sim), plotting.similarity_triangle(sim)):
        assert ax.get_xlim() == (0.0, 2.0)
        assert "(s)" in ax.get_xlabel()
        assert f"β = {sim.beta:.3g}" in ax.get_title()
    assert "frames" in plotting.similarity_plot((sim.z, sim.z_mirror)).get_xlabel()


def test_a_symmetric_movement_has_no_colour_and_a_one_sided_one_has() -> None:
    """Both arms alike: Z = Z*, grey throughout (§3.5.1). The left arm alone: a red identity axis (§3.4.4)."""
    both = _image(plotting.similarity_plot(kx.similarity(kx.poses(bodies.arms_swinging()))))
    # Z* is computed from mirrored poses: float32 rounding may move a grey by one step
    assert np.abs(both[..., 0].astype(int) - both[..., 1].astype(int)).max() <= 1
    one = kx.similarity(kx.poses(bodies.arms_swinging(mirrored=False)))
    image = _image(plotting.similarity_plot(one))
    on_axis = image[np.arange(len(image)), np.arange(len(image))]
    assert (on_axis[:, 0] == 255).all()
    assert on_axis[:, 1].min() < 128


@pytest.mark.parametrize("frames", [1, 2, 3])
def test_very_short_recordings_can_be_drawn(frames: int) -> None:
    """One frame, two frames: every picture is there."""
    motion = bodies.arms_swinging(frames)
    poses = kx.poses(motion)
    sim = kx.similarity(poses)
    drawn = [
        plotting.similarity_plot(sim),
        plotting.similarity_triangle(sim, motion),
        plotting.stick_figure(motion, 0),
        plotting.stick_figure_row(motion, [0]),
        plotting.speed_plot(np.zeros(frames), motion.fps),
        plotting.symmetry_plot(np.zeros(frames), motion.fps),
        plotting.composite_plot(poses),
        *plotting.subspace_plot(poses),
    ]
    for ax in drawn:
        assert isinstance(ax, Axes)
        assert figure_bytes(ax.figure, ".png").startswith(b"\x89PNG")


def test_given_axes_are_used_and_pyplot_hears_nothing() -> None:
    """Functions draw on the axes they are given; no figure of pyplot's is made or left open."""
    import matplotlib.pyplot as plt

    before = plt.get_fignums()
    motion = bodies.legs_striding(60)
    poses = kx.poses(motion)
    sim = kx.similarity(poses)
    draw: list[Callable[[Axes], Axes]] = [
        lambda ax: plotting.similarity_plot(sim, ax=ax),
        lambda ax: plotting.similarity_triangle(sim, motion, ax=ax),
        lambda ax: plotting.stick_figure(motion, 3, ax=ax),
        lambda ax: plotting.stick_figure_row(motion, [3, 9], overlap_frames=4, trail=3, ax=ax),
        lambda ax: plotting.speed_plot(np.ones(60), 60.0, stillness=[(3, 9)], ax=ax),
        lambda ax: plotting.symmetry_plot(np.ones(60), 60.0, threshold=0.5, symmetric=[(3, 9)], ax=ax),
        lambda ax: plotting.composite_plot(poses, symmetric=[(3, 9)], ax=ax),
    ]
    for one in draw:
        ax = plotting.new_figure(4, 4).add_subplot()
        assert one(ax) is ax
    assert plt.get_fignums() == before


def test_a_long_recording_is_pooled_to_the_pixels_of_the_axes() -> None:
    """The image drawn is as large as the axes, so that nothing later can drop a row."""
    ax = plotting.new_figure(2, 2, dpi=100).add_axes((0.0, 0.0, 1.0, 1.0))
    z = np.zeros((1000, 1000))
    z[137, 641] = z[641, 137] = 1.0
    image = _image(plotting.similarity_plot((z, np.zeros_like(z)), ax=ax))
    assert image.shape[:2] == (200, 200)
    assert (image[..., 0] == 255).sum() == 2


@pytest.mark.parametrize("pixels", [(200, 200), (200, 150), (67, 33), (197, 203)])
def test_the_pixels_of_a_plot_are_on_paper_as_they_are(pixels: tuple[int, int]) -> None:
    """Where the axes have as many pixels, each is one of the file, where more, several; matplotlib agrees, and does the rest."""
    rng = np.random.default_rng(5)
    values = rng.integers(0, 256, (pixels[1], pixels[0], 3), dtype=np.uint8)
    pages = []
    for own in (True, False):
        figure = plotting.new_figure(3, 3, dpi=100)
        ax = figure.add_axes((0.1, 0.1, 2 / 3, 2 / 3))
        ax.set_axis_off()
        if own:
            show_pixels(ax, values, (2.0, 3.0), aspect=2 / 3)
        else:
            ax.imshow(values, origin="lower", extent=(0, 2, 0, 3), interpolation="nearest", aspect=2 / 3)
        pages.append(np.asarray(Image.open(io.BytesIO(figure_bytes(figure, ".png")))))
    np.testing.assert_array_equal(*pages)
    if pixels == (200, 200):
        np.testing.assert_array_equal(pages[0][70:270, 30:230], values[::-1])


def test_what_is_see_through_stays_so() -> None:
    """A figure without paper has an alpha channel; one of ours has none, and is a third smaller for it."""
    figure = plotting.new_figure(1, 1)
    assert Image.open(io.BytesIO(figure_bytes(figure, ".png"))).mode == "RGB"
    figure.set_facecolor("none")
    assert Image.open(io.BytesIO(figure_bytes(figure, ".png"))).getpixel((3, 3)) == (255, 255, 255, 0)


def test_long_curves_keep_their_peaks() -> None:
    """One fast frame among 100,000 is drawn at its full height."""
    speed = np.full(100_000, 0.1)
    speed[77_777] = 9.0
    ax = plotting.speed_plot(speed, 120.0)
    top = max(path.get_extents().y1 for c in ax.collections for path in c.get_paths())
    assert top == pytest.approx(9.0)


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_files_are_the_same_bytes_on_every_run(suffix: str) -> None:
    """No date, no version, no random ids."""
    motion = bodies.legs_striding(50)

    def make() -> bytes:
        ax = plotting.similarity_triangle(kx.similarity(kx.poses(motion)), motion)
        return figure_bytes(ax.figure, suffix)

    first = make()
    assert first == make()
    assert b"matplotlib" not in first.lower().replace(b"matplotlib.org", b"") or suffix == ".svg"


def test_saving_chooses_by_suffix_and_leaves_no_part_behind(tmp_path: Path) -> None:
    """PNG and SVG; another suffix is refused, and nothing is left."""
    figure = plotting.speed_plot(np.ones(4), 4.0).figure
    plotting.save_figure(figure, tmp_path / "a.PNG")
    plotting.save_figure(figure, tmp_path / "a.svg")
    with pytest.raises(InputError, match="svg"):
        plotting.save_figure(figure, tmp_path / "a.bmp")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.PNG", "a.svg"]
    assert (tmp_path / "a.PNG").read_bytes()[1:4] == b"PNG"


def test_the_mirrored_path_is_reflected_in_the_symmetry_axis() -> None:
    """W negates Â and keeps Ŝ (§2.11); a symmetric movement stays on the axis."""
    poses = kx.poses(bodies.legs_striding(90))
    place, image = plotting.symmetry_coordinates(poses), plotting.symmetry_coordinates(poses.mirror())
    np.testing.assert_allclose(np.abs(image.antisymmetric), np.abs(place.antisymmetric), atol=1e-9)
    np.testing.assert_allclose(image.symmetric, place.symmetric, atol=1e-9)
    still = plotting.symmetry_coordinates(kx.poses(bodies.arms_swinging(90)))
    np.testing.assert_allclose(still.antisymmetric, 0.0, atol=1e-9)
    assert np.ptp(still.symmetric[:, 0]) > 0.1


def test_coordinates_do_not_depend_on_the_signs_of_quaternions(rng: np.random.Generator) -> None:
    """q and −q are one rotation: the path is drawn in the same place."""
    import dataclasses

    poses = kx.poses(bodies.legs_striding(90))
    signs = rng.choice([-1.0, 1.0], size=(len(poses), 15, 1))
    flipped = dataclasses.replace(poses, quaternions=poses.quaternions * signs)
    a, b = plotting.symmetry_coordinates(poses), plotting.symmetry_coordinates(flipped)
    np.testing.assert_allclose(a.symmetric, b.symmetric, atol=1e-9)
    np.testing.assert_allclose(a.antisymmetric, b.antisymmetric, atol=1e-9)


def test_a_node_on_the_floor_that_stays_behind_is_no_bone() -> None:
    """A rig may hang the pelvis on a node that the body walks away from, and on it a prop too: neither is drawn."""
    from kinesics.body.skeleton import EndSite
    from kinesics.geometry import quaternion
    from kinesics.plotting.stick_figures import compute_strokes

    motion = bodies.legs_striding(20)
    bare = motion.skeleton
    skeleton = bare.replace(
        joint_names=("Floor", *bare.joint_names, "Prop"),
        parents=(-1, *(p + 1 for p in bare.parents), 0),
        offsets=np.concatenate([np.zeros((1, 3)), bare.offsets, np.ones((1, 3))]),
        freedoms=(),
        end_sites=tuple(EndSite(e.parent + 1, e.offset) for e in bare.end_sites),
    )
    walk = np.zeros((20, skeleton.joint_count, 3))
    walk[:] = skeleton.offsets
    walk[:, 1] = motion.root_positions + np.linspace(0.0, 9.0, 20)[:, None] * np.array([0.0, 0.0, 1.0])
    rigged = motion.replace(
        skeleton=skeleton,
        rotations=np.concatenate(
            [quaternion.identity((20, 1)), motion.rotations, quaternion.identity((20, 1))], axis=1
        ),
        root_positions=np.zeros((20, 3)),
        joint_translations=walk,
    )
    a, b = compute_strokes(motion, [3, 19]), compute_strokes(rigged, [3, 19])
    assert a.segments.shape == b.segments.shape
    np.testing.assert_allclose(a.segments, b.segments, atol=1e-9)


def test_strokes_of_many_moments_are_those_of_each() -> None:
    """Whatever their order, and whichever motion they are of."""
    from kinesics.plotting.stick_figures import compute_strokes, strokes_of

    one, two = bodies.legs_striding(20), bodies.arms_swinging(9)
    parts = [(one, [3, 7]), (two, [8]), (one, [0]), (one, [3]), (two, [1, 2, 0])]
    for (motion, frames), found in zip(parts, strokes_of(parts, view="front"), strict=True):
        expected = compute_strokes(motion, frames, view="front")
        np.testing.assert_allclose(found.segments, expected.segments, atol=1e-12)
        np.testing.assert_allclose(found.head_centres, expected.head_centres, atol=1e-12)
        assert found[1:3] == expected[1:3]
        assert found.limbs == expected.limbs


def test_grey_figures_are_drawn_as_coloured_ones_are() -> None:
    """In one ink the limbs of a figure are one line, of two widths where it has fingers; the same paper is covered."""
    from kinesics.plotting.stick_figures import Placed, compute_strokes, draw_figures

    strokes = compute_strokes(bodies.legs_striding(20), [3])
    covered = []
    for grey in (False, True):
        ax = plotting.new_figure(2, 3, dpi=100).add_axes((0.0, 0.0, 1.0, 1.0), xlim=(-1, 1), ylim=(-0.5, 2.5))
        ax.set_axis_off()
        draw_figures(ax, [Placed(strokes, 0, (0.0, 0.0), (1.0, 1.0), 3.0, grey=grey)])
        paper = np.asarray(Image.open(io.BytesIO(figure_bytes(ax.figure, ".png"))))
        covered.append((paper < 128).any(axis=-1))
        lines, heads = ax.collections
        assert len(lines.get_paths()) == (len(set(strokes.widths)) if grey else len(strokes.limbs))
        assert len(heads.get_paths()) == 1
    assert covered[0].sum() > 500
    assert (covered[0] != covered[1]).mean() < 0.001


def test_what_has_no_length_is_no_stroke() -> None:
    """Converters put hip joints and joints of the neck where their parents are: no dot is drawn for them."""
    from kinesics.body.skeleton import EndSite
    from kinesics.plotting.stick_figures import compute_strokes

    motion = bodies.legs_striding(20)
    last = motion.skeleton.joint_count - 1
    sited = motion.skeleton.replace(end_sites=(*motion.skeleton.end_sites, EndSite(last, (0.0, 0.0, 0.0))))
    a, b = compute_strokes(motion, [3]), compute_strokes(motion.replace(skeleton=sited), [3])
    np.testing.assert_array_equal(a.segments, b.segments)
    assert np.linalg.norm(a.segments[:, :, 1] - a.segments[:, :, 0], axis=-1).max(axis=0).min() > 0.01
    assert len(a.segments[0]) == len(a.sides) == len(a.widths)


def test_a_figure_faces_one_way_whatever_its_heading() -> None:
    """Turned about gravity and carried elsewhere, the same body gives the same drawing (§2.8)."""
    from kinesics.geometry import quaternion
    from kinesics.plotting.stick_figures import compute_strokes

    motion = bodies.legs_striding(20)
    turn = quaternion.from_axis_angle([0.0, 1.0, 0.0], np.array(1.1))
    rotations = np.array(motion.rotations)
    rotations[:, 0] = quaternion.multiply(turn, rotations[:, 0])
    turned = motion.replace(
        rotations=rotations, root_positions=quaternion.rotate(turn, motion.root_positions) + np.array([5.0, 0.0, -2.0])
    )
    here, there = compute_strokes(motion, [7]), compute_strokes(turned, [7])
    np.testing.assert_allclose(here.segments, there.segments, atol=1e-9)
    assert here.sides.count("left") == here.sides.count("right") > 0


def test_left_is_on_the_right_of_the_paper_from_the_front() -> None:
    """Seen from the front the subject's left hand is on the viewer's right."""
    from kinesics.plotting.stick_figures import compute_strokes

    strokes = compute_strokes(bodies.arms_swinging(3), [0], view="front")
    left = [s for s, side in zip(strokes.segments[0], strokes.sides, strict=True) if side == "left"]
    assert max(s[:, 0].max() for s in left) > 0.5


def test_each_bone_is_in_one_limb_and_limbs_do_not_jump() -> None:
    """Bones of a limb follow one another joint to joint, on one side of the body."""
    from kinesics.plotting.stick_figures import compute_strokes

    strokes = compute_strokes(bodies.arms_swinging(3), [0])
    assert sorted(bone for limb in strokes.limbs for bone in limb) == list(range(len(strokes.sides)))
    assert len(strokes.limbs) < 0.7 * len(strokes.sides)
    for limb in strokes.limbs:
        assert len({(strokes.sides[bone], strokes.widths[bone]) for bone in limb}) == 1
        for bone, following in itertools.pairwise(limb):
            np.testing.assert_array_equal(strokes.segments[0, bone, 1], strokes.segments[0, following, 0])


def test_what_cannot_be_drawn_is_refused() -> None:
    """With the names that are known and the numbers that came."""
    motion = bodies.arms_swinging(10)
    sim = kx.similarity(kx.poses(motion))
    with pytest.raises(InputError, match="z_mirror"):
        plotting.similarity_plot(sim, kind="anti")
    with pytest.raises(InputError, match="str"):
        plotting.similarity_plot("walk.bvh")
    with pytest.raises(InputError, match="one shape"):
        plotting.similarity_plot((np.eye(3), np.eye(4)))
    with pytest.raises(InputError, match="10 frames"):
        plotting.similarity_triangle((np.eye(3), np.eye(3)), motion)
    with pytest.raises(InputError, match="three-quarter"):
        plotting.stick_figure(motion, 0, view="top")
    with pytest.raises(InputError, match="No frame 10"):
        plotting.stick_figure(motion, 10)
    with pytest.raises(InputError, match=r"\[0, 10\)"):
        plotting.stick_figure_row(motion, [3, 12])


def test_importing_the_room_does_not_load_matplotlib() -> None:
    """matplotlib costs half a second; it is loaded on the first plot."""
    code = "import sys, kinesics.plotting, kinesics.analysis, kinesics.report; sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
