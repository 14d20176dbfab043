"""`palpate search`: search for the designs that meet requirements best."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.output import RESULTS, OutFlag, Output
from palpate.cli.progress import show_progress
from palpate.cli.run import ClusterFlags
from palpate.core import PalpateError, load_extra
from palpate.core.report import Report

if TYPE_CHECKING:
    from palpate.optimise import RequirementsSpec

_PROVE = (
    "Simulate winner, finalists and baselines on the test bench: with twins as estimators (simulated), or with "
    "trained networks as well (trained). Default: see the requirements."
)


@Parameter(name="*")
@dataclass(frozen=True)
class SearchFlags:
    """Settings of the search, its validation and its output."""

    skins: Annotated[int | None, Parameter(help="Number of skins to evaluate; default: see the requirements.")] = None
    sampler: Annotated[
        Literal["gp", "random"],
        Parameter(help="Sampler of skins: a Gaussian process (gp), or random search (random)."),
    ] = "gp"
    random_skins: Annotated[
        int | None, Parameter(help="Number of randomly drawn skins that the search is compared with.")
    ] = None
    validate: Annotated[Literal["none", "simulated", "trained"] | None, Parameter(help=_PROVE)] = None
    packs: Annotated[
        bool, Parameter(negative="", help="Write a fabrication pack of every design on the Pareto front.")
    ] = False

    def change(self, spec: RequirementsSpec) -> RequirementsSpec:
        """Return the requirements with the values of the given flags."""
        if self.skins is not None and not 1 <= self.skins <= 100_000:
            raise PalpateError(f"--skins is {self.skins}.", "Give 1 to 100000.", code="option-out-of-bounds")
        if self.random_skins is not None and not 0 <= self.random_skins <= 100_000:
            raise PalpateError(
                f"--random-skins is {self.random_skins}.", "Give 0 to 100000.", code="option-out-of-bounds"
            )
        given = {"skins": self.skins, "validation": self.validate, "random_skins": self.random_skins}
        return spec.model_copy(update={name: value for name, value in given.items() if value is not None})

    def words(self) -> list[str]:
        """Return the given flags as command-line words."""
        sampler = None if self.sampler == "gp" else self.sampler
        given = {
            "--skins": self.skins,
            "--sampler": sampler,
            "--random-skins": self.random_skins,
            "--validate": self.validate,
        }
        words = [word for flag, value in given.items() if value is not None for word in (flag, str(value))]
        return [*words, "--packs"] if self.packs else words


def optimise(
    requirements: Annotated[
        str, Parameter(help="YAML file of the requirements, or paper_task: the task of the paper.")
    ],
    *,
    out: OutFlag = None,
    search: SearchFlags = SearchFlags(),
    worker_flags: ClusterFlags = ClusterFlags(),
    output: Output = Output(),
) -> int:
    """Search for the design with the best objectives, such as the error of built units, under constraints.

    A Gaussian process proposes skins, which are pressed in simulation. Marker rings and camera distance are optimised
    by exchange on each skin. The error is predicted over the manufacturing tolerances. With --validate, the
    winner and its baselines are simulated on the test bench. The same command resumes an interrupted search.
    """
    from palpate.optimise import (
        FRONT_COLUMNS,
        describe_front,
        optimise_design,
        read_requirements,
        validate_front,
        write_front,
        write_packs,
    )

    worker_flags.check()
    spec = search.change(read_requirements(requirements))
    if search.packs:
        load_extra("build123d", "cad")  # before the search, which takes hours
    folder = keep_results(out or RESULTS / spec.name)
    command = shlex.join(["palpate", "search", requirements, "--out", str(folder), *search.words()])
    workers, cluster = worker_flags.workers, worker_flags.cluster or ""
    with show_progress() as progress:
        front = optimise_design(spec, folder, workers, progress, sampler=search.sampler, cluster=cluster)
        write_front(folder, front, command)  # before the validation, which takes hours
        front = validate_front(front, folder, workers, progress, cluster)
    if front.validation is not None:
        write_front(folder, front, command)
    if search.packs:
        write_packs(folder, front)
    told = describe_front(front)
    output.show(
        {"out": str(folder), **told},
        Report(f"{spec.name}: front", FRONT_COLUMNS, told["front"], file=str(folder / "front.csv")),
        front.shortfall or "The requirements are met.",
        f"Report: {folder / 'report.md'}",
    )
    return 1 if front.shortfall else 0
