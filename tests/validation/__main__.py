"""Run all cases and write the pages of the documentation: `python -m validation ../docs`, in the folder `tests`."""

import sys
from pathlib import Path

from palpate.verify import CASES, run_cases
from validation.cases import PUBLISHED_CASES
from validation.pages import write_pages, write_rows


def main(docs: Path) -> None:
    """Run the cases, then write `results/verification.csv` and the pages in a documentation folder."""
    outcomes = []
    for outcome in run_cases([*CASES, *PUBLISHED_CASES]):
        outcomes.append(outcome)
        print(f"{outcome.case.name}: {'passed' if outcome.passed else 'FAILED'}, {outcome.cpu_s:.1f} CPU-seconds")
    write_rows(docs / "results" / "verification.csv", outcomes)
    write_pages(docs)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
