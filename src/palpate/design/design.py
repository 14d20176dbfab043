"""Design of a sensor: skin, markers, camera and material."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Self

from palpate.camera import Camera, CameraSpec, build_camera
from palpate.design.build_skin import build_skin, skin_from_data
from palpate.design.dome import DomeSpec
from palpate.design.markers import MarkerLayout
from palpate.design.place_markers import place_markers
from palpate.design.skin import Skin
from palpate.design.spec import MarkerSpec, SkinSpec
from palpate.material import Material, get_material

DEFAULT_MATERIAL = "zaid_2024_ecoflex_00_30"
"""Material of a design without an explicit one."""


@dataclass(frozen=True)
class Design:
    """Design of a sensor.

    Attributes
    ----------
    skin_spec, markers, camera_spec
        Specs of skin, markers and camera; markers may be a layout instead.
    material
        The elastomer, and the gel of a filled skin.

    Examples
    --------
    >>> design = Design(DomeSpec(height=20), MarkerSpec(count=7))
    >>> design.skin.name, len(design.layout), design.camera.project(design.layout.positions).shape
    ('H20 T2', 7, (7, 2))
    """

    skin_spec: SkinSpec = DomeSpec()  # noqa: RUF009  (specs are frozen)
    markers: MarkerSpec | MarkerLayout = MarkerSpec()  # noqa: RUF009
    camera_spec: CameraSpec = CameraSpec()  # noqa: RUF009
    material: Material = field(default_factory=partial(get_material, DEFAULT_MATERIAL))

    @classmethod
    def of_skin(
        cls,
        skin: Skin,
        markers: MarkerSpec | MarkerLayout,
        camera_spec: CameraSpec = CameraSpec(),  # noqa: B008  (a spec is frozen)
        material: Material | None = None,
    ) -> Self:
        """Return the design of an existing skin, with the default material unless one is given."""
        return cls(skin_from_data(skin.spec_data), markers, camera_spec, material or get_material(DEFAULT_MATERIAL))

    @cached_property
    def skin(self) -> Skin:
        """Geometry of the skin."""
        return build_skin(self.skin_spec)

    @cached_property
    def layout(self) -> MarkerLayout:
        """Markers on the inner surface of the skin.

        Raises
        ------
        PalpateError
            If they cannot be placed (`palpate.design.place_markers`).
        """
        return self.markers if isinstance(self.markers, MarkerLayout) else place_markers(self.skin, self.markers)

    @cached_property
    def camera(self) -> Camera:
        """The camera at its design position."""
        return build_camera(self.camera_spec)
