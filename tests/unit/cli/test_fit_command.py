"""`palpate material fit` and `palpate material`."""

import json
from pathlib import Path

import numpy as np
import pytest

from errors import check_refusal, check_values
from palpate.cli import main
from palpate.material import Loading, get_material, list_materials, read_material, trace_curve

DATA = Path(__file__).parents[1] / "material" / "data"
ECOFLEX = DATA / "marechal_2020" / "Ecoflex 00-30.csv"
MEUNIER = DATA / "meunier_2008"


def call(*words: str | Path) -> int:
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    assert isinstance(left.value.code, int)
    return left.value.code


def run_fit(capsys: pytest.CaptureFixture[str], *words: str | Path) -> dict:
    assert call("material", "fit", *words, "--json") == 0
    return json.loads(capsys.readouterr().out)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Five samples each of tension and compression of the paper's silicone, a few per cent apart, as Zwick writes."""
    folder, rng = tmp_path_factory.mktemp("bench"), np.random.default_rng(4)
    paper = get_material("zaid_2024_ecoflex_00_30")
    for loading, strain in (
        (Loading.TENSION, np.linspace(0, 4, 300)),
        (Loading.COMPRESSION, np.linspace(0, 0.5, 80)),
    ):
        sign = 1 if loading is Loading.TENSION else -1
        exact = sign * trace_curve(paper, loading.mode, 1 + sign * strain).nominal
        for number in range(5):
            stress = exact * (1 + 0.04 * rng.normal()) + 2e-4 * rng.normal(size=len(exact))
            lines = [f"Probe {number + 1}", "Dehnung;Spannung", "%;kPa"]
            lines += [f"{100 * a:.4f};{1e3 * b:.5f}".replace(".", ",") for a, b in zip(strain, stress, strict=True)]
            (folder / f"{loading}_{number + 1}.csv").write_text("\r\n".join(lines), "latin-1")
    return folder


def test_ten_files_of_a_bench_give_the_material_its_limits_and_the_picture(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figure = tmp_path / "mine.yaml", tmp_path / "fit.png"
    assert (
        call("material", "fit", *sorted(bench.glob("*.csv")), "--model", "yeoh", "-o", out, "--figure", figure) == 0
    )
    shown = capsys.readouterr().out
    for text in (
        "tension_5.csv",
        "C30",
        "95 %",
        "R²",
        "AICc",
    ):
        assert text in shown
    assert figure.read_bytes().startswith(b"\x89PNG")
    material = read_material(out)
    paper = get_material("zaid_2024_ecoflex_00_30")
    assert material.law.shear_modulus == pytest.approx(paper.law.shear_modulus, rel=0.08)
    assert material.stretch_range == pytest.approx((0.5, 5.0), rel=0.01)
    assert material.name == "mine"
    assert "tension_1.csv" in material.source


def test_json_holds_what_the_tables_show(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shown = run_fit(capsys, *sorted(bench.glob("*.csv")))
    assert [item["name"] for item in shown["constants"]] == ["C10", "C20", "C30"]
    assert all(item["low"] < item["value"] < item["high"] for item in shown["constants"])
    assert len(shown["samples"]) == 10
    assert {item["mode"] for item in shown["unseen"]} == {"equibiaxial", "planar"}
    assert len(shown["ranking"]) == 10
    yeoh = next(item for item in shown["ranking"] if item["model"] == "yeoh")
    assert 0.005 < yeoh["left_out"] < 0.1
    assert shown["files"] == []


def test_an_unstable_fit_is_warned_of_and_the_stable_one_offered(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("material", "fit", ECOFLEX, "--max-stretch", "5", "--alone") == 0
    shown = capsys.readouterr().out
    assert "-3.6" in shown
    check_values(shown, "Drucker", 11.68, "--stable")
    assert "C10 0.00796" in shown


def test_the_stable_fit_has_no_warning_and_no_interval(capsys: pytest.CaptureFixture[str]) -> None:
    shown = run_fit(capsys, ECOFLEX, "--max-stretch", "5", "--alone", "--stable")
    assert shown["stable"]
    assert shown["stable_fit"] is None
    assert shown["constants"][0]["low"] is None
    held, secant = shown["warnings"]
    assert held
    check_values(secant, "10 %")


def test_an_unstable_material_is_written_with_its_caution(tmp_path: Path) -> None:
    out = tmp_path / "soft.yaml"
    assert call("material", "fit", ECOFLEX, "--max-stretch", "5", "--alone", "-o", out) == 0
    check_values(read_material(out).caution, 11.68)


def test_files_are_given_to_their_test(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns = ("--strain", "2", "--strain-unit", "stretch", "--stress", "1", "--stress-unit", "MPa")
    files = ("--uniaxial", MEUNIER / "UT_stress_stretch.txt", "--planar", MEUNIER / "PS_stress_stretch.txt")
    picture = tmp_path / "fit.svg"
    shown = run_fit(capsys, *files, *columns, "--figure", picture)
    assert [item["test"] for item in shown["samples"]] == ["uniaxial", "planar"]
    assert [item["mode"] for item in shown["unseen"]] == ["equibiaxial"]
    assert "<svg" in picture.read_text()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), ("argument-missing",)),
        (("nowhere.csv",), ("file-unreadable", "nowhere.csv")),
        ((ECOFLEX, "--model", "rubber"), ("law-unknown", "rubber")),
        ((ECOFLEX, "--weighting", "heavy"), ("enum", "--weighting", "heavy")),
        ((ECOFLEX, "--strain-unit", "inch"), ("enum", "--strain-unit", "inch")),
        ((ECOFLEX, "--toe", "yes"), ("literal_error", "--toe", "yes")),
        ((ECOFLEX, "--confidence", "95"), ("less_than", "--confidence", 95)),
        ((ECOFLEX, "--figure", "fit.bmp"), ("file-ending-unknown", "fit.bmp", ".png")),
        ((ECOFLEX, "--figure", "no/folder/fit.png"), ("file-unwritable", "fit.png")),
        ((ECOFLEX, "-o", "no/folder/mine.yaml"), ("file-unwritable", "mine.yaml")),
        ((ECOFLEX, "--model", "mooney-rivlin", "-o", "mine.yaml"), ("shear-modulus-not-positive",)),
        ((ECOFLEX, "--colour", "red"), ("usage", "--colour")),
    ],
)
def test_what_cannot_be_done_is_refused_with_2(
    words: tuple[str | Path, ...],
    says: tuple[object, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert call("material", "fit", *words, *(() if "--alone" in words or not words else ("--alone",))) == 2
    shown = capsys.readouterr()
    check_refusal(shown.err, *says)
    assert "Traceback" not in shown.err


def test_the_library_is_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("material", "list", "--json") == 0
    shown = json.loads(capsys.readouterr().out)["rows"]
    assert [item["name"] for item in shown] == list(list_materials())
    assert all(item["stable"] for item in shown)
    assert call("material", "list") == 0
    assert "meunier_2008_silicone" in capsys.readouterr().out


def test_a_material_is_shown_with_its_pedigree(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("material", "show", "marechal_2020_ecoflex_00_30") == 0
    shown = capsys.readouterr().out
    for text in ("C30", "Open Database License", "crosshead travel", "E 47.79 kPa", "Drucker-stable: yes"):
        assert text in shown
    assert call("material", "show", "yeoh:0.1,-0.01,0", "--json") == 0
    assert json.loads(capsys.readouterr().out)["stable"] is False
    assert call("material", "show", "cheese") == 2


HELD = DATA / "springer_2022" / "relax_master.csv"


def test_a_relaxation_is_known_by_its_name_and_joins_the_law(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, figure = tmp_path / "mine.yaml", tmp_path / "fit.png"
    facts = run_fit(capsys, HELD, "--tension", ECOFLEX, "--alone", "-o", out, "--figure", figure)
    assert facts["model"] == "yeoh"
    found = facts["relaxation"]
    assert found["greatest"] < 0.0025
    assert len(found["terms"]) == 5
    assert found["moduli"] == "long-term"
    assert [item["time_s"] for item in found["left"]][1:-1] == [0.01, 0.1, 1.0, 10.0, 100.0]
    assert figure.is_file()
    assert (tmp_path / "fit_relaxation.png").is_file()
    material = read_material(out)
    assert material.relaxation is not None
    assert material.relaxation.times == pytest.approx([term["time_s"] for term in found["terms"]])
    check_values(material.quality, "0.00282…287 s", "0.15 %")
    assert call("material", "show", out) == 0
    check_values(capsys.readouterr().out, "long-term", "0.05527", "0.01491 s")


def test_a_relaxation_alone_is_put_beside_the_law_of_another_material(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    plain = get_material("zaid_2024_ecoflex_00_30")
    words = ("fit", HELD, "--moduli", "instantaneous", "-o", "mine.yaml", "--figure", "fit.png")
    assert call(*words, "--onto", plain.name) == 0
    shown = capsys.readouterr().out
    for text in ("AICc", "0.15 %", "instantaneous"):
        assert text in shown
    material = read_material(tmp_path / "mine.yaml")
    assert material.law == plain.law
    assert material.name == "mine"
    assert (tmp_path / "fit.png").is_file()
    (tmp_path / "fit.png").unlink()
    assert call(*words) == 2
    check_refusal(capsys.readouterr().err, "relaxation-without-law", "--onto")
    assert not (tmp_path / "fit.png").exists()  # refused before anything is drawn
    assert call(*words, "--tension", ECOFLEX, "--onto", plain.name) == 2
    check_refusal(capsys.readouterr().err, "relaxation-onto-unused", "--onto", plain.name)
