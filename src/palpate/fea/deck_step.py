"""Step and outputs of a deck: the wall moves along its approach axis; pseudo-time is its depth in mm."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from palpate.core import FloatArray
from palpate.fea.deck_spec import DeckElement, DeckSpec, Dialect

_NOTHING = 1e-12
"""Share of a direction vector below which a component counts as zero."""


def time_point_lines(depths: list[float]) -> Iterator[str]:
    """Yield the lines of the time points IMAGES, which both dialects define before the steps."""
    yield "** Stored increments: depth of the wall in mm"
    yield "*TIME POINTS, NAME=IMAGES"
    yield from (f"{depth:.10g}" for depth in depths)


def boundary_lines(spec: DeckSpec, *, half: bool) -> Iterator[str]:
    """Yield the lines of the clamped base, and of a half model's mirror plane (for shells with rotations)."""
    shell = spec.element is DeckElement.SHELL
    yield "** Base fixed in x, y and z" + (
        "; shells may rotate there: write BASE, 1, 6 to clamp them" if shell else ""
    )
    yield "*BOUNDARY"
    yield "BASE, 1, 3"
    if half:
        yield "** Mirror plane x = 0"
        yield "*BOUNDARY"
        yield "MIRROR, 1, 1"
        if shell:
            yield "MIRROR, 5, 6"


def step_lines(spec: DeckSpec, depths: list[float], way: FloatArray) -> Iterator[str]:
    """Yield the step to the last of `depths` (mm), opposite to the unit vector `way`, with its outputs."""
    travel = depths[-1]
    first = min(spec.increment, depths[0])
    along = _in_words(-way)
    yield f"** The wall moves by {travel:.6g} mm along {along}, in increments of at most {spec.increment:g} mm"
    yield "*STEP, NLGEOM, INC=100000" if spec.dialect is Dialect.CALCULIX else "*STEP, NLGEOM=YES, INC=100000"
    yield "*STATIC"
    yield f"{first:.10g}, {travel:.10g}, {spec.smallest_increment:g}, {spec.increment:.10g}"
    yield "*BOUNDARY"
    wall = "WALL_NODES" if spec.dialect is Dialect.CALCULIX else "WALL_REF"
    yield from (f"{wall}, {line}" for line in _moves(-travel * way))
    if spec.dialect is Dialect.CALCULIX:
        yield from _calculix_outputs()
    else:
        yield f"{wall}, 4, 6"
        yield from _abaqus_outputs()
    yield "*END STEP"


def _moves(by: FloatArray) -> Iterator[str]:
    """Yield lines of ``*BOUNDARY``, without the set, that fix or move each component of a vector (3,) mm."""
    still = np.abs(by) <= _NOTHING * np.abs(by).max()
    for stays, group in groupby(range(3), key=lambda k: bool(still[k])):
        axes = [k + 1 for k in group]
        if stays:
            yield f"{axes[0]}, {axes[-1]}"
        else:
            yield from (f"{k}, {k}, {by[k - 1]:.10g}" for k in axes)


def _in_words(along: FloatArray) -> str:
    """Return a unit vector (3,) as text: ``-z`` if it is along an axis."""
    (axes,) = np.nonzero(np.abs(along) > _NOTHING)
    if len(axes) == 1:
        return ("-" if along[axes[0]] < 0 else "+") + "xyz"[axes[0]]
    return "(" + ", ".join(f"{part:.6g}" for part in along + 0.0) + ")"


def _calculix_outputs() -> Iterator[str]:
    yield "** Text results (.dat): displacement mm, force on the wall N, Cauchy stress MPa"
    yield "*NODE PRINT, NSET=DOME_NODES, TIME POINTS=IMAGES"
    yield "U"
    yield "*NODE PRINT, NSET=WALL_NODES, TOTALS=ONLY, TIME POINTS=IMAGES"
    yield "RF"
    yield "*EL PRINT, ELSET=DOME, TIME POINTS=IMAGES"
    yield "S"
    yield "** Results for display (.frd)"
    yield "*NODE FILE, TIME POINTS=IMAGES"
    yield "U"
    yield "*EL FILE, TIME POINTS=IMAGES"
    yield "S"


def _abaqus_outputs() -> Iterator[str]:
    yield "** Fields of every stored increment: displacement, Cauchy stress, contact"
    yield "*OUTPUT, FIELD, TIME POINTS=IMAGES"
    yield "*NODE OUTPUT"
    yield "U, RF"
    yield "*ELEMENT OUTPUT"
    yield "S, LE"
    yield "*CONTACT OUTPUT"
    yield "CSTRESS, CDISP"
    yield "** Force on the wall and energies of every increment"
    yield "*OUTPUT, HISTORY, FREQUENCY=1"
    yield "*NODE OUTPUT, NSET=WALL_REF"
    yield "U, RF"
    yield "*ENERGY OUTPUT"
    yield "ALLSE, ALLWK, ALLIE"
