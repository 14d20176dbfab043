"""Pages of the documentation: all cases, and one page per published experiment with source, model and verdict.

All pages are written from one file of rows, so that no number is written twice.
"""

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from palpate.core.report import Report, page_markdown
from palpate.verify import CaseOutcome, outcome_report

COLUMNS = ("case", "reference", "quantity", "values", "ours", "expected", "deviation", "tolerance", "pass", "cpu_s")
_HEAD = """# Verification

Problems with known solutions, solved by palpate. References marked *exact* are closed forms, quadratures or ordinary
differential equations. Codes are independent of the solver of palpate, except *finer mesh*. A *property* needs no
external number. The table has one row per case: the quantity that uses most of its tolerance. All quantities are in
`docs/results/verification.csv`. `palpate verify` runs 29 quick cases;
`python -m validation ../docs` in the folder `tests` runs all and writes these pages."""
_NOTES = """## Notes

* *Incompressible references* are solved at K/µ = 100 000. The default of 2000 alone lowers the pressure of a sphere
  inflated threefold by 0.4 %.
* *Hertz* is the limit of a small contact patch: the sphere between plates is about 0.28 a/R stiffer (2.0 % at d/R =
  0.005). The ratio extrapolated to a/R = 0 is a quantity of its own.
* *Shell between plates*: the reference is thin-shell theory, which differs from a solid by the order of h/R. At R/h
  = 20 the force deviates by 2 to 5 %, and its tolerance is 2 % + h/R. At R/h = 50 and 100 the tolerance is 2 %, as
  for the ratio extrapolated to h/R = 0.
* *Clamped caps*: digitised curves (AQUINAS-FE, BSD-3-Clause) of two codes that differ by up to 11 % of the load in
  steep parts. Points are compared by their distance from the computed curve, each axis divided by its maximum.
  Single figures are compared with the nearest value within the range of the codes.
* *Domes* use the default mesh and contact, except the thickest (two cells through the skin) and the pair compared
  with CalculiX, whose reference has a coarse mesh and soft contact.
* [Published experiments](published/index.md) have a page each, with source, reading error, mesh and control."""


@dataclass(frozen=True)
class Published:
    """What stands behind cases that repeat somebody's work.

    Attributes
    ----------
    page
        Name of the page.
    title
        Its title.
    cases
        Names of the cases.
    source
        Who, where, with DOI.
    read
        What was read from where, and its error.
    ours
        Mesh, law and loading of ours, and the figure of merit.
    control
        What must not pass, and does not.
    missing
        What could not be had, or is not compared.
    """

    page: str
    title: str
    cases: tuple[str, ...]
    source: str
    read: str
    ours: str
    control: str
    missing: str


PUBLISHED: tuple[Published, ...] = (
    Published(
        page="clamped_caps",
        title="Clamped caps under a ring, a force and a pressure",
        cases=("clamped_cap_ring", "clamped_cap_apex", "clamped_cap_snap", "clamped_cap_buckling"),
        source="J. G. Teng, J. M. Rotter, Computers & Structures 31, 211 and 32, 453 (1989); R. D. Wood, O. C. "
        "Zienkiewicz, Computers & Structures 7, 725 (1977); Budiansky; Dumir & Nath; Huang; all as in "
        "AQUINAS-FE (A. Filippidis, A. J. Sadowski, Imperial College London, 2023, BSD-3-Clause).",
        read="Curves as digitised there. The two codes differ by up to 11 % of the load on steep parts, "
        "which bounds the error of reading from above; buckling pressures are printed to three digits.",
        ours="A quarter of the cap, 28 cells along the meridian, one through the wall, clamped by its whole "
        "edge; neo-Hooke; arc length. Merit: distance of the points from our path, each axis over its "
        "maximum; limit loads and buckling pressures by the nearest within the range of the "
        "codes. Pressure keeps its direction.",
        control="A wall 5 % thicker misses the peak of the ring load.",
        missing="The measured caps of Kaplan & Fung (NACA TN 3212) and of Sunakawa & Ichida (ISAS report 39, 87, "
        "1974).",
    ),
    Published(
        page="hinged_roofs",
        title="Hinged roofs that snap through and back",
        cases=("hinged_roof_thick", "hinged_roof_thin"),
        source="The roof of A. B. Sabir and A. C. Lock (1972), as solved by Abaqus and printed by K. Y. Sze, "
        "X. H. Liu, S. H. Lo, *Popular benchmark problems for geometric nonlinear analysis of shells*, "
        "Finite Elements in Analysis and Design 40, 1551–1569 (2004), doi 10.1016/j.finel.2003.11.001.",
        read="The table is printed, with the last digit rounded: at most 0.02 % of the maximum.",
        ours="A quarter, 10 x 10 cells, one through the wall, hinged on the line in the middle of the wall's "
        "edge; neo-Hooke of the same E and nu; arc length past both limit points and, for the thin "
        "roof, both turns of the deflection. Merit: distance of the printed points from our path, and "
        "limit loads. On 6 x 6 cells the upper limit load of the thick roof is 0.7407 "
        "(0.7370 here, 0.7421 printed).",
        control="A wall 3 % thicker misses the upper limit loads by 5 and 7 %.",
        missing="Laminated roofs: palpate has no oriented laws.",
    ),
    Published(
        page="pulled_cylinder",
        title="A cylinder with free ends, pulled apart",
        cases=("pulled_cylinder",),
        source="K. Y. Sze, X. H. Liu, S. H. Lo, *Popular benchmark problems for geometric nonlinear analysis "
        "of shells*, Finite Elements in Analysis and Design 40, 1551–1569 (2004), doi "
        "10.1016/j.finel.2003.11.001 (Abaqus, 24 x 36 cells).",
        read="The table is printed, with the last digit rounded: at most 0.02 % of the maximum.",
        ours="An eighth, 24 x 8 cells, one through the wall (R/h = 53); neo-Hooke; a dead force in ten "
        "increments, through the snap between 0.50 and 0.525 of the load. Merit: three displacements.",
        control="A wall 3 % thicker deviates by 6 to 11 %.",
        missing="The pinched hemisphere with a hole of the same paper (R/h = 250).",
    ),
    Published(
        page="bistable_caps",
        title="When a cap stays inside out",
        cases=("bistable_cap",),
        source="M. Taffetani, X. Jiang, D. P. Holmes, D. Vella, *Static bistability of spherical caps*, Proc. "
        "R. Soc. A 474, 20170910 (2018), doi 10.1098/rspa.2017.0910, arXiv 1804.04219.",
        read="Its abstract: experiments and finite elements give the threshold between one stable state and "
        "two for caps of different solid angle; shallow-shell theory, appropriately modified, accounts "
        "very well for it even for relatively deep caps. It has no number, so the theory is "
        "solved (`validation.shallow`: two ordinary differential equations, by collocation): "
        "lambda = 5.743 at nu = 0.5 and 5.491 at 0.3.",
        ours="A quarter of the cap, 12 cells along the meridian (two layers at 1.1 rad, where h/R is 0.11), "
        "the rim free but for a slippery support; neo-Hooke, nu = 0.3 or K/mu = 2000; pushed through by "
        "arc length. A second state exists where the load in the valley is negative; the thickness of "
        "its zero is found by secants. Merit: lambda, formed with the angle from axis to rim in the "
        "place of the base radius over R, which is our way of carrying the theory to deep caps.",
        control="With a wall 5 % thicker, lambda deviates by 2.5 % (shallow) and 2.2 % (deep), outside the "
        "tolerances.",
        missing="The measured points and the paper's own modification of the theory.",
    ),
    Published(
        page="sphere_buckling",
        title="Buckling of spheres and of a clamped hemisphere",
        cases=("sphere_buckling",),
        source="R. Zoelly, thesis, Zürich 1915 (S. P. Timoshenko, J. M. Gere, *Theory of Elastic Stability*, "
        "2nd ed. 1961); U. K. Ubamanyu, Z. Baizhikova, J.-L. Le, R. Ballarini, P. M. Reis, *A numerical "
        "study on the buckling of near-perfect spherical shells*, arXiv 2412.15066 (2024).",
        read="Closed form; and from the abstract of the second, by finite elements: hemispheres buckle at "
        "their boundary, at a knock-down factor of 0.8, full spheres near 1. One digit: an error of "
        "0.05.",
        ours="An eighth of the sphere in one layer, 16 to 30 cells from pole to equator; nu = 0.3; dead "
        "pressure by arc length until a pivot turns negative. Merit: pressure over the classical one "
        "for R/h = 20, 40 and 80, within 1 % + h/R (a pressure that keeps its direction and a wall that "
        "is a solid are each stiffer by the order of h/R), and carried to h/R = 0; and for the "
        "hemisphere, R/h = 50, clamped at the equator.",
        control="A wall 5 % thicker deviates by 10 to 16 %.",
        missing="Measured knock-down factors (Lee et al. 2016, doi 10.1115/1.4034431; Carlson et al. 1967). Thick "
        "balls under outside pressure (Coupier, "
        "Djellouli & Quilliet 2019, arXiv 1909.07130, h/R up to 0.3) follow a pressure that turns with "
        "the wall, which palpate does not have.",
    ),
    Published(
        page="sphere_point",
        title="A force on a sphere",
        cases=("sphere_point",),
        source="E. Reissner, *Stresses and small displacements of shallow spherical shells*, J. Math. Phys. "
        "25, 80 and 279 (1946), doi 10.1002/sapm194625180.",
        read="Closed form: F = 4 E h² w / (R sqrt(3 (1 - nu²))).",
        ours="An eighth of the sphere, 30 cells from pole to equator, two within one thickness of the pole, "
        "over which the force is spread; nu = 0.3; deflection 0.002 h, the mean under the force. Merit: "
        "stiffness over Reissner's for R/h = 50, 100 and 200, and carried to h/R = 0. The spread makes "
        "it stiffer, shear softer; both vanish with h/R.",
        control="A wall 5 % thicker deviates by 10 %.",
        missing="Dimples far beyond it (Pogorelov) and their experiments (Lazarus, Florijn & Reis 2012, doi "
        "10.1103/PhysRevLett.109.144301; Vella et al. 2012, doi 10.1098/rsif.2011.0352). Spheres between "
        "plates, flat and inverted, are "
        "compared with a shell code instead (`shell_R*`).",
    ),
    Published(
        page="bonded_discs",
        title="Rubber discs bonded between plates",
        cases=("bonded_disc",),
        source="A. N. Gent, P. B. Lindley, *The compression of bonded rubber blocks*, Proc. Inst. Mech. Eng. "
        "173, 111–122 (1959), doi 10.1243/PIME_PROC_1959_173_022_02; J. M. Kelly, *Earthquake-Resistant "
        "Design with Rubber*, Springer, 2nd ed. 1997.",
        read="Gent & Lindley's relation for bonded blocks, Ea = E (1 + 2 S²) for discs, as quoted in "
        "Strojniški vestnik 60, 506 (2014), doi 10.5545/sv-jme.2013.1510; it superposes two states and "
        "is an approximation: ours differs by 1 to 4 % for S of 0.5 to 8, and by 7 % at 0.25. Kelly's "
        "is closed, for large S.",
        ours="A quarter of half the disc, 8 x 3 cells graded to the free edge; neo-Hooke at a strain of 0.1 "
        "%; K/mu = 100 000, and 2000. Merit: apparent modulus over E for S = 0.5 to 8 within 4 %, and "
        "for 4 to 16 with the bulk within 2 %.",
        control="Slippery plates give E within 0.1 % at every S.",
        missing="The measured points; a fingerpad on a plate; Tatara's rubber sphere (1991, doi "
        "10.1115/1.2903407). A sphere between plates is compared with Hertz and an axisymmetric code instead.",
    ),
)
"""Pages, in their order."""


def read_rows(path: Path) -> list[dict[str, str]]:
    """Read the rows of all cases."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def write_rows(path: Path, outcomes: Sequence[CaseOutcome]) -> None:
    """Write the rows of cases, with the CPU time of their case, in place of their rows in the file."""
    seconds = {outcome.case.name: f"{outcome.cpu_s:.1f}" for outcome in outcomes}
    before = read_rows(path) if path.exists() else []
    order = [row["case"] for row in before] + list(seconds)
    found = [{**row, "cpu_s": seconds[str(row["case"])]} for row in outcome_report(outcomes).rows]
    rows = [row for row in before if row["case"] not in seconds] + found
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: order.index(str(row["case"]))))


def verification_page(rows: Sequence[dict[str, str]]) -> str:
    """Write the page of all cases: of each, the row that uses most of its tolerance."""
    cases: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        cases.setdefault(row["case"], []).append(row)
    lines = []
    for name, own in cases.items():
        nearest = max(own, key=lambda row: _number(row["deviation"]) / max(_number(row["tolerance"]), 1e-300))
        verdict = "yes" if all(row["pass"] == "yes" for row in own) else "NO"
        lines.append(
            (name, own[0]["reference"], nearest["deviation"], nearest["tolerance"], own[0]["cpu_s"], verdict)
        )
    passed = sum(row["pass"] == "yes" for row in rows)
    seconds = sum(float(own[0]["cpu_s"]) for own in cases.values())
    table = Report.of("", ("case", "reference", "deviation", "tolerance", "CPU s", "pass"), lines)
    count = f"{passed} of {len(rows)} quantities of {len(cases)} cases pass, in {seconds:.0f} CPU-seconds."
    return page_markdown([_HEAD, count, table, _NOTES])


def _number(text: str) -> float:
    return float(text.removesuffix(" %")) / (100.0 if text.endswith("%") else 1.0)


def published_pages(rows: Sequence[dict[str, str]]) -> dict[str, str]:
    """Write the pages of published experiments, by name.

    Raises
    ------
    LookupError
        If a case has no row.
    """
    return {item.page: _page(item, rows) for item in PUBLISHED}


def _page(item: Published, rows: Sequence[dict[str, str]]) -> str:
    own = [row for row in rows if row["case"] in item.cases]
    if missing := set(item.cases) - {row["case"] for row in own}:
        raise LookupError(f"no row of {sorted(missing)}")
    failed = sum(row["pass"] != "yes" for row in own)
    verdict = f"All {len(own)} rows pass." if not failed else f"{failed} of {len(own)} rows do not pass."
    shown = ("quantity", "ours", "expected", "deviation", "tolerance", "pass")
    parts: list[str | Report] = [
        f"# {item.title}",
        f"**Source.** {item.source}",
        f"**Reading error.** {item.read}",
        f"**Model.** {item.ours}",
        Report.of("", shown, [[row[name] for name in shown] for row in own]),
        f"**Verdict.** {verdict}",
        f"**Control.** {item.control}",
        f"**Not compared.** {item.missing}",
    ]
    return page_markdown(parts)


def write_pages(docs: Path) -> None:
    """Write the pages of a documentation folder from its rows."""
    rows = read_rows(docs / "results" / "verification.csv")
    (docs / "verification.md").write_text(verification_page(rows), encoding="utf-8")
    for name, page in published_pages(rows).items():
        (docs / "published" / f"{name}.md").write_text(page, encoding="utf-8")
