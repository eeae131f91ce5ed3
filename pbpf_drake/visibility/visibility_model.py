"""How visible particles are to the camera (Section 4.3)."""

from dataclasses import dataclass
import itertools

import numpy as np
from pydrake.systems.framework import Context

from pbpf_drake.config.scene_config import Scene
from pbpf_drake.process_crew import Crew
from pbpf_drake.visibility.ray_world import RayWorld


@dataclass(frozen=True)
class RayCaster:
    """What a process scores particles with.

    Attributes:
        world: shared by all.
        context: of the world, this process' own.
    """

    world: RayWorld
    context: Context


@dataclass(frozen=True)
class ScoringJob:
    """Particles to score; the attributes are those of CalcSeenShares."""

    particles: np.ndarray
    tracked: np.ndarray
    p_OT: np.ndarray
    robot_positions: np.ndarray

    def RunOn(self, caster: RayCaster) -> np.ndarray:
        """Returns the particles' scores, (m, T)."""
        return caster.world.CalcSeenShares(
            self.particles,
            tracked=self.tracked,
            p_OT=self.p_OT,
            robot_positions=self.robot_positions,
            context=caster.context,
        )


class VisibilityModel:
    """Scores how much of each object of each particle the camera sees.

    The score v is the share of R rays that hit the particle. The rays go from
    the camera's centre to points spread over the object's surface, the same
    points for all particles. A ray hits the particle unless it first enters
    the robot, a fixed model, or another tracked object of the same particle.
    The object does not hide its own back: a ray to a point there hits the
    object at its front. A target outside the image is not hit.

    The model never changes. Whoever shares it needs a scratch of their own.
    """

    def __init__(self, *, scene: Scene, num_rays: int):
        """Builds the world of a scene.

        Args:
            scene: the scene; its filter's config is not used.
            num_rays: R, the rays per object and particle.

        Raises:
            ValueError: the scene's models don't fit their roles, a tracked
                object has no collision geometry, or the camera is inside a
                fixed model, which hides everything.
        """
        self._world = RayWorld(scene)
        self._num_rays = num_rays

    def MakeScratch(self, parallelism: int = 1) -> Crew[RayCaster]:
        """Returns the processes that Score works with.

        Args:
            parallelism: how many processes share the particles.
        """
        caster = RayCaster(self._world, self._world.MakeContext())
        return Crew(caster, parallelism)

    def Score(
        self,
        *,
        particles: np.ndarray,
        known: np.ndarray,
        robot_positions: np.ndarray,
        rng: np.random.Generator,
        scratch: Crew[RayCaster],
    ) -> np.ndarray:
        """Returns the visibility v of every object of every particle.

        Args:
            particles: (M, K, 7 or more), poses X_WO of the objects in the
                scene's order: qw qx qy qz (of unit length), x y z (in
                meters); what follows is not used.
            known: (K,), whose particles mean something: the object is
                tracked or detected. The others hide nothing, and their score
                is 1.
            robot_positions: (n,), the robot's joint positions.
            rng: draws the points on the surfaces.
            scratch: from MakeScratch; what is in it does not matter.

        Returns:
            (M, K), in [0, 1].
        """
        tracked = np.flatnonzero(known)
        p_OT = np.stack(
            [s.sample(rng, self._num_rays) for s in self._world.surfaces()]
        )[tracked]
        shares = np.array_split(particles[:, tracked], scratch.size)
        results = scratch.Run(
            [
                [ScoringJob(share, tracked, p_OT, robot_positions)]
                if len(share)
                else []
                for share in shares
            ]
        )
        scores = np.ones((len(particles), len(known)))
        scores[:, tracked] = np.concatenate([*itertools.chain(*results)])
        return scores
