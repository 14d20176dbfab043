"""Command lines of the inventory: at least one for each verb, on the files of `examples/data`.

`{data}` is that folder. The commands run in one empty folder, in this order, so that later ones read the results of
earlier ones. Verbs that serve pages or search for hours are listed in `NOT_RUN` with the reason.
"""

DESIGN = "--markers 61"
TWIN = "--model small/twins/H20_T2.h5"

COMMANDS = {
    "run": "run {data}/small.yaml --out small --workers 1 --json",
    "status": "status {data}/small.yaml --out small --json",
    "store check": "store check small --json",
    "limit": "limit {data}/small.yaml --out small --json",
    "grid show": "grid show small --json",
    "grid compare": "grid compare small small --json",
    "grid plot": "grid plot small --out plots --json",
    "grid export": "grid export small --to grid.csv",
    "grid model": "grid model small --out model.onnx",
    "twin": "twin {data}/small.yaml --out small --workers 1 --json",
    "press": "press --height 20 --thickness 2 --tilt 5 --depth 4 --contact 0.8 --json",
    "press, skin": "press --skin ellipsoid --height 18 --thickness 2 --obstacle ball:radius=6,offset=3 "
    "--depth 3 --json",
    "press, inverted": "press --height 20 --thickness 1 --branch inverted --depth 8 --step 2 --cells 8 --json",
    "press, gel": "press --height 10 --thickness 1 --base-radius 10 --material neo-hooke:0.5 --gel neo-hooke:0.05 "
    "--depth 1 --step 0.5 --cells 8 --json",
    "stability": "stability --height 20 --thickness 1 --tilts 0 6 --cells 8 --depth 6 --step 1 --json",
    "convergence": "convergence --meshes 6 8 10 --depth 3 --step 1 --json",
    "design": "design --height 20 --thickness 2 --markers 169 --json",
    "design, layout": "design --layout {data}/layout.csv --json",
    "deck": "deck --output press.inp --cells 4 --dialect calculix",
    "fit": "fit --uniaxial {data}/rubber/uniaxial.csv --equibiaxial {data}/rubber/equibiaxial.csv "
    "--planar {data}/rubber/planar.csv --model yeoh --no-figure --json",
    "fit, relaxation": "fit --uniaxial {data}/rubber/uniaxial.csv --relaxation {data}/rubber/relaxation.csv "
    "--model yeoh --no-figure --json",
    "material list": "material list --json",
    "material show": "material show zaid_2024_ecoflex_00_30 --json",
    "make": "make --markers 61 --out pack --json",
    "export": "export --to mjcf --out asset --cells 4 --json",
    "specimens": "specimens --out specimens --json",
    "calibrate": "calibrate {data}/board --board chessboard:9x6:25 --out lens.yaml --json",
    "find": "find {data}/recording --json",
    "inspect": f"inspect {{data}}/rest.png {DESIGN} --json",
    "live": f"live --source {{data}}/recording {TWIN} {DESIGN} --count 12 --out live.csv --json",
    "identify": f"identify {{data}}/recording/poses.csv {TWIN} {DESIGN} --out unit.json --json",
    "accept": f"accept {{data}}/recording/poses.csv {TWIN} {DESIGN} --no-zero --out accept --json",
    "learn": "learn {data}/recording --out learnt --estimators ridge --json",
    "bench": f"bench --out bench {TWIN} {DESIGN} --units 0 --tilts 2 --azimuths 1 --depth 5 --cells 6 --json",
    "bench, budget": f"bench --out budget {TWIN} {DESIGN} --budget --json",
    "align": f"align {TWIN} {DESIGN} --walls 1 --known 0 --out align --json",
    "claims": "claims small --out claims.md --json",
    "benchmark make": "benchmark make --spec tiny --out set --workers 1 --json",
    "benchmark baselines": "benchmark baselines --set set/set --spec tiny --only ridge --out baselines "
    "--workers 1 --json",
    "verify": "verify --only cook --json",
    "doctor": "doctor --json",
}
"""Name → words after `palpate`. The name begins with the verb at cb298aa."""
NOT_RUN = {
    "view": "serves pages; tested in tests/browser",
    "serve": "serves readings; tested in tests/unit/viewer",
    "optimise": "its smallest search takes a quarter of an hour; tested in tests/end_to_end",
    "store gc": "removes artefacts; tested in tests/unit/cli",
    "benchmark score": "needs the hidden labels of a set; tested in tests/unit/benchmark",
}
"""Verb → why the inventory does not run it."""
PASSING = {
    "cpu_s", "wall_s", "bytes", "seconds", "elapsed_s", "time_s", "made_by", "versions", "version", "out", "folder",
    "path", "python",
    "platform", "made", "latency_ms", "checks",
}  # fmt: skip
"""Keys whose values change from run to run or from machine to machine."""
