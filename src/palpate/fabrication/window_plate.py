"""Window of a filled skin: a clear plate inside the flange, flush with the base, under the gel.

    .--.        skin
 __|   gel    |__     z = 0
|__| ======== |__|    flange; window from z = 0 down
___||___   __||____   boss of the housing within the flange, and the ledge that the window rests on
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import CadSolid, ContactModule, Skin
from palpate.fabrication.spec import ProcessSpec

LEDGE = 1.5
"""Width of the ledge under the window's edge, mm."""
_POINTS = 360


@dataclass(frozen=True)
class WindowPlate:
    """Window and its support, in the frame of its module, mm.

    Attributes
    ----------
    solid, thickness, reach
        The plate, its thickness, and half its width along x.
    boss, opening
        Height of the housing's boss over the seat of the flange, and half the width along x of the opening in the
        ledge.
    gel_mm3, skin
        Volume between skin and window, mm³, and the filled skin.
    """

    solid: CadSolid
    thickness: float
    reach: float
    boss: float
    opening: float
    gel_mm3: float
    skin: Skin

    @property
    def line(self) -> FloatArray:
        """Its edge (n, 2) mm."""
        return np.asarray(self.reach * self.skin.plan.edge(np.linspace(0, 2 * np.pi, _POINTS, endpoint=False))[0])


def build_window(module: ContactModule, thickness: float, spec: ProcessSpec) -> WindowPlate:
    """Build the window of a module, of a thickness in mm.

    Raises
    ------
    PalpateError
        If the thickness is not positive, or exceeds that of the flange.
    """
    if not 0 < thickness <= module.flange_thickness:
        raise PalpateError(
            f"The window is {thickness:g} mm thick, the flange around it {module.flange_thickness:g} mm.",
            f"Use a window of up to {module.flange_thickness:g} mm, or a thicker flange.",
            code="window-too-thick",
        )
    reach = module.opening_radius - spec.clearance
    gel = [(0.0, module.skin.height), *module.skin.meridian(0.0, down=True), (0.0, 0.0)]
    return WindowPlate(
        solid=module.prism(reach, -thickness, 0.0),
        thickness=thickness,
        reach=reach,
        boss=module.flange_thickness - thickness,
        opening=module.opening_radius - LEDGE,
        gel_mm3=module.solid(gel).volume,
        skin=module.skin,
    )
