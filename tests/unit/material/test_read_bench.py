"""Files of every bench are read rightly or refused with row, column and remedy; never a traceback, never slowly."""

import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from errors import refused
from palpate.cli import main
from palpate.core import PalpateError
from palpate.material import Loading, Sample, TestFileSpec, get_material, read_test_file, trace_curve

DATA = Path(__file__).parent / "data"
STRAIN = np.linspace(0.02, 2.0, 25)
STRESS = trace_curve(get_material("zaid_2024_ecoflex_00_30"), Loading.TENSION.mode, 1 + STRAIN).nominal


def write(path: Path, text: str | bytes) -> Path:
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def table(
    header: str = "Strain (mm/mm),Stress (MPa)",
    strain: np.ndarray = STRAIN,
    stress: np.ndarray = STRESS,
    *,
    delimiter: str = ",",
    decimal: str = ".",
) -> str:
    rows = [f"{a:.9g}{delimiter}{b:.9g}".replace(".", decimal) for a, b in zip(strain, stress, strict=True)]
    return "\n".join([header, *rows, ""])


def read(path: Path, **spec: object) -> Sample:
    (sample,) = read_test_file(path, TestFileSpec(**spec))
    return sample


def holds(sample: Sample, rel: float = 1e-6) -> bool:
    """Whether a sample is the curve that the files of these tests hold."""
    return sample.stretch == pytest.approx(1 + STRAIN, rel=rel) and sample.nominal == pytest.approx(STRESS, rel=rel)


ZWICK = "Zwick testXpert\r\nDehnung;Standardkraft\r\n%;N\r\n"
INSTRON = (
    '"Specimen label","A 1"\n"Width","6","mm"\n\n"Time","Tensile strain","Tensile stress"\n"(s)","(%)","(kPa)"\n'
)


def rows(strain: np.ndarray, stress: np.ndarray, form: str) -> str:
    return "".join(form.format(a=a, b=b) for a, b in zip(strain, stress, strict=True))


READ_RIGHTLY: dict[str, tuple[str | bytes, dict[str, object]]] = {
    "plain": (table(), {}),
    "per cent and kPa": (table("strain [%],stress [kPa]", 100 * STRAIN, 1e3 * STRESS), {}),
    "Pa without brackets": (table("strain,stress_Pa", STRAIN, 1e6 * STRESS), {}),
    "stretch": (table("stretch,stress (N/mm²)", 1 + STRAIN), {}),
    "semicolons and decimal commas": (table("Dehnung;Spannung (MPa)", delimiter=";", decimal=","), {}),
    "tabs and decimal commas": (table("Dehnung\tSpannung (MPa)", delimiter="\t", decimal=","), {}),
    "spaces": (table("strain stress_MPa", delimiter="  "), {}),
    "byte order mark": (b"\xef\xbb\xbf" + table().encode(), {}),
    "UTF-16": (table().encode("utf-16"), {}),
    "Latin-1": (table("Dehnung (mm/mm),Spannung (N/mm²)").encode("latin-1"), {}),
    "comments": ("# tension of sample 3\n" + table().replace("\n", "\n// pause\n", 3), {}),
    "header in a comment": ("# strain stress_MPa\n" + table("", delimiter=" ").lstrip(), {}),
    "carriage returns": (table().replace("\n", "\r"), {}),
    "trailing delimiters": (table(delimiter=";", header="strain;stress (MPa);").replace("\n", ";\n"), {}),
    "Zwick: force in N, per cent, a row of units": (
        ZWICK + rows(100 * STRAIN, 18 * STRESS, "{a:.9f};{b:.9f}\r\n").replace(".", ","),
        {"section": 18.0},
    ),
    "Instron: quotes, preamble, a row of units": (
        INSTRON + rows(100 * STRAIN, 1e3 * STRESS, '"0.1","{a:.9f}","{b:.9f}"\n'),
        {},
    ),
    "travel in mm": (table("Extension (mm),Load (N)", 33 * STRAIN, 18 * STRESS), {"gauge_length": 33, "section": 18}),
    "true strain and true stress": (
        table("e,s", np.log1p(STRAIN), STRESS * (1 + STRAIN)),
        {"strain": "e", "strain_unit": "log", "stress": "s", "stress_unit": "MPa", "true_stress": True},
    ),
    "no header, columns by number": (
        "\n".join(f"{b:.9f} {a:.9f}" for a, b in zip(1 + STRAIN, STRESS, strict=True)),
        {"strain": "2", "strain_unit": "stretch", "stress": "1", "stress_unit": "MPa"},
    ),
    "engineering beside true columns": (
        "Time (s),True Strain,True Stress (MPa),Engineering Strain,Engineering Stress (MPa)\n"
        + rows(STRAIN, STRESS, "0,9,9,{a:.9f},{b:.9f}\n"),
        {},
    ),
}


@pytest.mark.parametrize("case", READ_RIGHTLY)
def test_a_file_of_any_bench_is_read(case: str, tmp_path: Path) -> None:
    text, spec = READ_RIGHTLY[case]
    sample = read(write(tmp_path / "tension.csv", text), **spec)
    assert sample.loading is Loading.TENSION
    assert holds(sample)


@settings(max_examples=60, deadline=None)
@given(
    delimiter=st.sampled_from([";", "\t", " ", ","]),
    decimal=st.sampled_from([".", ","]),
    preamble=st.lists(st.sampled_from(["Operator;;", "Speed 500 mm/min", "# note", "", "Norm: ISO 37"]), max_size=4),
    newline=st.sampled_from(["\n", "\r\n"]),
    digits=st.integers(6, 12),
    extra=st.booleans(),
)
def test_whatever_the_bench_writes_is_read_back(
    delimiter: str,
    decimal: str,
    preamble: list[str],
    newline: str,
    digits: int,
    extra: bool,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    if delimiter == decimal:
        decimal = "."
    names = ["time_s", "strain", "stress_MPa"] if extra else ["strain", "stress_MPa"]
    lines = [*preamble, delimiter.join(names)]
    for at, (a, b) in enumerate(zip(STRAIN, STRESS, strict=True)):
        cells = [f"{value:.{digits}e}".replace(".", decimal) for value in ((0.1 * at, a, b) if extra else (a, b))]
        lines.append(delimiter.join(cells))
    path = tmp_path_factory.mktemp("bench") / "tension.csv"
    path.write_bytes(newline.join(lines).encode())
    assert holds(read(path), rel=1e-5)


MALFORMED: dict[str, tuple[str | bytes, dict[str, object], tuple[str, ...]]] = {
    "empty": ("", {}, ("table-empty",)),
    "only comments": ("# nothing\n# at all\n", {}, ("table-empty",)),
    "only a header": ("strain,stress (MPa)\n", {}, ("table-empty",)),
    "one row": ("strain,stress (MPa)\n0.1,0.2\n", {}, ("table-few-rows", "1")),
    "four rows": ("strain,stress (MPa)\n0.1,0.2\n0.2,0.3\n0.3,0.4\n0.4,0.5\n", {}, ("table-few-rows", "4")),
    "one column": ("stress (MPa)\n0.1\n0.2\n0.3\n0.4\n0.5\n0.6\n", {}, ("table-no-numbers",)),
    "text in numbers": (
        table().replace("\n", "\nslipped,0.1\n", 6).replace("slipped,0.1\n", "", 5),
        {},
        ("value-not-number", "row 7", "column 1", "slipped"),
    ),
    "text in the first row": (
        "strain,stress (MPa)\nn/a,0.1\n" + table("").lstrip(),
        {},
        ("value-not-number", "row 2", "column 1", "n/a"),
    ),
    "a unit in a cell": (
        table().replace("\n", "\n0.1,0.2 kPa\n", 3).replace("0.1,0.2 kPa\n", "", 2),
        {},
        ("value-not-number", "row 4", "column 2", "0.2 kPa"),
    ),
    "NaN": (
        table().replace("\n", "\nnan,0.1\n", 4).replace("nan,0.1\n", "", 3),
        {},
        ("value-not-number", "row 5", "column 1", "nan"),
    ),
    "infinity": (
        table().replace("\n", "\n0.1,inf\n", 4).replace("0.1,inf\n", "", 3),
        {},
        ("value-not-number", "row 5", "column 2", "inf"),
    ),
    "an empty cell": (
        table().replace("\n", "\n,0.1\n", 4).replace("\n,0.1", "", 3),
        {},
        ("cell-empty", "row 5", "column 1"),
    ),
    "a decimal comma with a comma as delimiter": (
        "strain,stress (MPa)\n" + rows(STRAIN, STRESS, "{a:.3f},{b:.5f}\n").replace(".", ","),
        {},
        ("header-length-wrong", "2", "row 2", "4"),
    ),
    "the wrong delimiter asked for": (table(), {"delimiter": "semicolon"}, ("table-no-numbers",)),
    "two decimal marks": (
        table(delimiter=";", decimal=",", header="strain;stress (MPa)") + "2.5;0.1\n",
        {},
        ("value-not-number", "row 27", "column 1", "2.5"),
    ),
    "thousands": (
        table(delimiter=";", decimal=",", header="strain;stress (Pa)") + "2,5;1.2345,6\n",
        {},
        ("value-not-number", "1.2345,6"),
    ),
    "a row too long": (table() + "2.1,0.1,7\n", {}, ("row-length-wrong", "row 27", "3", "2")),
    "mixed units": (
        "strain;stress (MPa)\n-;kPa\n" + table("", delimiter=";").lstrip(),
        {},
        ("column-unit-unknown", "stress", "MPa", "kPa", "--stress-unit"),
    ),
    "no unit of stress": (table("strain,stress"), {}, ("column-unit-unknown", "--stress-unit")),
    "millipascal": (table("strain,stress (mPa)"), {}, ("column-unit-unknown", "--stress-unit")),
    "per cent without saying so": (
        table("strain,stress (MPa)", 100 * STRAIN),
        {},
        ("column-unit-unknown", "200", "--strain-unit", "%"),
    ),
    "duplicate columns": (
        "strain,stress (MPa),stress (MPa)\n" + rows(STRAIN, STRESS, "{a},{b},{b}\n"),
        {},
        ("column-ambiguous", "2 (stress (MPa))", "3", "--stress"),
    ),
    "two strains": (
        "strain 1,strain 2,stress (MPa)\n" + rows(STRAIN, STRESS, "{a},{a},{b}\n"),
        {},
        ("column-ambiguous", "--strain"),
    ),
    "no column of stress": (
        "strain,temperature\n" + rows(STRAIN, STRESS, "{a},{b}\n"),
        {},
        ("column-missing", "--stress"),
    ),
    "a column that is not there": (table(), {"stress": "force"}, ("column-unknown", "force", "--stress")),
    "travel without a gauge length": (
        table("Extension (mm),Stress (MPa)"),
        {},
        ("gauge-length-missing", "--gauge-length"),
    ),
    "force without a section": (table("strain,Force (N)"), {}, ("section-missing", "--section")),
    "constant stress": (table(stress=0 * STRESS), {}, ("stress-constant", "0")),
    "constant strain": (table(strain=0 * STRAIN + 0.1), {}, ("stretch-constant", "1.1")),
    "compression called tension": (
        table(strain=-0.3 * STRAIN, stress=-STRESS),
        {},
        ("tension-strain-negative", "--compression"),
    ),
    "stress against strain": (table(stress=-STRESS), {}, ("stress-sign-wrong",)),
    "stress in Pa called MPa": (table(stress=1e6 * STRESS), {}, ("stress-implausible", "MPa")),
    "binary": (bytes(range(256)) * 40, {}, ("file-not-text",)),
    "a spreadsheet": (b"PK\x03\x04" + bytes(500), {}, ("file-is-spreadsheet", "CSV")),
    "an image": (b"\x89PNG\r\n\x1a\n" + bytes(3000), {}, ("file-not-text",)),
    "a page of text": ("It was a dark and stormy night.\n" * 50, {}, ("table-no-numbers",)),
    "columns swapped": (
        "stress (MPa),strain (-)\n" + rows(STRAIN, STRESS, "{a},{b}\n"),
        {"strain": "1", "stress": "1"},
        ("column-taken-twice", "--strain", "--stress"),
    ),
}


def test_there_are_thirty_malformed_files_and_more() -> None:
    assert len(MALFORMED) >= 30


@pytest.mark.parametrize("case", MALFORMED)
def test_a_malformed_file_is_refused_with_row_column_and_remedy(case: str, tmp_path: Path) -> None:
    text, spec, says = MALFORMED[case]
    path = write(tmp_path / "tension.csv", text)
    started = time.perf_counter()
    with refused(*says) as caught:
        read_test_file(path, TestFileSpec(**spec))
    assert time.perf_counter() - started < 5
    assert str(path) in caught.value.problem
    assert caught.value.remedy


@pytest.mark.parametrize("case", MALFORMED)
def test_the_command_refuses_it_in_one_sentence_and_leaves_with_2(
    case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text, spec, _ = MALFORMED[case]
    path = write(tmp_path / "tension.csv", text)
    flags = [word for key, value in spec.items() for word in (f"--{key.replace('_', '-')}", str(value))]
    with pytest.raises(SystemExit) as left:
        main(["material", "fit", str(path), "--alone", *flags])
    shown = capsys.readouterr()
    assert left.value.code == 2
    assert shown.err.startswith("Error: ")
    assert len(shown.err.strip().splitlines()) <= 2
    assert "Traceback" not in shown.err


def test_ten_million_rows_are_read_in_five_seconds_of_a_processor(tmp_path: Path) -> None:
    strain = np.linspace(0.001, 2.0, 100_000)
    stress = trace_curve(get_material("zaid_2024_ecoflex_00_30"), Loading.TENSION.mode, 1 + strain).nominal
    block = [f"{a:.6f},{b:.6f}\n" * 100 for a, b in zip(strain, stress, strict=True)]
    path = write(tmp_path / "tension.csv", "strain,stress (MPa)\n" + "".join(block))
    del block
    started = time.process_time()
    sample = read(path)
    assert time.process_time() - started < 5
    assert 40_000 < len(sample.stretch) <= 51_000
    assert "thinned" in sample.notes[0]
    assert np.interp(2.0, sample.stretch, sample.nominal) == pytest.approx(np.interp(1.0, strain, stress), rel=1e-3)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with refused("file-unreadable"):
        read_test_file(tmp_path / "tension.csv")
    with refused("file-unreadable"):
        read_test_file(tmp_path)


@pytest.mark.parametrize(
    ("name", "loading"),
    [
        ("Zug_1", Loading.TENSION),
        ("sample ASTM D412", Loading.TENSION),
        ("compression 3", Loading.COMPRESSION),
        ("D395_a", Loading.COMPRESSION),
        ("equibiaxial", Loading.EQUIBIAXIAL),
        ("ET_stress_stretch", Loading.EQUIBIAXIAL),
        ("pure shear 2", Loading.PLANAR),
        ("PS_stress_stretch", Loading.PLANAR),
        ("uniaxial", Loading.UNIAXIAL),
        ("rubber_ut", Loading.TENSION),
        ("rubber_UT2", Loading.TENSION),
        ("rubber_et", Loading.EQUIBIAXIAL),
        ("rubber-ps", Loading.PLANAR),
        ("rubber_et_3", Loading.EQUIBIAXIAL),
    ],
)
def test_the_test_is_read_from_the_name_of_the_file(name: str, loading: Loading, tmp_path: Path) -> None:
    assert read(write(tmp_path / f"{name}.csv", table(strain=0.4 * STRAIN))).loading is loading


def test_one_file_holds_all_tests_by_the_suffixes_of_its_columns(tmp_path: Path) -> None:
    ends = ("ut", "et", "ps")
    header = ",".join(f"strain_{end},stress_MPa_{end}" for end in ends)
    lines = [",".join(f"{a:.9f},{(1 + k) * b:.9f}" for k in range(3)) for a, b in zip(STRAIN, STRESS, strict=True)]
    samples = read_test_file(write(tmp_path / "rubber.csv", "\n".join([header, *lines])))
    assert [sample.loading for sample in samples] == [Loading.TENSION, Loading.EQUIBIAXIAL, Loading.PLANAR]
    for factor, sample in enumerate(samples, start=1):
        assert sample.nominal == pytest.approx(factor * STRESS, rel=1e-6)


def test_a_word_of_a_sentence_is_no_test(tmp_path: Path) -> None:
    text = "# essai de traction et relaxation\n" + table()
    assert read(write(tmp_path / "essai.csv", text)).loading is Loading.TENSION


def test_a_file_that_does_not_say_its_test_is_refused(tmp_path: Path) -> None:
    for name in ("sample", "tension_and_compression"):
        with refused("test-unknown", "--tension", "--compression"):
            read_test_file(write(tmp_path / f"{name}.csv", table()))


@pytest.mark.parametrize(("strain_sign", "stress_sign"), [(1, 1), (-1, -1), (-1, 1), (1, -1)])
def test_compression_comes_out_negative_whichever_sign_the_bench_gives_it(
    strain_sign: int, stress_sign: int, tmp_path: Path
) -> None:
    squeezed = np.linspace(0.01, 0.5, 30)
    stress = -trace_curve(get_material("zaid_2024_ecoflex_00_30"), Loading.COMPRESSION.mode, 1 - squeezed).nominal
    text = table("strain,stress (MPa)", strain_sign * squeezed, stress_sign * stress)
    sample = read(write(tmp_path / "compression.csv", text))
    assert sample.stretch == pytest.approx(1 - squeezed)
    assert sample.nominal == pytest.approx(-stress)


def test_compression_to_nothing_is_refused(tmp_path: Path) -> None:
    with refused("stretch-not-positive"):
        read_test_file(write(tmp_path / "compression.csv", table()))


def test_samples_are_told_apart_by_a_column(tmp_path: Path) -> None:
    text = "specimen,strain,stress (MPa)\n" + "".join(
        rows(STRAIN, factor * STRESS, f"{number},{{a:.9f}},{{b:.9f}}\n") for number, factor in ((1, 1.0), (2, 1.1))
    )
    first, second = read_test_file(write(tmp_path / "tension.csv", text))
    assert holds(first)
    assert second.nominal == pytest.approx(1.1 * STRESS, rel=1e-6)
    assert second.name == "tension.csv sample 2"


def test_samples_stand_side_by_side_and_may_be_of_different_length(tmp_path: Path) -> None:
    lines = ["strain,stress (MPa),strain,stress (MPa)"]
    for at, (a, b) in enumerate(zip(STRAIN, STRESS, strict=True)):
        lines.append(f"{a:.9f},{b:.9f}," + (f"{a:.9f},{1.1 * b:.9f}" if at < 15 else ","))
    first, second = read_test_file(write(tmp_path / "tension.csv", "\n".join(lines)))
    assert holds(first)
    assert len(second.stretch) == 15
    assert second.nominal == pytest.approx(1.1 * STRESS[:15], rel=1e-6)


@pytest.mark.parametrize("name", ["Ecoflex 00-30", "Ecoflex 00-50", "Dragon Skin 10 MEDIUM", "Dragon Skin 30"])
def test_the_shared_files_are_read_without_a_word(name: str) -> None:
    sample = read(DATA / "marechal_2020" / f"{name}.csv")
    assert sample.loading is Loading.TENSION
    assert 300 < len(sample.stretch) < 730
    assert sample.stretch[0] == pytest.approx(1.06, abs=0.02)
    assert 1 < sample.nominal.max() < 5


def test_meuniers_silicone_is_read_with_columns_by_number() -> None:
    spec = {"strain": "2", "strain_unit": "stretch", "stress": "1", "stress_unit": "MPa"}
    folder = DATA / "meunier_2008"
    both = read(folder / "UT_stress_stretch.txt", **spec, loading="uniaxial")
    assert (both.stretch.min(), both.nominal.min()) == (0.49, -1.3878)
    assert read(folder / "ET_stress_stretch.txt", **spec).loading is Loading.EQUIBIAXIAL
    assert read(folder / "PS_stress_stretch.txt", **spec).loading is Loading.PLANAR


def test_files_damaged_at_random_are_read_or_refused_and_nothing_else(tmp_path: Path) -> None:
    """Bytes put in, taken out and changed in files that are right: only a `PalpateError` may come of it."""
    rng = np.random.default_rng(11)
    whole = [text if isinstance(text, bytes) else text.encode() for text, _ in READ_RIGHTLY.values()]
    scraps = [
        b",",
        b";",
        b"\t",
        b"\n",
        b'"',
        b"nan",
        b"1e400",
        b"-",
        b"\x00",
        b"\xff",
        b"abc",
        b"%",
        b"(Pa)",
        b"#",
        b"1_0",
    ]
    path = tmp_path / "tension.csv"
    read_well = 0
    for _ in range(1500):
        damaged = bytearray(whole[rng.integers(len(whole))])
        for _ in range(rng.integers(0, 5)):
            at = int(rng.integers(len(damaged)))
            match rng.integers(3):
                case 0:
                    damaged[at:at] = scraps[rng.integers(len(scraps))]
                case 1:
                    del damaged[at : at + int(rng.integers(1, 20))]
                    damaged = damaged or bytearray(b"\n")
                case _:
                    damaged[at] = int(rng.integers(256))
        path.write_bytes(damaged)
        try:
            samples = read_test_file(path, TestFileSpec(gauge_length=33, section=18))
        except PalpateError:
            continue
        assert all(np.isfinite(sample.nominal).all() and (sample.stretch > 0).all() for sample in samples)
        read_well += 1
    assert 200 < read_well < 1200
