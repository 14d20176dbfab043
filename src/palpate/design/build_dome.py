"""From a spec to a dome."""

from __future__ import annotations

from palpate.design.dome import Dome
from palpate.design.spec import DomeSpec


def build_dome(spec: DomeSpec) -> Dome:
    """Build the dome of `spec`.

    Examples
    --------
    >>> dome = build_dome(DomeSpec(height=30))
    >>> round(dome.radius, 2), str(dome.shape)
    (21.67, 'spherical cap')
    """
    return Dome(height=spec.height, base_radius=spec.base_radius, thickness=spec.thickness)
