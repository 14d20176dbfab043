"""Press a dome by FElupe; run by against_felupe.py in an environment that has FElupe, never imported by palpate.

python felupe_press.py MESH.npz RESULT.npz
"""

import sys
import time

import felupe as fem
import numpy as np
from felupe.constitution.tensortrax import Hyperelastic
from felupe.constitution.tensortrax.models.hyperelastic import yeoh
from pypardiso import spsolve

case = np.load(sys.argv[1])
nodes, normal = case["nodes"], case["normal"]
started = time.process_time()
mesh = fem.Mesh(nodes, case["cells"], "hexahedron27")
mesh.add_points(case["touch"])
wall = len(mesh.points) - 1
region = fem.RegionTriQuadraticHexahedron(mesh)
field = fem.FieldsMixed(region, n=3)
c10, c20, c30 = case["constants"]
law = fem.NearlyIncompressible(Hyperelastic(yeoh, C10=c10, C20=c20, C30=c30), bulk=float(case["bulk"]))
solid = fem.SolidBody(law, field)
contact = fem.ContactRigidPlane(
    field, points=case["outer"], centerpoint=wall, normal=normal, multiplier=float(case["penalty"])
)
base, mirror = np.zeros((2, len(mesh.points)), bool)
base[case["base"]] = mirror[case["mirror"]] = True
at_wall = np.arange(len(mesh.points)) == wall
bounds = {
    "base": fem.Boundary(field[0], mask=base),
    "mirror": fem.Boundary(field[0], mask=mirror, skip=(0, 1, 1)),
    "wall": fem.Boundary(field[0], mask=at_wall, skip=(1, 1, 0)),
    "wall_sideways": fem.Boundary(field[0], mask=at_wall, skip=(0, 0, 1)),
}
depth, force, moved, iterations = [0.0], [0.0], [np.zeros_like(nodes)], 0
failure = ""
images = set(np.round(case["depth"], 9))
for goal in case["steps"]:
    bounds["wall"].update(-goal)
    fixed, free = fem.dof.partition(field, bounds)
    known = fem.dof.apply(field, bounds, fixed)
    try:
        given = {"dof0": fixed, "dof1": free, "ext0": known, "solver": spsolve}
        found = fem.newtonraphson(items=[solid, contact], x0=field, tol=1e-5, maxiter=40, verbose=0, **given)
    except Exception as error:  # a press that fails is a row of the comparison
        failure = f"{type(error).__name__} at {goal:g} mm: {error}"
        break
    iterations += found.iterations
    if round(float(goal), 9) in images:
        depth.append(float(goal))
        force.append(-2 * float(fem.tools.force(field, found.fun, bounds["wall"])[2]))
        moved.append(field[0].values[:-1].copy())
np.savez(
    sys.argv[2],
    depth=depth,
    force=np.abs(force),
    displacement=moved,
    iterations=iterations,
    cpu_s=time.process_time() - started,
    unknowns=len(free),
    failure=failure,
)
