// Axes of the design's frame, and a scale bar in the plane through the middle of the view.
export const GAUGE = `<svg ref="gauge" class="dome-gauge" width="170" height="64" aria-hidden="true"><path class="scale"/><text class="scale"/>
  <g v-for="axis in ['x', 'y', 'z']" :key="axis"><path/><text>{{ axis }}</text></g></svg>`;

const LENGTHS_MM = [100, 50, 20, 10, 5, 2, 1, 0.5, 0.2, 0.1];
const ROOM_PX = 104;
const ARM_PX = 20;

export function drawGauge(svg, camera, target, height) {
  const pixels = height / (2 * camera.position.distanceTo(target) * Math.tan((camera.fov * Math.PI) / 360));
  if (!Number.isFinite(pixels)) return; // the camera has no place yet
  const length = LENGTHS_MM.find((value) => value * pixels <= ROOM_PX) || LENGTHS_MM.at(-1);
  const end = 168 - length * pixels;
  svg.dataset.pxPerMm = pixels.toFixed(4);
  svg.querySelector("path.scale").setAttribute("d", `M${end} 52v8M${end} 56H168M168 52v8`);
  place(svg.querySelector("text.scale"), (end + 168) / 2, 46, `${length} mm`);
  const frame = camera.matrixWorld.elements;
  svg.querySelectorAll("g").forEach((group, axis) => {
    const [x, y] = [frame[axis], -frame[4 + axis]];
    group.firstElementChild.setAttribute("d", `M28 34l${ARM_PX * x} ${ARM_PX * y}`);
    place(group.lastElementChild, 28 + 1.32 * ARM_PX * x, 37.5 + 1.32 * ARM_PX * y);
  });
}

function place(text, x, y, words) {
  text.setAttribute("x", x);
  text.setAttribute("y", y);
  if (words) text.textContent = words;
}
