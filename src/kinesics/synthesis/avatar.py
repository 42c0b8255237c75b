"""The Markov-controlled avatar of [Schultz2012] §4.4.1: who performs live, and is told meanwhile where to go.

The controller decides for paths, a third of a second ahead; the renderer makes frames of them.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from kinesics.body.motion import Motion
from kinesics.body.skeleton import Skeleton
from kinesics.synthesis.control.controller import BEND, BETA, Controller
from kinesics.synthesis.goals.arguments import place_of
from kinesics.synthesis.live.renderer import LiveFrame, LiveRenderer, performed
from kinesics.synthesis.material import Material, beginning
from kinesics.synthesis.request import Request

if TYPE_CHECKING:
    from kinesics.synthesis.goals import Feature, Goal


class Avatar(Iterator[LiveFrame]):
    """Performs live, one frame after the other, without end; what is wished for may change at any time.

        >>> avatar = kx.Avatar(kx.prepare([walk, turn]), target=(3.0, 3.0), seed=1)
        >>> frame = next(avatar)  # frame.rotations: (joints, 4), frame.root: (3,); avatar.skeleton tells the joints
        >>> avatar.pursue(target=(-3.0, 5.0))  # from the next decision on

    Parameters
    ----------
    material : what `kinesics.prepare` made; or recordings, which are then prepared.
    target, radius, route, from_state, favour, goal, seed, beta, bend : as of `kinesics.performance`. Places are metres to the left
        and ahead of where the performer starts, however far it has come meanwhile.
    start, heading : x, z in metres, and radians about +y, of the first frame; places are then those of the same world.

    Raises
    ------
    InputError, SkeletonError
        As `kinesics.performance`.
    """

    def __init__(
        self,
        material: Material | Motion | Sequence[Motion],
        *,
        target: ArrayLike | None = None,
        radius: float | None = None,
        route: ArrayLike | None = None,
        from_state: str | None = None,
        favour: str | None = None,
        goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
        seed: int = 0,
        beta: float = BETA,
        bend: float = BEND,
        start: tuple[float, float] = (0.0, 0.0),
        heading: float = 0.0,
    ) -> None:
        asked = Request(
            target=target,
            radius=radius,
            route=route,
            from_state=from_state,
            favour=favour,
            goal=goal,
            seed=seed,
            beta=beta,
            bend=bend,
        )
        begin = place_of(start, "start")
        self.material = material if isinstance(material, Material) else Material(material)
        ground = self.material.ground(asked.wish)
        self.network = ground.network
        """The paths it performs: of the part of the recordings that holds what is wished for."""
        self.controller = Controller(
            ground.network,
            ground.wish.goals(),
            beta=float(beta),
            bend=float(bend),
            seed=asked.whole_seed,
            start=beginning(ground.network, ground.wish, asked.whole_seed),
            position=begin,
            heading=heading,
            prepared=ground.ahead,
        )
        """Decides for paths."""
        self.renderer = LiveRenderer(ground.network, self.controller, start=begin, heading=heading)
        """Makes frames of them."""

    @property
    def skeleton(self) -> Skeleton:
        """Whose joints the frames turn."""
        return self.network.repertoire.skeleton

    @property
    def fps(self) -> float:
        """Frames a second."""
        return self.network.repertoire.fps

    def __iter__(self) -> Avatar:
        """Itself."""
        return self

    def __next__(self) -> LiveFrame:
        """The next frame."""
        return self.renderer.step()

    def pursue(
        self,
        *,
        target: ArrayLike | None = None,
        radius: float | None = None,
        route: ArrayLike | None = None,
        favour: str | None = None,
        goal: Goal | Feature | Sequence[Goal | Feature] | None = None,
    ) -> None:
        """Wish for something else from the next decision on; for nothing but going on, if nothing is given.

        Raises
        ------
        InputError
            If it contradicts itself, or cannot be pursued with what is performed: the grammar's words, for one, are known only
            where the avatar was made with such a wish.
        """
        asked = Request(target=target, radius=radius, route=route, favour=favour, goal=goal)
        wish = asked.wish.by_name(self.material.recordings, self.network.repertoire.names)
        self.controller.pursue(wish.goals())

    @property
    def attained(self) -> bool:
        """Whether all that can be attained of what is wished for was; False where there is none such.

        It is decided a third of a second ahead: so much later the body is there.
        """
        return self.controller.attained

    @property
    def outcome(self) -> tuple[str, ...]:
        """What came of what is wished for, so far, in words."""
        return self.controller.outcome()

    def motion(self, frames: Sequence[LiveFrame]) -> Motion:
        """Frames that it performed, one after the other, as a motion: to be written, looked at and measured."""
        return performed(self.network, frames).motion
