"""Run cases and write the pages of the documentation.

In the folder `tests`: `python -m validation ../docs [NAME…]`. Without names all cases run. A name may contain `*` and
`?`; the rows of other cases are kept.
"""

import sys
from fnmatch import fnmatch
from pathlib import Path

from palpate.verify import CASES, run_cases
from validation.cases import LONG_CASES, PUBLISHED_CASES
from validation.pages import write_pages, write_rows


def main(docs: Path, names: list[str]) -> None:
    """Run the cases, then write `results/verification.csv` and the pages in a documentation folder."""
    cases = [
        case for case in (*CASES, *LONG_CASES, *PUBLISHED_CASES) if any(fnmatch(case.name, name) for name in names)
    ]
    outcomes = []
    for outcome in run_cases(cases):
        outcomes.append(outcome)
        print(f"{outcome.case.name}: {'passed' if outcome.passed else 'FAILED'}, {outcome.cpu_s:.1f} CPU-seconds")
    write_rows(docs / "results" / "verification.csv", outcomes)
    write_pages(docs)


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:] or ["*"])
