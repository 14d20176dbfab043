"""Where the markers of a skin are for any pose of the obstacle: what every interpolation of presses answers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

from palpate.core import FloatArray, TextArray
from palpate.design import PoseSpace
from palpate.twin.tilt_runs import TiltRuns


@dataclass(frozen=True)
class MarkerField(ABC):
    """Positions of a layout's markers over the disc of tilts, one image a depth.

    Attributes
    ----------
    rest
        (m, 3) mm, undeformed markers.
    depths_mm
        (d,) depths of the images.
    runs
        Runs of tilts at each depth.
    space
        What the presses' poses are.
    """

    rest: FloatArray
    depths_mm: FloatArray
    runs: TiltRuns
    space: PoseSpace

    @property
    def max_offset(self) -> float | None:
        """Greatest offset that was pressed, mm, or tilt of walls at the side; `None` for others.

        Their greatest tilt a dataset's spec says.
        """
        return None if self.space.is_tilt and not self.space.is_side else float(self.runs.tilts_deg[-1])

    @property
    def min_tilt_deg(self) -> float:
        """Least tilt that was pressed of walls at the side, degrees; 0 where poses go to the straight one."""
        return float(self.runs.tilts_deg[0]) if self.space.is_side else 0.0

    def labels(self, tilt_deg: FloatArray, depth_index: int) -> tuple[TextArray, TextArray]:
        """Branch of each tilt (n,) at one depth, or why there is none; see `TiltRuns.labels`."""
        return self.runs.labels(tilt_deg, depth_index)

    @abstractmethod
    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        """Deformed positions of the markers.

        Parameters
        ----------
        rx_deg, ry_deg
            (n,) components of the wall's rotation; of another obstacle, its x and y in mm.
        depth_index
            Number of the depth in `depths_mm`.

        Returns
        -------
        FloatArray
            (n, m, 3) mm; NaN for a pose that no run covers (`labels` says why).
        """
