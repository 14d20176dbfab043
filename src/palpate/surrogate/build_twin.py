"""Make the twin of a design from its presses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import takewhile

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.design import Symmetry
from palpate.fea import Branch, Press
from palpate.mechanics import EndReason
from palpate.surrogate.revolved_field import forces_along_tilt
from palpate.surrogate.surface_series import CIRCLES, ORDERS, expand_surface
from palpate.surrogate.tensor_spline import fit_spline
from palpate.surrogate.tilt_runs import SAME_DEPTH_MM, match_depths
from palpate.surrogate.twin import FORCES, TWIN_DERIVATIVES, Twin
from palpate.surrogate.twin_file import material_text

_PARTS = ("", *TWIN_DERIVATIVES, "friction")
"""Displacement of a press and its derivatives; the last gives the slopes of the first over 1/µ."""
_ACROSS = np.array([False, False, False, False, True, True, False])
"""Whether each part breaks the mirror symmetry."""
_DRIFT, _SLOPE = 3, 6
"""Indices of the first lateral motion, and of the derivative by 1/µ."""
_WEIGHTS = np.array([1.0, 0.3, 1.0, 0.3, 0.3, 0.5, 0.0])
"""Changes for which modes are made: thickness (mm), curvature (1/m), lateral (mm), twist (degrees)."""
_WEIGHT_POWER = np.array([0.0, 1.0, -1.0, 1.0, 1.0, 0.0, 0.0])
"""Exponents by which these changes scale with `Skin.size`."""
_LOST_MM = 1.2e-3
"""Maximum RMS contribution of all omitted modes over all presses, mm, on a skin of size 1. By hand."""
_FEWEST, _FEWEST_DEPTHS = 3, 4
"""Minimum number of tilts, and of several frictions without a derivative by friction; of depths.

Three tilts and their mirror images are five. By hand.
"""


def twin_derivatives(filled: bool, friction: float = np.inf) -> tuple[str, ...]:
    """Return the derivatives that the presses of a twin should have under a coefficient of friction.

    They are `TWIN_DERIVATIVES`, of a filled skin without the thickness, and the friction if it is finite.
    """
    found = tuple(name for name in TWIN_DERIVATIVES if not (filled and name == "thickness"))
    return (*found, "friction") if 0 < friction < np.inf else found


def build_twin(presses: Sequence[Press], inverted: Sequence[Press] = ()) -> Twin:
    """Interpolate presses of one design under walls of every tilt and friction.

    Parameters
    ----------
    presses
        At every tilt from 0, one for each friction, with `twin_derivatives`; increments at the same depths.
    inverted
        Presses of the inverted state at every tilt, with derivatives too, under one contact law, since the state is
        the same under all. It may be missing, or exist at smaller tilts only.

    Returns
    -------
    Twin
        Twin of the flat branch; of the inverted branch as well if it exists at three tilts and four depths.

    Raises
    ------
    PalpateError
        If presses are missing, of several designs or without the derivatives, or the skin is no body of revolution;
        if a press jumps, since it has no derivatives beyond.
    """
    _refuse_others([*presses, *inverted])
    slips, tilts, table = _sort(presses)
    depths = _depths(table, 0.0)
    flat = _interpolate(table, (slips, tilts, depths))
    standing = list(takewhile(_stands, sorted(inverted, key=lambda press: press.obstacle.radial)))
    if len(standing) < _FEWEST:
        return flat
    first = max(float(press.depth[0]) for press in standing)
    depths = _depths(standing, first)
    if len(depths) < _FEWEST_DEPTHS:
        return flat
    tilts = np.array([press.obstacle.radial for press in standing])
    return replace(flat, inverted=_interpolate(standing, (np.zeros(1), tilts, depths)))


def _stands(press: Press) -> bool:
    """Whether an inverted state was found and followed to the maximum depth."""
    return press.ended is EndReason.DEPTH_REACHED and bool((press.branch == str(Branch.INVERTED)).all())


def _interpolate(table: Sequence[Press], axes: tuple[FloatArray, FloatArray, FloatArray]) -> Twin:
    """Make the twin of one branch from presses by ascending 1/µ, then tilt, over 1/µ, tilts and depths."""
    slips, tilts, depths = axes
    fields: list[list[FloatArray]] = []
    forces: list[list[FloatArray]] = []
    names = _derivatives_of(table[0])
    for press in table:
        part_of = [k for k, name in enumerate(_PARTS) if name in press.derivatives]
        rates = (press.derivatives[_PARTS[k]].force for k in part_of)
        expanded = expand_surface(press, {_PARTS[k]: bool(_ACROSS[k]) for k in part_of})
        pushes = np.array([forces_along_tilt(press, force) for force in (press.force, *rates)])
        for found, parts in ((fields, expanded), (forces, pushes)):
            whole = np.zeros((len(_PARTS), *parts.shape[1:]))
            whole[[0, *part_of]] = parts
            if _SLOPE in part_of:  # by 1/µ instead of µ
                whole[_SLOPE] *= -(press.obstacle.friction**2)
            found.append([_fill(part, press, depths) for part in _over_travel(whole, press)])
    shape = (len(slips), len(tilts), len(_PARTS), len(depths))
    values = np.array(fields).reshape(*shape, ORDERS, 3, CIRCLES)
    pushes = np.array(forces).reshape(*shape, FORCES)
    _refuse_holes(values, slips, tilts)
    reach = np.array([_reach(press) for press in table]).reshape(shape[:2])
    for filled in (values, pushes):
        _bridge(filled, reach, slips, depths)
    _straighten(values, pushes)
    sloped = np.array(["friction" in press.derivatives for press in table]).reshape(shape[:2]).all(axis=1)
    order, modes, amplitudes = _reduce(values.reshape(*shape, ORDERS, -1), table[0].mesh.skin.size)
    blocks = np.concatenate([amplitudes, pushes], axis=-1)
    # a tilt of -t is the tilt t seen from the other side, from where a wall drifts the other way, but twists alike
    parity = np.outer([1.0, 1.0, 1.0, -1.0, -1.0, 1.0, 1.0], np.concatenate([(-1.0) ** order, [-1.0, 1.0, -1.0]]))
    both = np.concatenate([parity[:, None] * blocks[:, :0:-1], blocks], axis=1)
    everything = np.moveaxis(both, 2, 3)
    axes = (slips if len(slips) > 1 else np.zeros(1), np.concatenate([-tilts[:0:-1], tilts]), depths)
    everything[~sloped, :, :, _SLOPE] = np.nan
    slopes = np.full_like(everything[..., :_DRIFT, :], np.nan)
    slopes[..., 0, :] = everything[..., _SLOPE, :]
    rows = (*everything.shape[:3], -1)
    pressed = fit_spline(axes, everything[..., :_DRIFT, :].reshape(rows), slopes.reshape(rows))
    drifts = fit_spline(axes, everything[..., _DRIFT:_SLOPE, :].reshape(rows))
    return Twin(
        skin=table[0].mesh.skin,
        order=order,
        modes=modes,
        tilts_deg=tilts,
        depths_mm=depths,
        inverse_frictions=slips,
        max_depth_mm=reach,
        amplitudes=pressed,
        lateral=drifts,
        material=material_text(table[0].material),
        left_out=tuple(name for name in TWIN_DERIVATIVES if name not in names),
    )


def _derivatives_of(press: Press) -> tuple[str, ...]:
    return twin_derivatives(filled=bool(press.mesh.filling))


def _refuse_others(presses: Sequence[Press]) -> None:
    if not presses:
        raise PalpateError(
            "A twin needs presses, and none was given.", "Press the design first.", code="presses-none"
        )
    first = presses[0]
    if first.mesh.skin.hole:
        first.mesh.skin.require_revolution(
            "a twin is of walls that come down", "Use single presses instead.", code="twin-needs-revolution"
        )
    for press in presses:
        if press.mesh.skin.spec_data != first.mesh.skin.spec_data or press.material != first.material:
            raise PalpateError(
                f"The presses are of several designs: {first.mesh.skin.name} and {press.mesh.skin.name}.",
                "Give those of one design and material.",
                code="presses-designs-differ",
            )
        missing = [name for name in _derivatives_of(press) if name not in press.derivatives]
        if missing:
            raise PalpateError(
                f"The press under {press.obstacle.label} has no derivative by {missing[0]}.",
                f"Press with `derivatives: [{', '.join(_derivatives_of(press))}]`.",
                code="derivative-missing",
            )
    if first.mesh.skin.symmetry is not Symmetry.REVOLVED or not all(
        press.obstacle.pose_space.is_tilt for press in presses
    ):
        raise PalpateError(
            "A twin is of a body of revolution under a flat wall.",
            "Use single presses instead.",
            code="twin-needs-flat-wall",
        )


def _sort(presses: Sequence[Press]) -> tuple[FloatArray, FloatArray, list[Press]]:
    """Return 1/µ (s,), tilts (t,), and presses by ascending 1/µ, then tilt."""
    by_place = {(_inverse_friction(press), press.obstacle.radial): press for press in presses}
    slips = np.array(sorted({slip for slip, _ in by_place}))
    tilts = np.array(sorted({tilt for _, tilt in by_place}))
    missing = [(slip, tilt) for slip in slips for tilt in tilts if (slip, tilt) not in by_place]
    if missing:
        slip, tilt = missing[0]
        raise PalpateError(
            f"{len(missing)} presses are missing, the first at a tilt of {tilt:g}° and a friction of {1 / slip:g}."
            if slip
            else f"{len(missing)} presses are missing, the first at a tilt of {tilt:g}° without slip.",
            "Press every tilt under every friction.",
            code="presses-missing",
        )
    if len(slips) > 1 and np.isinf(slips[-1]):
        raise PalpateError(
            f"Of {len(presses)} presses some are frictionless, others are not, and 1/µ has no value between.",
            "Give presses with friction, or frictionless ones alone.",
            code="twin-frictionless-mixed",
        )
    sloped = all("friction" in press.derivatives for press in presses if 0 < press.obstacle.friction < np.inf)
    if tilts[0] != 0.0 or len(tilts) < _FEWEST or (1 < len(slips) < _FEWEST and not sloped):
        raise PalpateError(
            f"{len(tilts)} tilts from {tilts[0]:g}° on and {len(slips)} frictions do not make a twin.",
            f"Press at least {_FEWEST} tilts from 0° on, under one friction or at least {_FEWEST}, or two with "
            "the derivative by friction.",
            code="twin-few-tilts",
        )
    return slips, tilts, [by_place[slip, tilt] for slip in slips for tilt in tilts]


def _inverse_friction(press: Press) -> float:
    return 1.0 / press.obstacle.friction if press.obstacle.friction > 0 else float("inf")


def _depths(presses: Sequence[Press], first: float) -> FloatArray:
    """Depths (d,) mm of the increments, from the first that is at least `first`."""
    steps = {round(float(press.obstacle.depth_step), 9) for press in presses}
    if len(steps) > 1:
        raise PalpateError(
            f"The presses have images every {sorted(steps)} mm.",
            "Give all of them one image step.",
            code="presses-steps-differ",
        )
    step, deepest = steps.pop(), max(_reach(press) for press in presses)
    begin, count = int(np.ceil((first - SAME_DEPTH_MM) / step)), int((deepest + SAME_DEPTH_MM) / step)
    if not first and count < _FEWEST_DEPTHS:
        raise PalpateError(
            f"{count} images down to {deepest:.2f} mm do not make a twin.",
            "Press deeper, or in shorter steps.",
            code="twin-few-images",
        )
    short = min(presses, key=_stored)
    if not first and _stored(short) < _FEWEST:
        raise PalpateError(
            f"The press at {short.obstacle.radial:g}° has {_stored(short)} increments ({short.ended}).",
            f"Press at least {_FEWEST} increments; a shorter step may converge.",
            code="twin-short-press",
        )
    return np.asarray(step * np.arange(begin, count + 1))


def _stored(press: Press) -> int:
    """Number of loading increments of a press before it leaves its first branch or jumps."""
    down = int(np.argmax(press.depth)) + 1
    lost = np.flatnonzero((press.branch[:down] != press.branch[0]) | (press.depth[:down] >= press.jump_depth))
    return int(lost[0]) if len(lost) else down


def _reach(press: Press) -> float:
    return float(press.depth[_stored(press) - 1])


def _over_travel(parts: FloatArray, press: Press) -> FloatArray:
    """Convert derivatives by lateral rate (mm/mm) among parts (7, n, …) to those by lateral motion (mm)."""
    found = parts.copy()
    depth = press.depth.reshape(-1, *[1] * (parts.ndim - 2))
    rest = int(depth.flat[0] == 0.0)
    drifts = slice(_DRIFT, _SLOPE)
    found[drifts, rest:] = parts[drifts, rest:] / depth[rest:]
    if rest:
        found[drifts, 0] = 2.0 * found[drifts, 1] - found[drifts, 2]
    return found


def _refuse_holes(values: FloatArray, inverse_frictions: FloatArray, tilts: FloatArray) -> None:
    """Reject presses with a jump, since their derivatives end there."""
    holes = np.argwhere(~np.isfinite(values.reshape(len(inverse_frictions), len(tilts), -1)).all(axis=-1))
    if len(holes):
        slip, tilt = inverse_frictions[holes[0, 0]], tilts[holes[0, 1]]
        law = f"µ = {1 / slip:.3g}" if slip > 0 else "no slip"
        raise PalpateError(
            f"{len(holes)} of {len(inverse_frictions) * len(tilts)} presses jump to another state, the first "
            f"at {tilt:g}° under {law}; there is no twin across a jump.",
            "Take a thicker or lower skin, or less depth.",
            code="twin-across-jump",
        )


def _bridge(values: FloatArray, reach: FloatArray, inverse_frictions: FloatArray, depths: FloatArray) -> None:
    """Extend presses that end early by interpolation between those of the neighbouring frictions.

    `values` (1/µ, tilt, 7, depth, …) are of presses that reach (1/µ, tilt) mm. A thin skin may invert at one friction
    only; linear extrapolation there would distort the interpolation at neighbouring frictions.
    """
    count = (depths <= reach[..., None] + SAME_DEPTH_MM).sum(axis=-1)
    for k, tilt in np.ndindex(max(len(inverse_frictions) - 2, 0), reach.shape[1]):
        row, known = k + 1, count[k + 1, tilt]
        last = min(count[row - 1, tilt], count[row + 1, tilt])
        if last <= known:
            continue
        step = inverse_frictions[row + 1] - inverse_frictions[row - 1]
        share = (inverse_frictions[row] - inverse_frictions[row - 1]) / step
        between = (1 - share) * values[row - 1, tilt] + share * values[row + 1, tilt]
        between[_SLOPE] = (values[row + 1, tilt, 0] - values[row - 1, tilt, 0]) / step
        apart = values[row, tilt, :, known - 1 : known] - between[:, known - 1 : known]
        values[row, tilt, :, known:] = between[:, known:] + apart


def _straighten(values: FloatArray, forces: FloatArray) -> None:
    """Remove mesh effects at tilt 0, in values (1/µ, tilt, 7, depth, order, …) and forces (…, 3).

    Under an untilted wall nothing depends on the direction: displacement, curvature and twist have order 0 only, and
    a lateral motion is one field of order 1 in any direction. Further terms come from the mesh, which is centred at
    the contact.
    """
    straight, push = values[:, :1].copy(), forces[:, :1].copy()
    for part, order in enumerate((0, 0, 0, 1, 1, 0, 0)):
        straight[:, :, part, :, order] = 0.0
    up, aside = _DRIFT, _DRIFT + 1  # a quarter turn makes the one the other's negative
    straight[:, :, up, :, 1] = straight[:, :, aside, :, 1] = 0.5 * (
        values[:, :1, up, :, 1] + values[:, :1, aside, :, 1]
    )
    push[:, :, [*range(_DRIFT), _SLOPE], :, 1] = 0.0
    along, across = forces[:, :1, up, :, 0], forces[:, :1, aside, :, 2]
    push[:, :, up, :, 0], push[:, :, aside, :, 2] = 0.5 * (along - across), 0.5 * (across - along)
    values -= straight
    forces -= push


def _fill(values: FloatArray, press: Press, depths: FloatArray) -> FloatArray:
    """Interpolate a press's values (n, …) to the depths (n depths, …), linearly beyond its last increment."""
    _, image = match_depths(depths[depths <= _reach(press) + SAME_DEPTH_MM], press)
    known = values[image]
    rest = np.arange(1, len(depths) - len(image) + 1).reshape(-1, *[1] * (values.ndim - 1))
    return np.concatenate([known, known[-1] + rest * (known[-1] - known[-2])])


def _reduce(values: FloatArray, size: float) -> tuple[IntArray, FloatArray, FloatArray]:
    """Reduce series (1/µ, tilt, 7, depth, order, 3 circles) to modes: order (r,), shapes, amplitudes."""
    weighted = values * (_WEIGHTS * size**_WEIGHT_POWER)[:, None, None, None]
    pressed = weighted.reshape(-1, ORDERS, 3 * CIRCLES)
    found = [np.linalg.svd(pressed[:, k], full_matrices=False)[1:] for k in range(ORDERS)]
    strength = np.sort(np.concatenate([each for each, _ in found]))
    presses = len(pressed) * 2 // len(_PARTS)
    carried = np.sqrt(np.cumsum(strength**2) / (2 * presses * CIRCLES))  # half a square is a wave's mean
    weakest = strength[np.searchsorted(carried, _LOST_MM * size)]
    kept = [modes[each >= weakest] for each, modes in found]
    amplitudes = [values[..., k, :] @ modes.T for k, modes in enumerate(kept)]
    order = np.repeat(np.arange(ORDERS), [len(modes) for modes in kept])
    return order, np.concatenate(kept).reshape(-1, 3, CIRCLES), np.concatenate(amplitudes, axis=-1)
