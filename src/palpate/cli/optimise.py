"""`palpate search`: from requirements to the designs that meet them best."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.output import RESULTS, Output
from palpate.cli.progress import show_progress
from palpate.cli.run import ClusterFlags
from palpate.core import PalpateError, load_extra
from palpate.core.report import Report

if TYPE_CHECKING:
    from palpate.optimise import RequirementsSpec

_PROVE = (
    "Play winner and rivals on the bench, read by their twins, or by trained networks as well; without it, as the "
    "requirements say."
)


@Parameter(name="*")
@dataclass(frozen=True)
class SearchFlags:
    """How it is searched, and what is done with what was found."""

    skins: Annotated[int | None, Parameter(help="Skins that are tried; without it, as the requirements say.")] = None
    sampler: Annotated[
        Literal["gp", "random"], Parameter(help="Who proposes skins: a Gaussian process, or chance as a control.")
    ] = "gp"
    random_skins: Annotated[
        int | None, Parameter(help="Skins drawn by chance beside it, which the report holds it against.")
    ] = None
    validate: Annotated[Literal["none", "simulated", "trained"] | None, Parameter(help=_PROVE)] = None
    packs: Annotated[bool, Parameter(negative="", help="Write a fabrication pack of every design of the front.")] = (
        False
    )

    def change(self, spec: RequirementsSpec) -> RequirementsSpec:
        """The requirements with what flags say of them."""
        if self.skins is not None and not 1 <= self.skins <= 100_000:
            raise PalpateError(f"--skins is {self.skins}.", "Give 1 to 100000.", code="option-out-of-bounds")
        if self.random_skins is not None and not 0 <= self.random_skins <= 100_000:
            raise PalpateError(
                f"--random-skins is {self.random_skins}.", "Give 0 to 100000.", code="option-out-of-bounds"
            )
        given = {"skins": self.skins, "validation": self.validate, "random_skins": self.random_skins}
        return spec.model_copy(update={name: value for name, value in given.items() if value is not None})

    def words(self) -> list[str]:
        """The flags as they are typed."""
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
    requirements: Annotated[str, Parameter(help="YAML file of the requirements, or paper_task, the paper's.")],
    *,
    out: Annotated[
        Path | None, Parameter(name=("--out", "-o"), help="Result folder; without it, results/NAME.")
    ] = None,
    search: SearchFlags = SearchFlags(),
    worker_flags: ClusterFlags = ClusterFlags(),
    output: Output = Output(),
) -> int:
    """Search for the sensor that reads best when built, under the limits of a YAML file.

    Skins are proposed by a Gaussian process and pressed; rings of markers and the camera's distance are
    chosen on each by exchange; what counts is the error of built units over the tolerances. With --validate the
    winner and its rivals are played on the bench. The same command goes on where it was stopped.
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
        load_extra("build123d", "cad")  # now, not after hours
    folder = keep_results(out or RESULTS / spec.name)
    command = shlex.join(["palpate", "search", requirements, "--out", str(folder), *search.words()])
    workers, cluster = worker_flags.workers, worker_flags.cluster or ""
    with show_progress() as progress:
        front = optimise_design(spec, folder, workers, progress, sampler=search.sampler, cluster=cluster)
        write_front(folder, front, command)  # a proof takes hours, and what was found does not wait for it
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
