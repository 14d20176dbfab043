"""Fit a model to all samples at once: weighted least squares on nominal stress.

Linear constants are solved exactly; shapes are searched from several starts with the linear constants eliminated, so
the search has one to three unknowns (variable projection; the derivative is Kaufman's).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.special import stdtrit

from palpate.core import FloatArray, PalpateError
from palpate.material.curve import Mode, stretches, uniaxial_range
from palpate.material.drucker import drucker_matrix, scan_ends
from palpate.material.fit import Fit, assess_fit
from palpate.material.law import Model
from palpate.material.least_squares import lengths, solve_linear, solve_positive_definite, solve_signed
from palpate.material.make_law import get_model
from palpate.material.sample import Loading, Sample
from palpate.material.spec import FitSpec, Weighting

_LEAST_SHARE = 0.01
"""Minimum stress of relative weights, over a mode's maximum stress. By hand."""
_MARGIN = 1e-3
"""Minimum stiffness of a stable fit, over that of the neo-Hookean fit in the same state. By hand."""
_STATES = 400
"""Stretches of each mode at which stability is required. By hand."""
_GOOD_STARTS = 3
"""Number of best starts that are searched to the end. By hand."""
_AT_BOUND = 1e-6
"""Relative distance from a bound up to which a constant is at it. By hand."""
_FEWEST_SAMPLES = 3
"""Minimum number of samples per test for intervals from their differences. By hand."""


class _Data(NamedTuple):
    """Principal stretches (n, 3), nominal stress (n,) MPa and square root of the weight (n,) of all rows."""

    principal: FloatArray
    nominal: FloatArray
    root: FloatArray


@dataclass(frozen=True)
class _Solution:
    linear: FloatArray
    shapes: FloatArray
    objective: float
    held: bool


def fit_material(samples: Sequence[Sample], spec: FitSpec | None = None) -> Fit:
    """Fit one model to all samples.

    If every test has at least three samples, the intervals come from the differences between samples (a jackknife
    that leaves each out in turn, by test). Otherwise every row counts as an independent observation, which is right
    for noise and too narrow if specimens differ.

    Parameters
    ----------
    samples
        Of one or several modes.
    spec
        Model, weights, stability.

    Raises
    ------
    PalpateError
        If there are fewer rows than the model has constants, or no stable fit exists.
    """
    fit = fit_rows(samples, spec)
    if fit.held or min(Counter(sample.loading for sample in samples).values()) < _FEWEST_SAMPLES:
        return fit
    try:
        return replace(fit, intervals=_intervals_between(samples, fit), from_samples=True)
    except PalpateError:
        return fit


def _intervals_between(samples: Sequence[Sample], fit: Fit) -> FloatArray:
    """Confidence intervals (p, 2) by the stratified jackknife (Shao & Tu 1995, section 6.2), by test.

    Student's distribution has Satterthwaite's degrees of freedom, since one test alone may determine a constant.
    """
    left_out: dict[Loading, list[FloatArray]] = {}
    for at, sample in enumerate(samples):
        other = fit_rows([*samples[:at], *samples[at + 1 :]], fit.spec, near=fit)
        left_out.setdefault(sample.loading, []).append(np.concatenate([other.linear, other.shapes]))
    parts = np.array([np.var(np.array(each), axis=0) * (len(each) - 1) for each in left_out.values()])
    free = np.array([len(each) - 1 for each in left_out.values()])[:, None]
    variance = np.maximum(parts.sum(axis=0), 1e-300)
    freedom = variance**2 / np.maximum((parts**2 / free).sum(axis=0), 1e-300)
    half = stdtrit(freedom, 0.5 + 0.5 * fit.spec.confidence) * np.sqrt(variance)
    values = np.concatenate([fit.linear, fit.shapes])
    return np.column_stack([values - half, values + half])


def fit_rows(samples: Sequence[Sample], spec: FitSpec | None = None, near: Fit | None = None) -> Fit:
    """Fit one model to all rows of all samples, each row an independent observation.

    Parameters
    ----------
    samples, spec
        As for `fit_material`.
    near
        A fit of the same model to almost the same rows: its shapes are the only start of the search.
    """
    spec = spec or FitSpec()
    model = get_model(spec.model)
    data = _gather(samples, spec)
    if len(data.nominal) <= len(model.constants):
        raise PalpateError(
            f"{model.name} has {len(model.constants)} constants and there are {len(data.nominal)} rows.",
            "Give more rows or choose a model with fewer constants.",
            code="fit-few-rows",
        )
    low, high = _scanned(samples, spec)
    if not model.shapes:
        solution = _fit_linear(model, data, (low, high) if spec.stable else None)
    else:
        solution = _fit_shapes(model, data, spec, near)
    jacobian = _jacobian(model, data, solution)
    return Fit(
        spec=spec,
        model=model,
        linear=solution.linear,
        shapes=solution.shapes,
        intervals=_intervals(jacobian, solution, spec.confidence),
        objective=solution.objective,
        condition=_condition(jacobian),
        count=len(data.nominal),
        aicc=_aicc(solution.objective, len(data.nominal), len(model.constants)),
        quality=assess_fit(samples, [model.terms(s.principal, solution.shapes) @ solution.linear for s in samples]),
        scanned=(low, high),
        held=solution.held,
        from_samples=False,
    )


def _gather(samples: Sequence[Sample], spec: FitSpec) -> _Data:
    if not samples:
        raise PalpateError("There are no samples.", "Give the files of at least one test.", code="fit-no-samples")
    greatest = {
        mode: max((float(np.abs(s.nominal).max()) for s in samples if s.mode is mode), default=0.0) for mode in Mode
    }
    roots = []
    for sample in samples:
        scale = greatest[sample.mode]
        if spec.weighting is Weighting.RELATIVE:
            roots.append(1 / np.maximum(np.abs(sample.nominal), _LEAST_SHARE * scale))
        elif spec.weighting is Weighting.MODE:
            roots.append(np.full(len(sample.nominal), 1 / scale))
        else:
            roots.append(np.ones(len(sample.nominal)))
    return _Data(
        np.concatenate([sample.principal for sample in samples]),
        np.concatenate([sample.nominal for sample in samples]),
        np.concatenate(roots),
    )


def _scanned(samples: Sequence[Sample], spec: FitSpec) -> tuple[float, float]:
    """Uniaxial stretches of the stability scan: those of the spec, or of the data if they go further."""
    ends = [uniaxial_range(sample.mode, sample.stretch.min(), sample.stretch.max()) for sample in samples]
    return min(spec.stable_from, *(low for low, _ in ends)), max(spec.stable_to, *(high for _, high in ends))


def _weighted(model: Model, data: _Data, shapes: FloatArray) -> tuple[FloatArray, FloatArray]:
    return model.terms(data.principal, shapes) * data.root[:, None], data.nominal * data.root


def _fit_linear(model: Model, data: _Data, ends: tuple[float, float] | None) -> _Solution:
    none = np.empty(0)
    A, b = _weighted(model, data, none)
    c = solve_linear(A, b)
    held = False
    if ends is not None:
        found = solve_positive_definite(A, b, _drucker_terms(model, data, ends), _MARGIN)
        if found is None:
            raise PalpateError(
                f"No stable {model.name} fits these data.",
                "Choose another model or a narrower range.",
                code="fit-unstable",
            )
        held = len(found[1]) > 0
        c = found[0]
    return _Solution(c, none, float(np.sum((A @ c - b) ** 2)), held)


def _drucker_terms(model: Model, data: _Data, ends: tuple[float, float]) -> FloatArray:
    """Drucker's matrices (k, m, 2, 2) of each constant at unit value, over those of the neo-Hookean fit.

    ``D_n^-1/2 D D_n^-1/2`` is positive definite where D is, and of the size of the stiffness over a rubber's at every
    stretch, so one margin serves all.
    """
    none = np.empty(0)
    plain = get_model("neo-hooke")
    c10 = solve_linear(*_weighted(plain, data, none))
    if not c10[0] > 0:
        raise PalpateError("The stress falls with the stretch.", "Check columns and signs.", code="fit-stress-falls")
    states = np.concatenate(
        [stretches(mode, end ** np.linspace(0, 1, _STATES)) for mode in Mode for end in scan_ends(mode, *ends)]
    )
    rubber = plain.law(c10, none)
    value, axis = np.linalg.eigh(drucker_matrix(rubber, states))
    root = np.einsum("mia,ma,mja->mij", axis, value**-0.5, axis)
    laws = [model.law(row, none) for row in np.eye(len(model.linear))]
    return np.array([root @ drucker_matrix(law, states) @ root for law in laws])


def _fit_shapes(model: Model, data: _Data, spec: FitSpec, near: Fit | None) -> _Solution:
    """Search the shapes: a few steps from every start, then the best starts to the end."""
    starts = model.starts(data.principal, spec.max_exponent)
    if near is not None:
        boxes = [box for box, _ in starts if np.all((box[0] <= near.shapes) & (near.shapes <= box[1]))]
        starts = [(box, near.shapes) for box in boxes[:1]] or starts
    tried = [_search(model, data, box, start, (spec.stable, 12)) for box, start in starts]
    order = np.argsort([solution.objective for solution, _ in tried])[:_GOOD_STARTS]
    ends = [_search(model, data, starts[at][0], tried[at][1], (spec.stable, 2000)) for at in order.tolist()]
    return min((solution for solution, _ in ends), key=lambda solution: solution.objective)


def _search(
    model: Model, data: _Data, box: FloatArray, start: FloatArray, how: tuple[bool, int]
) -> tuple[_Solution, FloatArray]:
    stable, evaluations = how

    def solve(shapes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        A, b = _weighted(model, data, shapes)
        signs = model.signs(shapes) if stable else None
        c = solve_signed(A, b, signs)
        return A, c, A @ c - b

    def slope(shapes: FloatArray) -> FloatArray:
        A, c, _ = solve(shapes)
        moved = model.term_slopes(data.principal, shapes) * c * data.root[:, None]
        used = A[:, c != 0]
        q, _ = np.linalg.qr(used / lengths(used))
        return np.asarray(moved - q @ (q.T @ moved))

    inside = np.clip(start, box[0] + 1e-9 * np.ptp(box, axis=0), box[1] - 1e-9 * np.ptp(box, axis=0))
    found = least_squares(
        lambda shapes: solve(shapes)[2],
        inside,
        slope,
        bounds=(box[0], box[1]),
        x_scale=np.abs(inside),
        max_nfev=evaluations,
        **dict.fromkeys(("ftol", "xtol", "gtol"), 1e-14 if evaluations > 100 else 1e-6),
    )
    _, c, rest = solve(found.x)
    at_bound = np.any(np.abs(found.x - box) < _AT_BOUND * np.abs(box)) or bool(np.any(c == 0))
    return _Solution(c, found.x, float(rest @ rest), bool(at_bound)), found.x


def _jacobian(model: Model, data: _Data, solution: _Solution) -> FloatArray:
    """Weighted sensitivity (n, p) of the nominal stress to every constant."""
    terms = model.terms(data.principal, solution.shapes)
    slopes = model.term_slopes(data.principal, solution.shapes) * (solution.linear if len(solution.shapes) else 1.0)
    return np.asarray(np.hstack([terms, slopes]) * data.root[:, None])


def _condition(jacobian: FloatArray) -> float:
    return float(np.linalg.cond(jacobian / lengths(jacobian))) if jacobian.any(axis=0).all() else float("inf")


def _intervals(jacobian: FloatArray, solution: _Solution, confidence: float) -> FloatArray:
    """Confidence intervals (p, 2) of least squares, with Student's distribution of the residuals."""
    values = np.concatenate([solution.linear, solution.shapes])
    free = len(jacobian) - len(values)
    length = lengths(jacobian)
    if solution.held or not jacobian.any(axis=0).all():
        return np.full((len(values), 2), np.nan)
    _, s, vt = np.linalg.svd(jacobian / length, full_matrices=False)
    if s[-1] < 1e-13 * s[0]:
        return np.full((len(values), 2), np.nan)
    deviation = np.sqrt(solution.objective / free) * np.linalg.norm(vt.T / s, axis=1) / length
    half = stdtrit(free, 0.5 + 0.5 * confidence) * deviation
    return np.column_stack([values - half, values + half])


def _aicc(objective: float, rows: int, constants: int) -> float:
    """Akaike's criterion of normal residuals, with the variance as a constant (Burnham & Anderson 2002)."""
    k = constants + 1
    if rows - k - 1 <= 0:
        return float("inf")
    return float(rows * np.log(max(objective, 1e-300) / rows) + 2 * k + 2 * k * (k + 1) / (rows - k - 1))
