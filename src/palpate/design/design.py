"""The design of a sensor: skin, markers, camera and elastomer in one value."""

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
"""Elastomer of a design whose material is not given."""


@dataclass(frozen=True)
class Design:
    """A sensor as designed.

    Attributes
    ----------
    skin_spec, markers, camera_spec
        Specs of the skin, of its markers, and of the camera. Markers may be given as a layout instead.
    material
        The elastomer, with the gel inside if there is any.

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
        """Return the design of a skin that is built already; without a material, of the default one."""
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
        """The camera, mounted as designed."""
        return build_camera(self.camera_spec)
