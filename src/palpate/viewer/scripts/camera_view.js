// What the camera sees: dots as circles where they are, rings where they rest, and the way between, as SVG.
import { between, changed, listen, placeOf, save, stage } from "palpate-stage";

const REST_MS = 150;
const SVG = "http://www.w3.org/2000/svg";

export default {
  props: { slotName: String, label: String },
  template: `<div class="camera-view"><svg ref="svg" role="img" xmlns="http://www.w3.org/2000/svg" :aria-label="words"></svg></div>`,
  computed: {
    words() {
      return `${this.label}: markers as the camera below the dome sees them, with their way from rest.`;
    },
  },
  mounted() {
    this.stop = listen(() => this.draw());
    changed();
  },
  beforeUnmount() {
    this.stop();
    clearTimeout(this.resting);
  },
  methods: {
    draw() {
      const slot = stage.slots[this.slotName];
      if (!slot.motion || !slot.markers) {
        this.$refs.svg.replaceChildren();
        this.shell = null;
        return;
      }
      if (slot.shell !== this.shell) this.load(slot.shell);
      const { pixels, radius, seen } = slot.markers.arrays;
      const [images, count] = pixels.shape;
      const place = placeOf(slot.motion);
      const at = { image: Math.min(place.image, images - 1), next: Math.min(place.next, images - 1), share: place.share };
      const now = between(pixels, 2 * count, at, new Float32Array(2 * count));
      const size = between(radius, count, at, new Float32Array(count));
      for (let m = 0; m < count; m++) {
        const dot = this.marks[m];
        dot.setAttribute("cx", now[2 * m].toFixed(2));
        dot.setAttribute("cy", now[2 * m + 1].toFixed(2));
        dot.setAttribute("r", Math.max(size[m], 0.5).toFixed(2));
        dot.setAttribute("visibility", seen[at.image * count + m] ? "visible" : "hidden");
      }
      this.hurry();
      this.trails.setAttribute("d", stage.look.trails ? ways(pixels, seen, at.image, now) : "");
    },
    // Smooth edges cost more than all the rest without a graphics card: they wait until the picture rests.
    hurry() {
      this.trails.setAttribute("shape-rendering", "optimizeSpeed");
      clearTimeout(this.resting);
      this.resting = setTimeout(() => this.trails.removeAttribute("shape-rendering"), REST_MS);
    },
    load(shell) {
      this.shell = shell;
      const { width_px: width, height_px: height } = shell.meta;
      const svg = this.$refs.svg;
      svg.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
      const ground = make("rect", { x: -0.5, y: -0.5, width, height, fill: "#e9e6df" });
      const rest = make("g", { fill: "none", stroke: "#9a938a", "stroke-width": width / 500 });
      this.trails = make("path", { fill: "none", stroke: "#d55e00", "stroke-width": width / 320, "stroke-linejoin": "bevel" });
      const dots = make("g", { class: "dots", fill: "#22262b" });
      this.marks = [];
      const points = shell.arrays.rest_px;
      for (let m = 0; m < points.length / 2; m++) {
        rest.append(make("circle", { cx: points[2 * m], cy: points[2 * m + 1], r: width / 140 }));
        this.marks.push(make("circle", {}));
      }
      dots.append(...this.marks);
      svg.replaceChildren(ground, rest, dots, this.trails);
    },
    saveDrawing(name) {
      save(name, new XMLSerializer().serializeToString(this.$refs.svg), "image/svg+xml");
    },
  },
};

// The way of every visible dot from rest as one path: a path each would take much longer to draw.
function ways(pixels, seen, image, now) {
  const count = pixels.shape[1];
  let path = "";
  for (let m = 0; m < count; m++) {
    if (!seen[image * count + m]) continue;
    for (let k = 0; k <= image; k++) {
      const i = 2 * (k * count + m);
      path += `${k ? "L" : "M"}${pixels[i].toFixed(1)} ${pixels[i + 1].toFixed(1)}`;
    }
    path += `L${now[2 * m].toFixed(1)} ${now[2 * m + 1].toFixed(1)}`;
  }
  return path;
}

function make(kind, attributes) {
  const element = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}
