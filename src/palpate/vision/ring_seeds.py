"""Seeds of a print of rings: three possible neighbours on the innermost ring, confirmed by others."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.vision.fit_ring import RingFitter
from palpate.vision.rings import ring_harmonics

_NEAR = 8
"""Number of a blob's neighbours among which those on the innermost ring are searched. By hand."""
_SIDES = (0.65, 1.55)
"""Bounds of the ratio of two distances of neighbours on the innermost ring. By hand."""
_AXES = 1.5
"""Maximum axis ratio of the innermost ring through three of its blobs. By hand."""
_SIZES = (0.55, 1.8)
"""Bounds of its radius over the design's in the nominal image. By hand."""
_SEED = 0.3
"""Maximum distance of a blob from its prediction by three of its ring, over the radius. By hand."""


def seed_rings(
    settler: RingFitter, azimuth: FloatArray, nominal: FloatArray, least: float
) -> tuple[list[FloatArray], int]:
    """Find innermost rings through three blobs that others confirm.

    The ring has markers at azimuths (n,) and coefficients (3, 2) of `ring_harmonics` in the nominal image; a minimum
    share of the ring and its centre marker must have a blob.

    Returns
    -------
    list of ndarray
        Coefficients (7, 2) of `ring_harmonics`, most central first, each set of blobs once.
    int
        Number of confirmed seeds before duplicates were removed.
    """
    blobs, phi = settler.blobs, azimuth
    handed = float(np.sign(np.linalg.det(nominal[1:])))
    step = 2.0 * np.pi / len(phi)
    near = settler.tree.query(blobs, min(_NEAR + 1, len(blobs)))[1][:, 1:]
    a, c = np.triu_indices(near.shape[1], 1)
    first, last = np.concatenate([a, c]), np.concatenate([c, a])
    b = np.repeat(np.arange(len(blobs)), len(first))
    a, c = near[:, first].ravel(), near[:, last].ravel()
    # three neighbours on the ring, then the middle and two neighbours
    turn = np.array([-step, 0.0, step])
    side, other = blobs[a] - blobs[b], blobs[c] - blobs[b]
    lengths, others = np.linalg.norm(side, axis=1), np.linalg.norm(other, axis=1)
    across = side[:, 0] * other[:, 1] - side[:, 1] * other[:, 0]
    alike = (lengths > _SIDES[0] * others) & (lengths < _SIDES[1] * others)
    keep = alike & (np.sign(across) == -handed) & (lengths > 1.0) & (others > 1.0)
    three = np.linalg.inv(ring_harmonics(turn, 3)) @ np.stack([blobs[a], blobs[b], blobs[c]], axis=1)[keep]
    keep = alike & (np.sign(across) == handed) & (lengths > 1.0) & (others > 1.0)
    design = np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, np.cos(step), np.sin(step)]])
    two = np.linalg.inv(design) @ np.stack([blobs[b], blobs[a], blobs[c]], axis=1)[keep]
    weights = np.concatenate([three, two])
    axes = np.linalg.svd(weights[:, 1:], compute_uv=False)
    size = axes.mean(axis=1) / np.linalg.svd(nominal[1:], compute_uv=False).mean()
    weights = weights[(axes[:, 0] < _AXES * axes[:, 1]) & (size > _SIZES[0]) & (size < _SIZES[1])]
    return _confirmed(settler, weights, azimuth, least)


def _confirmed(
    settler: RingFitter, weights: FloatArray, azimuth: FloatArray, least: float
) -> tuple[list[FloatArray], int]:
    """Return the seeds (n, 3, 2) with enough blobs, each set of blobs once."""
    if not len(weights):
        return [], 0
    radius = np.linalg.svd(weights[:, 1:], compute_uv=False).mean(axis=1)
    places = ring_harmonics(azimuth, 3) @ weights
    places = np.concatenate([places, weights[:, :1]], axis=1)
    distance, blob = settler.tree.query(places)
    hit = distance < _SEED * radius[:, None]
    enough = hit.sum(axis=1) >= least * places.shape[1]
    middle = np.median(settler.blobs, axis=0) / 2.0 + settler.blobs.mean(axis=0) / 2.0
    far = np.linalg.norm(weights[:, 0] - middle, axis=1)
    misses = np.where(hit, distance, radius[:, None] * _SEED).sum(axis=1) / radius
    best: dict[frozenset[int], int] = {}
    for number in np.flatnonzero(enough)[np.argsort(misses[enough], kind="stable")]:
        best.setdefault(frozenset(blob[number][hit[number]].tolist()), int(number))
    order = sorted(best.values(), key=lambda number: (far[number] // (0.7 * radius[number]), misses[number]))
    return [np.vstack([weights[number], np.zeros((4, 2))]) for number in order], int(enough.sum())
