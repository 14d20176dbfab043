"""A search for tests: real journal and front of skins whose figures are made up."""

from collections.abc import Sequence
from pathlib import Path

from palpate.calibration import PredictedAccuracy
from palpate.design import MarkerSpec, SkinSpec
from palpate.optimise import (
    Evaluation,
    Front,
    LayoutOption,
    RequirementsSpec,
    SearchPlan,
    SkinEvaluation,
    SkinSpace,
    SkinTrial,
    search_skins,
    write_front,
)
from palpate.optimise.optimise_design import JOURNAL, _keep, constraint_violations
from palpate.optimise.space import Place

SPEC = RequirementsSpec(
    name="small_search", objectives=("error", "force", "markers"), force_n=0.9, skins=8, depth=6.0, markers=37
)
RINGS = {7: (20.0,), 19: (10.0, 20.0), 37: (10.0, 20.0, 27.0)}
MATERIAL = "zaid_2024_ecoflex_00_30"


def propose(place: Place) -> SkinEvaluation:
    return evaluation_of(SkinSpace.of(SPEC).skin(place))


def evaluation_of(skin: SkinSpec) -> SkinEvaluation:
    """Thick skins are stiff, and more dots read better."""
    options = tuple(
        LayoutOption(
            MarkerSpec(ring_diameters=rings, diameter=1.2),
            "davis346",
            44.0,
            0.0,
            PredictedAccuracy(5, 0.6 / count, 2.0 / count + 0.01 * skin.height / 20.0, 0.01, 0.3 / count),
        )
        for count, rings in RINGS.items()
    )
    return SkinEvaluation(skin, MATERIAL, 6.0, 0.3 * skin.thickness, None, options)


def judge(places: Sequence[Place]) -> list[Evaluation]:
    found = [propose(place) for place in places]
    return [
        Evaluation((one.options[-1].accuracy.p95_deg,), constraint_violations(SPEC, one), {"proposal": one.to_data()})
        for one in found
    ]


def write_search(folder: Path, *, finished: bool) -> Front:
    """Write a search of eight skins, chosen by chance, into a folder; one that is not finished has no front."""
    _keep(SPEC, "random", folder)
    tried = search_skins(SkinSpace.of(SPEC), judge, SearchPlan(SPEC.skins, 3, "random"), folder / JOURNAL)
    front = Front(
        SPEC,
        tuple(
            SkinTrial(
                one.number, SkinEvaluation.from_data(one.evaluation.record["proposal"]), one.evaluation.violations
            )
            for one in tried
        ),
    )
    if finished:
        write_front(folder, front, "palpate search small.yaml")
    return front
