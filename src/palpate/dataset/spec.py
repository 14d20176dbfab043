"""What a person may choose about a dataset."""

from __future__ import annotations

from typing import Literal

from palpate.core import Spec, parameter


class DatasetSpec(Spec):
    """Which poses are sampled, what disturbs the images, and which presses are held out.

    ``"disc"`` spreads `n_presses` poses evenly over the disc of tilts. ``"paper-91"`` and ``"paper-504"`` are
    the protocols of Zaid et al. 2024: tilts 0 … 12° by 2°, azimuths by 5° over 0 … 60° or the whole turn.
    """

    poses: Literal["disc", "paper-91", "paper-504"] = parameter(
        "disc", unit="", meaning="protocol that chooses the poses"
    )
    n_presses: int = parameter(1200, unit="1", meaning="virtual presses of the protocol 'disc'", ge=10, le=100_000)
    max_tilt_deg: float = parameter(
        12.0,
        unit="deg",
        meaning="greatest tilt of the protocol 'disc'",
        gt=0,
        le=30,
        source="Zaid et al. 2024",
    )
    dropped_images: int = parameter(
        2, unit="1", meaning="images after rest that are left out", ge=0, le=50, source="Zaid et al. 2024"
    )
    jitter_px: float = parameter(
        2.0,
        unit="px",
        meaning="greatest uniform jitter of each pixel coordinate",
        ge=0,
        le=20,
        source="Zaid et al. 2024",
    )
    normalisation: Literal["centred", "unit"] = parameter(
        "centred", unit="", meaning="image scaled to -1 … 1 about its centre, or to 0 … 1 from its corner"
    )
    validation_fraction: float = parameter(
        0.2, unit="1", meaning="share of the presses held out for validation", gt=0, lt=1
    )
    seed: int = parameter(0, unit="1", meaning="seed of poses and split", ge=0)
