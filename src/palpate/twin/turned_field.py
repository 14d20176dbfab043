"""Markers of a skin with the mirrors x → −x and y → −y for any tilt of a wall: see `palpate.twin.turned_series`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import final

import numpy as np

from palpate.core import FloatArray
from palpate.design import MarkerLayout
from palpate.fea import Press
from palpate.twin.marker_field import MarkerField
from palpate.twin.turned_presses import mirror_points
from palpate.twin.turned_series import TwoMirrorSeries, TwoMirrorTable


@final
@dataclass(frozen=True)
class TwoMirrorField(MarkerField):
    """Markers of a skin with two mirrors.

    Attributes
    ----------
    moved
        Their displacements (m, 3) mm.
    """

    moved: TwoMirrorSeries

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        tilt, azimuth = np.hypot(rx_deg, ry_deg), np.arctan2(ry_deg, rx_deg)
        moved = self.moved.at(tilt, azimuth, self.depths_mm[depth_index])
        moved[self.labels(tilt, depth_index)[0] == ""] = np.nan
        return np.asarray(self.rest + moved)


def build_two_mirror_field(
    presses: Sequence[Press], markers: MarkerLayout, depths_mm: FloatArray | None = None
) -> TwoMirrorField:
    """Interpolate presses of a skin with two mirrors under walls; see `palpate.twin.build_field`.

    Raises
    ------
    PalpateError
        If the obstacle does not tilt, the azimuths are not 0 to 90° in equal steps, or a press is missing.
    """
    table, rest = TwoMirrorTable.of(presses), np.asarray(markers.positions, dtype=float)
    images = table.depths_mm if depths_mm is None else depths_mm
    return TwoMirrorField(
        rest=rest,
        depths_mm=images,
        runs=table.label(images),
        space=presses[0].obstacle.pose_space,
        moved=table.series(partial(mirror_points, points=rest)),
    )
