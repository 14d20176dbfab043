"""Table files of many test machines, robots and spreadsheets, drawn from a seed, each with its right outcome."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

C10, C20, C30 = 0.018, -0.0002, 0.00003


@dataclass(frozen=True)
class Case:
    """File, flags, and samples (stretch, nominal) or poses (n, 3), or the code of an error."""

    name: str
    data: bytes
    flags: dict[str, object] = field(default_factory=dict)
    right: tuple[np.ndarray, ...] = ()
    code: str = ""
    file: str = "tension.csv"


def yeoh(stretch: np.ndarray) -> np.ndarray:
    first = stretch**2 + 2 / stretch - 3
    return 2 * (stretch - stretch**-2) * (C10 + 2 * C20 * first + 3 * C30 * first**2)


def text(
    head: str, *columns: np.ndarray, sep: str = ",", dec: str = ".", end: str = "\n", form: str = "{:.9g}"
) -> str:
    rows = [sep.join(form.format(value).replace(".", dec) for value in row) for row in zip(*columns, strict=True)]
    return end.join([head, *rows, ""]) if head else end.join([*rows, ""])


def material_cases(seed: int = 0) -> Iterator[Case]:
    """Tension and compression tests of one material, in every unit, dialect, encoding and layout."""
    rng = np.random.default_rng(seed)
    e = np.sort(rng.uniform(0.01, 2.0, 40))
    e[0] = 0.0
    p = yeoh(1 + e)
    one = (np.stack([1 + e, p]),)
    stress = {
        "MPa": 1,
        "kPa": 1e3,
        "Pa": 1e6,
        "N/mm²": 1,
        "N/mm2": 1,
        "N/mm^2": 1,
        "kgf/cm²": 1 / 0.0980665,
        "Kgf/cm2": 1 / 0.0980665,
        "psi": 145.03773773,
        "bar": 10.0,
        "kgf/mm2": 1 / 9.80665,
    }
    for unit, factor in stress.items():
        yield Case(f"stress in {unit}", text(f"Strain (mm/mm),Stress [{unit}]", e, factor * p).encode(), right=one)
    force = {"N": 1, "kN": 1e-3, "mN": 1e3, "lbf": 1 / 4.4482216152605, "kgf": 1 / 9.80665, "gf": 1e3 / 9.80665}
    size = {"gauge_length": 33.0, "section": 18.0}
    for unit, factor in force.items():
        head = f"Extension in mm\tLoad in {unit}"
        yield Case(f"force in {unit}", text(head, 33 * e, 18 * factor * p, sep="\t").encode(), size, one)
    yield Case(
        "travel in inches",
        text("Extension (in),Load (lbf)", 33 * e / 25.4, 18 * p / 4.4482216152605).encode(),
        size,
        one,
    )
    yield Case("strain_% and stress_kPa", text("strain_%,stress_kPa", 100 * e, 1e3 * p).encode(), right=one)
    yield Case("stretch", text("Stretch,Nominal stress (MPa)", 1 + e, p).encode(), right=one)
    yield Case(
        "unit flag", text("strain,stress", 100 * e, p).encode(), {"strain_unit": "%", "stress_unit": "MPa"}, one
    )
    heads = {
        "German": ("Dehnung;Spannung\n%;N/mm²", "cp1252"),
        "French": ("Déformation (%);Contrainte (MPa)", "latin-1"),
        "Chinese": ("应变(%);应力(MPa)", "gb18030"),
        "Japanese": ("ひずみ(%);応力(MPa)", "cp932"),
        "English UTF-16": ("Strain (%);Stress (MPa)", "utf-16"),
        "English UTF-8 with mark": ("Strain (%);Stress (MPa)", "utf-8-sig"),
        "Chinese UTF-8": ("应变(%);应力(兆帕)", "utf-8"),
    }
    for name, (head, encoding) in heads.items():
        yield Case(name, text(head, 100 * e, p, sep=";", dec=",", end="\r\n").encode(encoding), right=one)
    for sep in (";", "|", "\t", " "):
        yield Case(f"separator {sep!r}", text(sep.join(["strain", "stress_MPa"]), e, p, sep=sep).encode(), right=one)
    yield Case(
        "sep= line", ("sep=;\n" + text("Strain;Stress [kPa]", e, 1e3 * p, sep=";", dec=",")).encode(), right=one
    )
    quoted = text('"Strain (%)","Stress (MPa)"', 100 * e, p, sep='","', dec=",").splitlines()
    quoted = [quoted[0], *(f'"{row}"' for row in quoted[1:])]
    yield Case("quoted decimal commas", "\n".join(quoted).encode(), right=one)
    yield Case(
        "comments",
        ("# test 3\n" + text("strain,stress (MPa)", e, p).replace("\n", "\n# pause\n", 3)).encode(),
        right=one,
    )
    clock = "".join(f"00:00:{k:02d}.0,Test,{a:.9g},{b:.9g}\n" for k, (a, b) in enumerate(zip(e, p, strict=True)))
    yield Case("clock and words", ("Time,Status,Strain (mm/mm),Stress (MPa)\n" + clock).encode(), right=one)
    results = "Results Table 1\n,Maximum stress (MPa),Modulus\n1,0.11,0.12\n2,0.12,0.13\nMean,0.1,0.1\n\n"
    body = text("Time,Strain,Stress\n(s),(mm/mm),(MPa)", np.arange(40), e, p)
    yield Case("results table first", (results + body).encode(), right=one)
    yield Case("mean below", (text("Strain (%),Stress (MPa)", 100 * e, p) + "\nMean,0.05\n").encode(), right=one)
    two = (np.stack([1 + e, p]), np.stack([1 + e, 1.1 * p]))
    blocks = [text("Strain (mm/mm);Stress (MPa)", e, k * p, sep=";") for k in (1, 1.1)]
    yield Case("stacked under headings", ("Specimen 1\n" + "\nSpecimen 2\n".join(blocks)).encode(), right=two)
    bare = [block.split("\n", 1)[1] for block in blocks]
    yield Case("stacked after a blank line", (blocks[0] + "\n" + bare[1]).encode(), right=two)
    yield Case("stacked without a mark", (blocks[0] + bare[1]).encode(), right=two)
    yield Case(
        "side by side",
        text(
            "Probe 1,,Probe 2,\nDehnung,Spannung,Dehnung,Spannung\n%,MPa,%,MPa", 100 * e, p, 100 * e, 1.1 * p
        ).encode(),
        right=two,
    )
    yield Case(
        "true columns only", text("True strain,True stress (MPa)", np.log1p(e), p * (1 + e)).encode(), right=one
    )
    yield Case(
        "true stress, strain in %",
        text("Engineering strain (%),True stress (MPa)", 100 * e, p * (1 + e)).encode(),
        right=one,
    )
    yield Case(
        "true beside engineering",
        text("True strain,True stress (MPa),Strain,Stress (MPa)", np.log1p(e), p * (1 + e), e, p).encode(),
        right=one,
    )
    records = "".join(json.dumps({"strain": a, "stress (MPa)": b}) + "\n" for a, b in zip(e, p, strict=True))
    yield Case("JSON lines", records.encode(), right=one, file="tension.jsonl")
    c = np.linspace(0.01, 0.4, 30)
    squeezed = (np.stack([1 - c, yeoh(1 - c)]),)
    for sign in (1, -1):
        data = text("strain (%),stress (kPa)", 100 * sign * c, -sign * 1e3 * yeoh(1 - c)).encode()
        yield Case(f"compression of sign {sign}", data, right=squeezed, file="compression.csv")
    yield from cyclic_cases()
    yield from more_material_cases(e, p)
    stiff = text("Strain,Stress (MPa)", 100 * np.linspace(0.001, 0.1, 30), 0.1 * np.linspace(0.001, 0.1, 30)).encode()
    yield Case("per cent without a unit, soft", stiff, code="modulus-implausible")
    yield Case(
        "per cent without a unit, far", text("Strain,Stress (MPa)", 100 * e, p).encode(), code="column-unit-unknown"
    )
    yield Case(
        "stress in kPa called MPa",
        text("Strain (%),Stress (MPa)", 100 * e, 1e5 * p).encode(),
        code="stress-implausible",
    )
    yield Case("no unit of stress", text("Strain,Stress", e, p).encode(), code="column-unit-unknown")
    yield Case(
        "two tables",
        (text("Strain,Stress (MPa)", e, p) + "\n" + text("Time (s),Force (N),Temperature (C)", e, p, p)).encode(),
        code="table-several",
    )
    yield Case(
        "comma for both marks",
        text("Strain,Stress (MPa)", e[1:], p[1:], dec=",", form="{:.5f}").encode(),
        code="header-length-wrong",
    )
    yield Case("a spreadsheet", b"PK\x03\x04" + bytes(200), code="file-is-spreadsheet")
    yield Case("an unreadable Parquet file", b"PAR1 nothing", code="file-unreadable", file="tension.parquet")


def more_material_cases(e: np.ndarray, p: np.ndarray) -> Iterator[Case]:
    """Units in cells, marks between thousands, headings in comments, names of travel that few machines use."""
    one = (np.stack([1 + e, p]),)
    size = {"gauge_length": 33.0, "section": 18.0}

    def cells(head: str, form: str) -> bytes:
        return (head + "".join(form.format(e=a, p=b) for a, b in zip(e, p, strict=True))).encode()

    yield Case("unit in every cell", cells("Strain,Stress\n", "{e:.9g},{p:.9g} MPa\n"), right=one)
    percent = (head := "Strain,Stress (MPa)\n") + "".join(
        f"{100 * a:.9g}%,{b:.9g}\n" for a, b in zip(e, p, strict=True)
    )
    yield Case("per cent in every cell", percent.encode(), right=one)
    yield Case("units in all cells", percent.replace(head, "Strain,Stress\n").replace("\n", " MPa\n").replace(
        "Stress MPa", "Stress").encode(), right=one)  # fmt: skip
    yield Case("some cells with a unit", cells(head, "{e:.9g},{p:.9g}\n") + b"2.1,0.2 MPa\n", code="value-not-number")
    pascal = [f"{1e6 * b:,.1f}" for b in p]
    right = (np.stack([1 + e, [float(cell.replace(",", "")) / 1e6 for cell in pascal]]),)
    marks = {
        "English": (",", ".", ","),
        "German": (".", ",", ";"),
        "Swiss": ("'", ".", ";"),
        "French": ("\u202f", ",", ";"),
    }
    for name, (thousand, decimal, sep) in marks.items():
        rows = [
            f"{a:.9f}".replace(".", decimal) + sep + f'"{cell}"'.translate({44: thousand, 46: decimal})
            for a, cell in zip(e, pascal, strict=True)
        ]
        data = "\n".join([f"Strain (mm/mm){sep}Stress (Pa)", *rows, ""])
        yield Case(f"marks between thousands, {name}", data.encode(), right=right)
    fortran = cells("strain stress_MPa\n", "{e:.9E} {p:.9E}\n").replace(b"E", b"D")
    yield Case("exponents of Fortran", fortran, right=one)
    yield Case("heading in a comment", cells("# tester A\n# strain [1]  stress [MPa]\n", "{e:.9g} {p:.9g}\n"),
               right=one)  # fmt: skip
    yield Case("heading and units in comments", cells("# strain stress\n# % MPa\n", "{e:.9g} {p:.9g}\n"),
               right=(np.stack([1 + e / 100, p]),))  # fmt: skip
    yield Case(
        "names with units between spaces", cells("strain [mm/mm] stress [MPa]\n", "{e:.9g} {p:.9g}\n"), right=one
    )
    lists = "\n".join(["curve,note", *(f'"[{a:.9g}, {b:.9g}]",x' for a, b in zip(e, p, strict=True)), ""])
    asked = {"strain": "curve_0", "stress": "curve_1", "strain_unit": "mm/mm", "stress_unit": "MPa"}
    yield Case("lists in cells", lists.encode(), asked, one)
    for travel in ("Stroke", "Hub", "Course", "Deflection", "Längenänderung", "行程", "Jaw separation", "dL"):
        data = text(f"Time,Force,{travel}\nSec,N,mm", np.arange(40.0), 18 * p, 33 * e)
        yield Case(f"travel called {travel}", data.encode(), size, one)
    yield Case("columns known by their units", text("A (s),B (mm),C (kN)", e, 33 * e, 0.018 * p).encode(), size, one)
    yield Case("two columns of one unit", text("A (mm),B (mm),C (kN)", e, e, p).encode(), size, code="column-missing")


def cyclic_cases() -> Iterator[Case]:
    """Three levels of four cycles with softening and set."""
    stretch, nominal, first = [], [], []
    reached = 0.0
    cycles: dict[int, list[np.ndarray]] = {}
    for level in (0.25, 0.6, 1.2):
        for cycle in range(4):
            soft, rest = 1.0 - 0.25 * (1 - 0.5**cycle), 1 + 0.02 * level * cycle
            up = np.linspace(rest - 1, level, 30)
            kept = 1 + up > rest - 1e-12
            virgin = yeoh(1 + up)
            curve = virgin if cycle == 0 else soft * (yeoh((1 + up) / rest) / rest)
            if cycle == 0:
                curve = np.where(up <= reached, 0.75 * virgin, virgin)
                new = up > reached if reached else up >= 0
                first += list(zip(1 + up[new], virgin[new], strict=True))
            cycles.setdefault(cycle, []).append(np.stack([(1 + up[kept]) / rest, curve[kept] * rest]))
            down = np.linspace(level, 0.02 * level * (cycle + 1), 30)[1:-1]
            stretch += [*(1 + up), *(1 + down)]
            nominal += [*curve, *(0.6 * yeoh(1 + down))]
        reached = level
    data = text(
        "Time (s),Strain (mm/mm),Stress (MPa)",
        0.1 * np.arange(len(stretch)),
        np.array(stretch) - 1,
        np.array(nominal),
    ).encode()
    yield Case("cyclic: first loading", data, right=(np.array(first).T,))
    yield Case("cyclic: third cycle", data, {"cycle": 3}, tuple(cycles[2]))
    yield Case("cyclic: a cycle too many", data, {"cycle": 9}, code="cycle-missing")


def pose_cases(seed: int = 0) -> Iterator[Case]:
    """Recordings of known tilts and depths, in every dialect and representation; `right` is (n, 3)."""
    rng = np.random.default_rng(seed)
    tilt = np.round(rng.uniform(-9, 9, (24, 2)), 3)
    depth = np.round(rng.uniform(0.5, 4, 24), 3)
    right = (np.column_stack([tilt, depth]),)
    names = [f"img_{k:03d}.png" for k in range(24)]

    def rows(head: str, cells: np.ndarray, sep: str = ",", dec: str = ".", form: str = "{:.9g}") -> str:
        lines = [
            sep.join([n, *(form.format(v).replace(".", dec) for v in row)])
            for n, row in zip(names, cells, strict=True)
        ]
        return "\n".join([head, *lines, ""])

    plain = right[0]
    yield Case("plain poses", rows("image,rx_deg,ry_deg,depth_mm", plain).encode(), right=right)
    for name, sep, dec in (("semicolons", ";", ","), ("tabs", "\t", ","), ("bars", "|", "."), ("spaces", " ", ".")):
        head = sep.join(["image", "rx_deg", "ry_deg", "depth_mm"])
        yield Case(f"poses by {name}", rows(head, plain, sep, dec).encode(), right=right)
    for encoding in ("utf-8-sig", "utf-16", "cp1252"):
        yield Case(
            f"poses in {encoding}",
            rows("Bild;rx [°];ry [°];Tiefe [mm]", plain, ";", ",").encode(encoding),
            right=right,
        )
    yield Case(
        "poses in rad and m",
        rows("filename,rx [rad],ry [rad],depth (m)", plain * [np.pi / 180, np.pi / 180, 1e-3]).encode(),
        right=right,
    )
    yield Case("a row of units", rows("image,rx,ry,depth\n,deg,deg,mm", plain).encode(), right=right)
    yield Case("roll and pitch", rows("image,roll_deg,pitch_deg,z_mm", plain).encode(), right=right)
    yield Case(
        "units by flag",
        rows("image,rx,ry,depth", plain * [np.pi / 180, np.pi / 180, 1e-3]).encode(),
        {"angles": "rad", "lengths": "m"},
        right,
    )
    lines = [
        json.dumps({"image": n, "pose": {"rx_deg": a, "ry_deg": b, "depth_mm": d}})
        for n, (a, b, d) in zip(names, plain.tolist(), strict=True)
    ]
    yield Case("poses as JSON lines", "\n".join(lines).encode(), right=right, file="poses.jsonl")
    turns = [np.pi / 0.18, np.pi / 0.18, 1e3]
    yield Case("poses in mrad", rows("image,rx_mrad,ry_mrad,depth_um", plain * turns).encode(),
               right=right)  # fmt: skip
    cells = [f"{n},{a:.9g}°,{b:.9g}°,{d:.9g} mm" for n, (a, b, d) in zip(names, plain, strict=True)]
    yield Case("units in cells of poses", "\n".join(["image,rx,ry,depth", *cells, ""]).encode(), right=right)
    plural = rows("image,rx_deg,ry_deg,depth_mm", plain)
    yield Case("images without endings", plural.replace(".png", "").encode(), right=right)
    yield Case("images of another ending", plural.replace(".png", ".JPG").encode(), right=right)
    yield Case("images by number", plural.replace("image", "frame").replace("img_", "").replace(".png", "").encode(),
               right=right)  # fmt: skip
    yield Case("no images named", "\n".join(line.split(",", 1)[1] for line in plural.split()).encode(), right=right)
    folders = {"Windows": "C:\\data\\run\\", "Linux": "/home/lab/run/", "below": "images/"}
    for name, folder in folders.items():
        yield Case(f"images in a folder, {name}", plural.replace("img_", folder + "img_").encode(), right=right)
    fields = [dict(zip(("rx_deg", "ry_deg", "depth_mm"), row, strict=True)) for row in plain.tolist()]
    named = [{"file_path": n, **row} for n, row in zip(names, fields, strict=True)]
    whole = {
        "an object for each image": dict(zip(names, fields, strict=True)),
        "a list": named,
        "a list in an object": {"sensor": "A", "frames": named},
        "columns": {key: [row[key] for row in named] for key in named[0]},
    }
    for name, value in whole.items():
        yield Case(f"JSON: {name}", json.dumps(value, indent=1).encode(), right=right, file="poses.json")
    yield Case("no units", rows("image,rx,ry,depth", plain / 100).encode(), code="column-unit-unknown")
    yield Case("column twice", rows("image,rx_deg,rx_deg,depth_mm", plain).encode(), code="column-twice")
    yield Case("no header", rows("", plain).strip().encode(), code="header-missing")
    yield from tool_cases(rows, right)


def tool_cases(rows, right: tuple[np.ndarray, ...]) -> Iterator[Case]:
    """A tool that points down or aside, in the base of its robot; the truth is its tilt in its own frame."""
    tilt, depth = right[0][:, :2], right[0][:, 2]
    turn = Rotation.from_rotvec(np.column_stack([tilt, np.zeros(24)]), degrees=True)
    yaw = Rotation.from_euler("z", np.linspace(-170, 170, 24)[:, None], degrees=True)
    flip = Rotation.from_euler("x", 180, degrees=True)
    wall = Rotation.from_euler("y", 60, degrees=True)
    frame = {"frame": "400,-100,200,0,0,1"}
    place = np.column_stack([np.full(24, 0.4), np.linspace(-0.1, -0.11, 24), 0.2 - depth / 1e3])
    down = flip * turn
    xyz = "x_m,y_m,z_m,"
    vectors = np.column_stack([place, down.as_rotvec()])
    said = "image," + xyz + "rx_rad,ry_rad,rz_rad"
    yield Case("rotation vectors near pi", rows(said, vectors).encode(), right=right)
    yield Case("rotation vectors with a frame", rows(said, vectors).encode(), frame, right)
    yield Case(
        "a tool that turns", rows(said, np.column_stack([place, (yaw * down).as_rotvec()])).encode(), right=right
    )
    quaternion = np.column_stack([place, down.as_quat()])
    yield Case("quaternion by letters", rows("image," + xyz + "qx,qy,qz,qw", quaternion).encode(), right=right)
    swapped = quaternion[:, [0, 1, 2, 6, 3, 4, 5]]
    yield Case(
        "quaternion, w first", rows("image," + xyz + "quat_w,quat_x,quat_y,quat_z", swapped).encode(), right=right
    )
    numbered = "image," + xyz + "q_0,q_1,q_2,q_3"
    for order, cells in (("xyzw", quaternion), ("wxyz", swapped)):
        yield Case(f"numbered quaternion {order}", rows(numbered, cells).encode(), {"euler": order}, right)
    yield Case("numbered quaternion", rows(numbered, swapped).encode(), code="orientation-unknown")
    nine = ",".join(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))
    matrix = np.column_stack([place, down.as_matrix().reshape(24, 9)])
    yield Case("rotation matrix", rows("image," + xyz + nine, matrix).encode(), right=right)
    for order in ("xyz", "ZYX", "zyx", "XYZ"):
        angles = dict(zip(order.lower(), down.as_euler(order, degrees=True).T, strict=True))
        cells = np.column_stack([place, *(angles[letter] for letter in "xyz")])
        head = "image," + xyz + "rx_deg,ry_deg,rz_deg"
        yield Case(f"Euler {order}", rows(head, cells).encode(), {"euler": order}, right)
        yield Case(f"Euler {order} unstated", rows(head, cells).encode(), code="orientation-unknown")
    angles = down.as_euler("xyz", degrees=True)
    yield Case(
        "roll, pitch, yaw",
        rows("image," + xyz + "roll_deg,pitch_deg,yaw_deg", np.column_stack([place, angles])).encode(),
        right=right,
    )
    aside = np.column_stack([wall.apply([0, 0, 1]) * depth[:, None] + [300, 20, 100], (wall * turn).as_quat()])
    normal = ",".join(f"{v:.9f}" for v in -wall.apply([0, 0, 1]))
    yield Case(
        "an oblique wall",
        rows("image,x_mm,y_mm,z_mm,qx,qy,qz,qw", aside).encode(),
        {"frame": f"300,20,100,{normal}"},
        right,
    )
    yield Case("a bad frame", rows(said, vectors).encode(), {"frame": "1,2,3"}, code="frame-unreadable")
    wild = Rotation.random(24, random_state=0)
    yield Case(
        "no surface", rows(said, np.column_stack([place, wild.as_rotvec()])).encode(), code="orientation-spread"
    )
