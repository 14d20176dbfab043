// The face of the skin in the plane of the cut: its cells, as tetrahedra, are intersected by the plane x = at.
import { THREE } from "nicegui-scene";
import { stage } from "palpate-stage";

const HAIR_MM = 1e-4; // beside the mirror plane, in which the faces of cells lie
const STEPS = [[9, 3, 1], [9, 1, 3], [3, 9, 1], [3, 1, 9], [1, 9, 3], [1, 3, 9]];
// Each eighth of a cell of 27 nodes is six tetrahedra about its diagonal.
const TETRAHEDRA = [0, 1, 3, 4, 9, 10, 12, 13].flatMap((first) =>
  STEPS.map(([a, b]) => [first, first + a, first + a + b, first + 13]));

export function buildSection() {
  return new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshPhongMaterial({ color: 0xd4d4d4, vertexColors: true,
    side: THREE.DoubleSide, shininess: 0, flatShading: true }));
}

// Cut the skin by the plane of the stage, which turns with a skin of revolution; what lies before it is not drawn.
export function placeSection(three, shell) {
  const { section, skin } = three;
  section.visible = stage.look.cut;
  skin.clippingPlanes = [];
  if (!stage.look.cut) return;
  const { turned } = shell.meta;
  const at = stage.pose.cut_at;
  const angle = turned ? (stage.pose.azimuth * Math.PI) / 180 : 0;
  skin.clippingPlanes = [new THREE.Plane(new THREE.Vector3(Math.cos(angle), Math.sin(angle), 0), -at)];
  section.scale.x = turned && at < 0 ? -1 : 1;
  const face = intersect(three, shell.arrays.cells, turned ? Math.max(Math.abs(at), HAIR_MM) : at + HAIR_MM);
  section.geometry.dispose();
  section.geometry = new THREE.BufferGeometry();
  section.geometry.setAttribute("position", new THREE.Float32BufferAttribute(face.points, 3));
  section.geometry.setAttribute("color", new THREE.Float32BufferAttribute(face.colours, 3));
  section.userData.field = face.field;
}

// Triangles of the plane inside the cells, with colours and values of the field at their corners.
function intersect({ positions, colours, field }, cells, at) {
  const face = { points: [], colours: [], field: [] };
  const x = (vertex) => positions.array[3 * vertex];
  const add = (a, b) => {
    const share = (at - x(a)) / (x(b) - x(a));
    const mixed = (values, i, j) => values[i] + share * (values[j] - values[i]);
    for (let k = 0; k < 3; k++) {
      face.points.push(mixed(positions.array, 3 * a + k, 3 * b + k));
      face.colours.push(mixed(colours.array, 3 * a + k, 3 * b + k));
    }
    face.field.push(mixed(field, a, b));
  };
  for (let first = 0; first < cells.length; first += 27) {
    const cell = cells.subarray(first, first + 27);
    if (cell.every((vertex) => x(vertex) < at) || cell.every((vertex) => x(vertex) >= at)) continue;
    for (const corners of TETRAHEDRA) {
      const [below, above] = [[], []];
      for (const corner of corners) (x(cell[corner]) < at ? below : above).push(cell[corner]);
      if (!below.length || !above.length) continue;
      const edges = below.length === 2
        ? [[below[0], above[0]], [below[0], above[1]], [below[1], above[1]], [below[1], above[0]]]
        : below.flatMap((low) => above.map((high) => [low, high]));
      for (let k = 2; k < edges.length; k++) for (const edge of [edges[0], edges[k - 1], edges[k]]) add(...edge);
    }
  }
  return face;
}
