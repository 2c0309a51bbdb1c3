"""Adaptive image-plane sampler for Monte Carlo renderers.

    film = pmcip.Film(640, 480, spp=16)
    def radiance(plan):                       # your renderer: a ray for each position
        u, v = plan.points(1)
        return numpy.stack([plan.x, plan.y, u], axis=-1)
    film.render(radiance, spp=16)
    picture = film.guided()                   # (480, 640, 3), linear, rows from the top
"""

import numpy as np
from numpy.typing import NDArray

class Plan:
    """Samples to be taken: as many entries in each array."""

    x: NDArray[np.float32]
    """Horizontal film positions in pixels, growing to the right, placed inside their pixels."""
    y: NDArray[np.float32]
    """Vertical film positions in pixels, growing downwards."""
    index: NDArray[np.uint32]
    """Numbers of the samples in their pixels' sequences."""
    key: NDArray[np.uint32]
    """Keys of these sequences: hash them with the index to seed a generator of your own."""
    @property
    def end(self) -> int:
        """Where the next plan begins; width * height after the last."""
    def __len__(self) -> int: ...
    def points(self, set: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Stratified points in [0, 1) x [0, 1). Set 0 has been used for x and y: take 1 for the lens, 2 for time and
        wavelength, and one for every further pair of decisions."""

def points(
    set: int, index: NDArray[np.uint32], key: NDArray[np.uint32]
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Points of any samples: see Plan.points."""

class Film:
    """A film and the sampler that decides where it needs samples. What does not fit raises ValueError."""

    def __init__(
        self,
        width: int,
        height: int,
        *,
        spp: int = 0,
        pilot: int = 2,
        labels: NDArray[np.uint16] | None = None,
        seed: int = 0,
        frame: int = 0,
        cd_per_unit: float = 100.0,
        uniform: bool = False,
        gamma: float | None = None,
        epsilon: float | None = None,
        fair: int | None = None,
    ) -> None:
        """spp: samples a pixel there will be, pilot of them in the first iteration; 0 if nobody knows. labels: island of
        each pixel, 0 for none. cd_per_unit: luminance in cd/m^2 of radiance 1."""
    @staticmethod
    def load(data: bytes) -> Film:
        """A film that was saved."""
    def save(self) -> bytes:
        """The film, also in the middle of an iteration, the same bytes on every machine."""
    @property
    def pixels(self) -> int:
        """Pixels that get samples."""
    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
    @staticmethod
    def schedule(pixels: int, spp: int, pilot: int, iterations: int) -> list[int]:
        """Samples of the iterations of a frame."""
    def begin(self, samples: int, alpha: NDArray[np.float32] | None = None) -> None:
        """Begins an iteration of so many samples over all pixels; alpha, if given, says where: none where it is 0."""
    def plan(self, first: int = 0, most: int | None = None) -> Plan:
        """Samples of the running iteration, from pixel `first` on (0, or the end of a plan), up to `most` of them."""
    def deliver(self, plan: Plan, rgb: NDArray[np.float32]) -> None:
        """Radiances of a plan, (len(plan), 3), in any order of plans."""
    def end(self) -> tuple[int, int]:
        """Ends the iteration; samples taken so far, and those left out since they were not finite."""
    def render(self, radiance, spp: int, *, pilot: int = 2, iterations: int = 8, most: int | None = None) -> None:
        """All iterations of a frame: radiance(plan) returns float32 (len(plan), 3)."""
    def resolve(self, estimator: str = "balanced") -> NDArray[np.float32]:
        """The picture, (height, width, 3): balanced, pooled or difference."""
    def guided(
        self,
        albedo: NDArray[np.float32] | None = None,
        normal: NDArray[np.float32] | None = None,
        depth: NDArray[np.float32] | None = None,
    ) -> NDArray[np.float32]:
        """The filtered picture with all its energy; features are (height, width[, 3]), seen through glass and mirrors."""
    def resolve_guided(self, guide: NDArray[np.float32]) -> NDArray[np.float32]:
        """Any picture, another denoiser's for instance, with the energy of the film."""
    def variance(self) -> NDArray[np.float32]:
        """Variance of every pixel's mean luminance."""
    def count(self) -> NDArray[np.uint32]:
        """Samples of every pixel."""
    def alpha(self) -> NDArray[np.float32]:
        """The kernel that divided the last iteration; it sums to one."""
