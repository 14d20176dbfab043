"""Fit a silicone to a noisy tension test, and see what the fit does not know."""

import numpy as np

from palpate.material import FitSpec, Loading, Mode, Sample, fit_material, get_material, trace_curve


def main() -> float:
    true, rng = get_material("zaid_2024_ecoflex_00_30"), np.random.default_rng(0)
    samples = []
    for loading, stretch in (
        (Loading.TENSION, np.linspace(1, 2, 30)),
        (Loading.COMPRESSION, np.linspace(1, 0.6, 30)),
    ):
        nominal = trace_curve(true, Mode.UNIAXIAL, stretch).nominal
        samples.append(Sample(loading.value, loading, stretch, nominal + rng.normal(0, 2e-4, len(stretch))))
    fit = fit_material(samples, FitSpec(model="yeoh"))
    for name, value, (low, high) in zip(["C10", "C20", "C30"], fit.linear, fit.intervals, strict=True):
        print(f"{name} = {value:+.6f} MPa, 95 % between {low:+.6f} and {high:+.6f}")
    print(f"initial shear modulus {1000 * 2 * fit.linear[0]:.2f} kPa")
    return float(2 * fit.linear[0])


if __name__ == "__main__":
    main()
