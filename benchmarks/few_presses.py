"""Predicted accuracy of built units from six presses, compared with that from 56.

    python benchmarks/few_presses.py FOLDER 20x2 20x3 …

Each argument is a dome, HEIGHTxTHICKNESS in mm. Presses are kept in FOLDER: an interrupted run resumes.
"""

from __future__ import annotations

import sys
from pathlib import Path

from palpate.calibration import AccuracySpec, ToleranceSpec, predict_accuracy
from palpate.core import ArtefactStore, PalpateError
from palpate.design import MarkerSpec
from palpate.fea import Press, read_press
from palpate.study import DesignsSpec, PressTask, Study
from palpate.surrogate import build_twin, twin_derivatives

CONTACTS = ("no-slip", 2.0, 1.2, 1.0, 0.8, 0.5, 0.3, 0.2)
TILTS_DEG = (0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0)
FEW = [(contact, tilt) for contact in ("no-slip", 0.8) for tilt in (0.0, 8.0, 12.0)]


def press_dome(study: Study, store: ArtefactStore) -> dict[tuple[str | float, float], Press]:
    """The 56 presses of a study's skin, by contact law and tilt."""
    (skin,) = study.designs.skins()
    found = {}
    for contact in CONTACTS:
        for tilt in TILTS_DEG:
            obstacle = study.obstacle_at(tilt, contact=contact)
            names = twin_derivatives(filled=False, friction=obstacle.friction)
            solver = study.solver.model_copy(update={"derivatives": names})
            task = PressTask(design=study.design(skin), mesh=study.mesh, obstacle=obstacle, solver=solver)
            if store.find(task.recipe) is None:
                task.make(store)
            found[contact, tilt] = read_press(store.path(task.recipe))
    return found


def main(folder: Path, domes: list[str]) -> None:
    """Print RMSE and 95th percentile (degrees) before and after five calibration presses."""
    for name in domes:
        height, thickness = map(float, name.split("x"))
        study = Study(name="few", designs=DesignsSpec(heights=(height,), thicknesses=(thickness,)))
        presses = press_dome(study, ArtefactStore(folder))
        try:
            twins = [build_twin(list(presses.values())), build_twin([presses[place] for place in FEW])]
        except PalpateError as error:
            print(name, error)
            continue
        for count in (7, 169):
            design = study.design(study.designs.skins()[0], MarkerSpec(count=count))
            for label, twin in zip(("56 presses", " 6 presses"), twins, strict=True):
                figures = [
                    predict_accuracy(
                        twin, design.layout, design.camera, ToleranceSpec(), AccuracySpec(calibration_presses=n)
                    )
                    for n in (0, 5)
                ]
                values = " ".join(f"{value:.4f}" for each in figures for value in (each.rmse_deg, each.p95_deg))
                print(f"{name} {count:3} markers, {label}: {values}", flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
