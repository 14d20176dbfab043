"""Contract suite of lenses."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.camera import LENSES, CameraSpec, Lens, build_camera
from palpate.core import FloatArray, PalpateError


class LensSuite:
    """Inherit and give the fixture `lens`; pytest collects the rest."""

    @pytest.fixture
    def lens(self) -> Lens:
        """A lens that distorts as a real one does."""
        raise NotImplementedError("Give the fixture `lens`.")

    @pytest.fixture
    def points(self, lens: Lens) -> FloatArray:
        """Points (n, 2) on the unit plane where the lens is valid; the first is the middle."""
        reach = min(0.8, 0.9 * lens.max_radius)
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (400, 2)) * reach / np.sqrt(2)
        return np.concatenate([np.zeros((1, 2)), random])

    def test_it_is_found_by_its_name(self, lens: Lens) -> None:
        assert LENSES.get(lens.name) is type(lens)

    def test_undistorted_points_are_distorted_to_where_they_were(self, lens: Lens, points: FloatArray) -> None:
        assert lens.undistort(lens.distort(points)) == pytest.approx(points, abs=1e-8)
        assert lens.distort(points).shape == points.shape
        assert lens.distort(points[None, :3]) == pytest.approx(lens.distort(points)[None, :3])

    def test_the_middle_stays_and_is_seen_true_to_scale(self, lens: Lens) -> None:
        near = np.array([[0.0, 0.0], [1e-6, 0.0], [0.0, 1e-6]])
        assert lens.distort(near) == pytest.approx(near, abs=1e-10)

    def test_what_is_behind_the_camera_stays_unknown(self, lens: Lens) -> None:
        assert np.isnan(lens.distort(np.array([[np.nan, np.nan], [0.1, 0.1]]))).tolist() == [[True] * 2, [False] * 2]

    def test_the_image_grows_up_to_the_limit(self, lens: Lens) -> None:
        radius = np.linspace(0.0, min(lens.max_radius, 3.0), 200)
        seen = lens.distort(np.column_stack([radius, np.zeros_like(radius)]))[:, 0]
        assert (np.diff(seen) > 0).all()

    def test_the_mirrored_lens_shows_the_mirrored_image(self, lens: Lens, points: FloatArray) -> None:
        flip = np.array([-1.0, 1.0])
        assert lens.mirrored().distort(points * flip) * flip == pytest.approx(lens.distort(points), abs=1e-12)

    def test_all_coefficients_are_zero_by_default_and_named(self, lens: Lens) -> None:
        ideal = type(lens)()
        assert ideal.coefficients == (0.0,) * len(lens.parameters())
        assert set(lens.refinable) <= set(lens.parameters())
        assert all(sd > 0 for sd in lens.refinable.values())

    def test_a_camera_with_it_survives_its_file_and_projects_forth_and_back(self, lens: Lens) -> None:
        spec = CameraSpec(lens=lens.name, distortion=lens.coefficients)
        assert CameraSpec.model_validate_json(spec.model_dump_json()) == spec
        camera = build_camera(spec)
        assert camera.lens == lens
        points = np.random.default_rng(1).uniform([-8, -8, 5], [8, 8, 20], (50, 3))
        rays = camera.back_project(camera.project(points))
        expected = points - camera.origin
        assert rays == pytest.approx(expected / np.linalg.norm(expected, axis=1, keepdims=True), abs=1e-8)

    def test_another_count_of_coefficients_is_refused_with_their_names(self, lens: Lens) -> None:
        with pytest.raises(PalpateError, match=f"The lens {lens.name} has {len(lens.parameters())} coefficients"):
            CameraSpec(lens=lens.name, distortion=(*lens.coefficients, 0.0))
