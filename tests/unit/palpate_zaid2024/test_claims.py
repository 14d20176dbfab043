import json
import shutil
from dataclasses import fields, replace
from importlib import import_module

import pytest
from palpate_zaid2024 import Verdict, assess_claims, read_evidence
from palpate_zaid2024 import write_claims as write_page
from palpate_zaid2024.assess_claims import ASSESSMENTS
from palpate_zaid2024.assess_material import assess_law, assess_mesh
from palpate_zaid2024.claim import CLAIMS
from palpate_zaid2024.evidence import DESIGNS, Evidence

from errors import check_values, refused
from palpate.fea import MeshResult
from palpate.study import SpecificationGrid, evaluate_grid, write_grid
from results import FIRST, PAPER, leave_out_pictures

PAGES = import_module("palpate_zaid2024.write_claims")
MESH_COLUMNS = ",".join(one.name for one in fields(MeshResult))
HOLDS, FAILS, OPEN = Verdict.HOLDS, Verdict.FAILS, Verdict.UNDECIDED
WHOLE = evaluate_grid(PAPER)


def error(h, t, m):
    """As the paper says: falls with markers, rises with thickness, least at 20 mm, and least of all at H20 T2 169."""
    best = 0.03 * ((h, t, m) == (20, 2, 169))
    return {7: 0.9, 37: 0.4, 91: 0.17, 169: 0.15}[m] + 0.01 * t + 0.1 * (h != 20) - best


def travel(h, t, m):
    rise = 0.0 if h == 10 else {1: 0.0, 2: 0.5, 3: 0.6, 4: 0.65}[t]
    return 1.2 + 0.01 * m**0.5 - 0.3 * (m == 7) + rise + 0.3 * (h == 20)


PRINTED = {
    "rmse_deg": error,
    "rmse_jitter_deg": lambda h, t, m: 2 * error(h, t, m),
    "max_error_deg": lambda h, t, m: 2.5 * error(h, t, m),
    "max_error_jitter_deg": lambda h, t, m: 9 * error(h, t, m),
    "travel_mm": travel,
    "peak_stress_straight_mpa": lambda h, t, m: 1.0 / h,
    "displacement_max_mm": lambda h, t, m: 9.0 if h == 20 else 8.0,
    "displacement_mean_straight_mm": lambda h, t, m: 4.0 if h == 20 else 3.0,
    "apex_gap_mm": lambda h, t, m: 0.01 if t > 1 else 4.0,
}


def ends(h, t):
    return {0: "flat", 6: "flat", 12: "inverted" if t == 1 else "flat"}


def grid(changes=PRINTED, keep=lambda h, t, m: True, branches=ends):
    """A grid of the 48 designs with some columns computed from height, thickness and markers."""
    rows, presses = [], []
    for row in WHOLE.designs:
        design = (int(row["height_mm"]), int(row["thickness_mm"]), row["markers"])
        if keep(*design):
            ended = branches(*design[:2])
            presses += [{"design": len(rows), "tilt_deg": tilt, "branch": ended[tilt]} for tilt in ended]
            rows.append({**row, **{name: value(*design) for name, value in {**PRINTED, **changes}.items()}})
    return Evidence(SpecificationGrid(tuple(rows), presses=tuple(presses)), "results/made-up")


def verdict(claim, evidence):
    (found,) = (answer for answer in assess_claims([evidence]) if answer.claim.name == claim)
    return found.finding.verdict


def test_every_claim_but_that_of_the_real_sensor_is_answered():
    names = [answer.claim.name for answer in assess_claims([grid()])]
    assert names == list(CLAIMS) == [f"C{number}" for number in (*range(1, 13), 14)]


@pytest.mark.parametrize("claim", ASSESSMENTS)
def test_a_grid_as_the_paper_prints_it_confirms_every_claim(claim):
    assert verdict(claim, grid()) == HOLDS


CONTRARY = {
    "C3": {"peak_stress_straight_mpa": lambda h, t, m: 0.1 if h != 20 else 0.2},
    "C4": {"displacement_mean_straight_mm": lambda h, t, m: h / 10},
    "C5": {"apex_gap_mm": lambda h, t, m: 3.0},
    "C6": {"travel_mm": lambda h, t, m: travel(h, t, m) - (0.5 if (h, t, m) == (30, 4, 169) else 0.0)},
    "C7": {"travel_mm": lambda h, t, m: travel(h, t, m) + h / 10},
    "C8": {"travel_mm": lambda h, t, m: travel(h, t, m) + (0.2 * t if h == 10 else 0.0)},
    "C9": {"rmse_deg": lambda h, t, m: error(h, t, m) - (0.2 if m == 169 else 0.0)},
    "C10": {"rmse_deg": lambda h, t, m: error(h, t, m) - (0.2 if (h, t, m) == (30, 4, 169) else 0.0)},
    "C11": {"rmse_deg": lambda h, t, m: error(h, t, m) + h / 10},
    "C12": {"rmse_deg": lambda h, t, m: error(h, t, m) - 0.1 * t},
    "C14": {"max_error_deg": lambda h, t, m: 2.1},
}


@pytest.mark.parametrize("claim", ASSESSMENTS)
def test_a_grid_that_says_otherwise_refutes_it(claim):
    assert verdict(claim, grid(CONTRARY[claim])) == FAILS


@pytest.mark.parametrize(
    ("rmse", "greatest", "expected"), [(0.3, 0.8, HOLDS), (0.31, 0.8, FAILS), (0.3, 0.81, FAILS)]
)
def test_the_best_design_must_be_within_both_printed_figures(rmse, greatest, expected):
    changes = {
        "rmse_deg": lambda h, t, m: rmse if (h, t, m) == (20, 2, 169) else rmse + 0.1,
        "max_error_deg": lambda h, t, m: greatest,
    }
    assert verdict("C10", grid(changes)) == expected


@pytest.mark.parametrize("claim", ["C9", "C10", "C11", "C12", "C14"])
def test_built_units_stand_beside_and_do_not_decide(claim):
    built = {
        "built_rmse_deg": lambda h, t, m: 1 / error(h, t, m),
        "calibrated_rmse_deg": lambda h, t, m: error(h, t, m),
    }
    worst = {"built_p95_deg": lambda h, t, m: 3.0, "calibrated_p95_deg": lambda h, t, m: 0.1}
    (found,) = (one.finding for one in assess_claims([grid({**built, **worst})]) if one.claim.name == claim)
    assert found.verdict == HOLDS
    assert "built" in found.figures
    (without,) = (one.finding for one in assess_claims([grid()]) if one.claim.name == claim)
    assert (found.why != without.why) == (claim not in ("C10", "C14"))
    assert "built" not in without.figures


def test_what_twins_foresaw_stands_beside_the_first_grid(tmp_path, monkeypatch):
    """From the table of `palpate calibration predict`, in a folder without a grid; a broken one is refused."""
    leave_out_pictures(monkeypatch)
    (tmp_path / "built" / "twins").mkdir(parents=True)
    table = tmp_path / "built" / "twins" / "built.csv"
    rows = [f"{h},{t},{m},{known},{error(h, t, m)},1,0,0" for h, t, m in DESIGNS for known in (0, 5)]
    head = "height_mm,thickness_mm,markers,calibration_presses,rmse_deg,p95_deg,depth_rmse_mm,noise_deg"
    table.write_text("\n".join([head, *rows]))
    write_grid(tmp_path / "study", grid().grid)
    grids, _ = read_evidence([tmp_path / "built", tmp_path / "study"])
    assert len(grids) == 1
    assert grids[0].figures("calibrated_rmse_deg") == {design: pytest.approx(error(*design)) for design in DESIGNS}
    (found,) = (one.finding for one in assess_claims(grids) if one.claim.name == "C9")
    assert "built" in found.figures
    check_values(found.figures, 12)
    table.write_text("height_mm,markers\n20,7\n")
    with refused("units-table-unreadable", "built.csv"):
        read_evidence([tmp_path / "built", tmp_path / "study"])


def test_thin_domes_that_invert_at_gentle_angles_only_refute_it():
    gentle = grid(branches=lambda h, t: {0: "inverted" if t == 1 else "flat", 6: "flat", 12: "flat"})
    assert verdict("C5", gentle) == FAILS


def test_thick_domes_that_leave_the_wall_do_not_conform():
    assert verdict("C5", grid({"apex_gap_mm": lambda h, t, m: 3.0})) == FAILS


@pytest.mark.parametrize(("depth", "expected"), [(2.6, OPEN), (None, FAILS)])
def test_domes_that_stay_flat_are_open_only_where_they_could_invert(depth, expected):
    flat = {"bistable_from_mm": lambda h, t, m: depth if t == 1 else None}
    assert verdict("C5", grid(flat, branches=lambda h, t: {0: "flat", 12: "flat"})) == expected


@pytest.mark.parametrize("claim", ASSESSMENTS)
def test_a_grid_without_the_designs_is_not_decided_and_says_what_it_needs(claim):
    answers = assess_claims([grid(keep=lambda h, t, m: h == 30 and t == 4)])
    (found,) = (answer.finding for answer in answers if answer.claim.name == claim)
    assert found.verdict == OPEN
    assert found.figures == ""
    assert found.why.startswith("needs H")


def test_one_missing_design_of_48_is_named():
    answers = assess_claims([grid(keep=lambda h, t, m: (h, t, m) != (10, 3, 91))])
    needs = {answer.claim.name: answer.finding.why for answer in answers if answer.finding.verdict == OPEN}
    mesh = needs.pop("C2")
    check_values(mesh, "palpate design convergence")
    assert set(needs) == {"C6", "C7", "C8", "C9", "C10", "C11", "C12"}
    for missing in needs.values():
        check_values(missing, "H10 T3", 91)


def test_one_dome_refutes_what_is_claimed_of_every_dome():
    one = grid(CONTRARY["C6"], keep=lambda h, t, m: (h, t) == (30, 4))
    assert verdict("C6", one) == FAILS
    assert verdict("C6", grid(keep=lambda h, t, m: (h, t) == (30, 4))) == OPEN


def test_a_design_that_failed_is_missing_with_its_reason():
    failed = [
        replace(design, clean=None, jittered=None, failure="the lamp went out")
        if (design.design.skin.height, design.design.skin.thickness, len(design.design.layout)) == (20, 2, 169)
        else design
        for design in PAPER
    ]
    answers = assess_claims([Evidence(evaluate_grid(failed), "x")])
    (found,) = (answer.finding for answer in answers if answer.claim.name == "C14")
    check_values(found.why, "H20 T2", 169, "the lamp went out")


def test_without_a_grid_only_the_law_is_decided():
    answers = assess_claims([])
    assert {answer.claim.name for answer in answers if answer.finding.verdict != OPEN} == {"C1"}


def test_the_law_of_table_2_gives_the_stresses_that_its_closed_form_gives():
    finding = assess_law()
    c10, c20, c30 = 0.0141156, 0.0001106, 0.0000048

    def nominal(stretch):
        i = stretch**2 + 2 / stretch - 3
        return 2 * (stretch - stretch**-2) * (c10 + 2 * c20 * i + 3 * c30 * i**2)

    check_values(finding.figures, f"{nominal(5.0):.4f} MPa", f"{-nominal(0.5):.4f} MPa")
    assert finding.verdict == HOLDS


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ({150: -0.2, 600: -0.06, 1200: -0.03, 2500: 0.0}, HOLDS),
        ({150: -0.2, 600: 0.04, 900: 0.0}, HOLDS),
        ({150: -0.2, 600: -0.06, 1300: -0.03, 2500: 0.0}, FAILS),
        ({150: -0.01, 600: -0.06, 1200: -0.3, 2500: 0.0}, FAILS),
        ({150: -0.2, 600: 0.06, 900: 0.0}, OPEN),
    ],
)
def test_a_mesh_is_fine_enough_only_where_all_finer_ones_agree(tmp_path, errors, expected):
    lines = [MESH_COLUMNS, *(f"8,{elements},9,8,0.1,0.2,{share},0,0,0,1" for elements, share in errors.items())]
    (tmp_path / "convergence.csv").write_text("\n".join(lines))
    assert assess_mesh(tmp_path / "convergence.csv").verdict == expected


def test_a_broken_mesh_study_is_refused(tmp_path):
    (tmp_path / "convergence.csv").write_text("elements,stress_error\n100,much\n")
    with refused("convergence-table-unreadable"):
        assess_mesh(tmp_path / "convergence.csv")


def test_each_contact_law_of_a_mesh_study_is_answered(tmp_path):
    for law in ("frictionless", "no_slip"):
        (tmp_path / f"convergence_{law}.csv").write_text(
            f"{MESH_COLUMNS}\n8,100,9,8,0.1,0.2,0.01,0,0,0,1\n9,200,9,8,0.1,0.2,0,0,0,0,1\n"
        )
    grids, meshes = read_evidence([tmp_path])
    answers = [answer for answer in assess_claims(grids, meshes) if answer.claim.name == "C2"]
    assert [answer.source for answer in answers] == ["mesh study, frictionless", "mesh study, no slip"]
    assert {answer.finding.verdict for answer in answers} == {HOLDS}


def with_spec(contact, preset):
    spec = json.dumps({"obstacle": {"contact": contact}, "learning": {"preset": preset}})
    return replace(WHOLE, designs=tuple({**row, "spec": spec} for row in WHOLE.designs))


def test_two_contact_laws_are_answered_side_by_side(tmp_path, monkeypatch):
    leave_out_pictures(monkeypatch)
    for contact in ("no-slip", "frictionless"):
        write_grid(tmp_path / contact, with_spec(contact, "best"))
    grids, meshes = read_evidence([tmp_path / "no-slip", tmp_path / "frictionless"])
    answers = assess_claims(grids, meshes)
    assert [answer.source for answer in answers if answer.claim.name == "C12"] == [
        "no-slip, best",
        "frictionless, best",
    ]


def test_a_folder_without_a_grid_is_refused(tmp_path):
    with refused("grid-missing", "grid.json"):
        read_evidence([tmp_path])


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Pictures of some designs of the grid below, drawn once: both pages show the same ones."""
    some = grid(CONTRARY["C12"], lambda h, t, m: t < 3 and m in (7, 169))
    return PAGES._write_pictures(tmp_path_factory.mktemp("drawn"), [some])


@pytest.mark.parametrize("ending", ["md", "html"])
def test_the_page_tells_every_verdict_with_its_command_and_pictures(tmp_path, monkeypatch, drawn, ending):
    def put(folder, grids):
        assert [one.grid for one in grids] == [evidence.grid]
        shutil.copytree(next(iter(drawn.values())).parent, folder)
        return {place: folder / path.name for place, path in drawn.items()}

    monkeypatch.setattr(PAGES, "_write_pictures", put)
    evidence = grid(CONTRARY["C12"])
    answers = assess_claims([evidence])
    page, *pictures = write_page(tmp_path / f"claims.{ending}", answers, [evidence], "palpate claims results/made-up")
    text = page.read_text()
    assert "palpate claims results/made-up" in text
    assert text.count(str(FAILS)) >= 2
    assert all(f"claims/{picture.name}" in text for picture in pictures)
    assert {picture.parent.name for picture in pictures} == {"claims"}
    assert all(picture.stat().st_size > 1000 for picture in pictures)
    rows = (
        [line for line in text.splitlines() if line.startswith("| C")] if ending == "md" else text.split("<tr>")[2:]
    )
    assert len(rows) == len(answers) == 13
    for row, answer in zip(rows, answers, strict=True):
        assert answer.claim.name in row
        assert str(answer.finding.verdict) in row


def test_designs_are_the_papers_48():
    assert len(DESIGNS) == len(set(DESIGNS)) == len(PAPER) == 48
    assert len(Evidence(evaluate_grid(FIRST), "x").rows) == 8


def test_another_ending_is_refused(tmp_path):
    with refused("file-ending-unknown", ".md", ".html"):
        write_page(tmp_path / "claims.txt", (), (), "")
