// The skin in 3-D: of a half skin the mirror image is drawn as well; a plane that is moved cuts it open.
import { OrbitControls, THREE } from "nicegui-scene";
import { between, changed, listen, placeOf, save, stage } from "palpate-stage";
import { drawGauge, GAUGE } from "palpate-stage/gauge.js";
import { buildSection, placeSection } from "palpate-stage/section.js";
import { colour, FAR_MM, isBlank, ramp, topOfAll } from "palpate-stage/tones.js";

const NAMES = { displacement: "displacement (mm)", stress: "von Mises stress (MPa)", pressure: "contact pressure (MPa)", contact: "distance to the wall (mm)" };
const CLAMP_MM = [4, 3];
const REST_MS = 250;
const [COARSE, SHARP] = [0.7, 1.5]; // pixels of a moving and of a resting picture without a graphics card

export default {
  props: { slotName: String, label: String },
  template: `
    <div class="dome-view" ref="box">
      <canvas ref="canvas" tabindex="0" role="img" :aria-label="words" @keydown="turn"
        @pointermove="probe" @pointerleave="$refs.probe.textContent = ''"></canvas>
      <div class="dome-legend" ref="legend" aria-hidden="true"><span ref="low"></span><i ref="ramp"></i><span ref="high"></span><b ref="what"></b></div>
      ${GAUGE}
      <div class="dome-probe" ref="probe"></div>
      <div class="dome-note" ref="note" role="status"></div>
    </div>`,
  computed: {
    words() {
      return `${this.label}: the pressed dome in 3-D. Arrow keys turn the view, plus and minus zoom.`;
    },
  },
  mounted() {
    this.stop = listen(() => this.draw());
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(this.$refs.box);
    this.resize();
    changed();
  },
  beforeUnmount() {
    this.stop();
    clearTimeout(this.resting);
    this.watcher.disconnect();
    this.three?.renderer.dispose();
  },
  methods: {
    resize() {
      const { clientWidth: width, clientHeight: height } = this.$refs.box;
      if (!width || !height) return;
      if (!this.three) this.build();
      const { renderer, camera } = this.three;
      renderer.setPixelRatio(this.three.soft ? COARSE : Math.min(window.devicePixelRatio, 2));
      renderer.setSize(width, height, false);
      camera.aspect = width / height;
      this.fit();
      camera.updateProjectionMatrix();
      this.render();
    },
    // A view that is hidden has no scene until it is seen first.
    build() {
      this.three = buildScene(this.$refs.canvas);
      this.three.controls.addEventListener("change", () => this.render());
      changed();
    },
    draw() {
      if (!this.three) return;
      const slot = stage.slots[this.slotName];
      if (!slot.motion) {
        this.three.pivot.visible = false;
        this.$refs.note.textContent = newFault() || (slot.name ? "Reading the presses …" : "");
        this.render();
        return;
      }
      if (slot.shell !== this.shell) this.load(slot.shell);
      this.fit();
      this.move(slot);
      this.render();
    },
    load(shell) {
      this.shell = shell;
      loadShell(this.three, shell);
      if (!this.placed) this.look("side");
    },
    // The distance at which the largest skin on the stage fills the view; the visitor's zoom is a factor to it.
    fit() {
      const { camera, controls } = this.three;
      const metas = Object.values(stage.slots).flatMap((slot) => (slot.shell ? [slot.shell.meta] : []));
      const sizes = metas.map((meta) => Math.max(meta.outer_base_radius_mm + CLAMP_MM[0], meta.outer_radius_mm, 0.62 * meta.height_mm));
      if (!sizes.length) return;
      const half = Math.tan((camera.fov * Math.PI) / 360);
      const span = (1.18 * Math.max(...sizes)) / (half * Math.min(1, camera.aspect));
      if (this.placed && span !== this.span) {
        camera.position.sub(controls.target).multiplyScalar(span / this.span).add(controls.target);
        controls.update();
      }
      this.span = span;
    },
    move(slot) {
      const { three } = this;
      const place = placeOf(slot.motion);
      const { positions } = three;
      this.colour = stage.look.colour;
      this.top = topOfAll();
      const count = slot.shell.arrays.rest.length;
      between(slot.motion.arrays.displacement, count, place, three.moved);
      for (let i = 0; i < count; i++) positions.array[i] = slot.shell.arrays.rest[i] + three.moved[i];
      positions.needsUpdate = true;
      colour(three, slot, place, this.top);
      smooth(three, slot.shell.arrays.seam);
      placeWall(three, slot, place.depth);
      placeMarkers(three, slot, place);
      three.pivot.visible = true;
      const { turned } = slot.shell.meta;
      three.pivot.rotation.z = turned ? (stage.pose.azimuth * Math.PI) / 180 : 0;
      three.other.visible = turned && !(stage.look.cut && stage.pose.cut_at >= 0);
      placeSection(three, slot.shell);
      this.say(slot, place);
    },
    say(slot, place) {
      const blank = isBlank(slot);
      const waits = blank && slot.motion.meta.depths_mm.length > 1;
      this.$refs.legend.style.visibility = blank && !waits ? "hidden" : "";
      this.$refs.low.textContent = "0";
      this.$refs.high.textContent = waits ? "…" : this.colour === "contact" ? `≥ ${FAR_MM}` : this.top.toPrecision(3);
      this.$refs.what.textContent = NAMES[this.colour];
      this.$refs.what.dataset.colour = this.colour;
      this.$refs.ramp.style.background = waits ? "#9aa3ab" : `linear-gradient(90deg, ${ramp(this.colour).join(", ")})`;
      const ended = place.depth < stage.pose.depth - 1e-6;
      this.$refs.note.textContent = newFault() || (waits ? `Computing the ${this.colour} …` : ended
        ? `Ended at ${place.depth.toFixed(1)} mm: ${slot.motion.meta.ended}.` : "");
    },
    // Without a graphics card a moving picture is coarse; at rest it is drawn once with smooth edges.
    render(sharp = false) {
      const { soft, renderer, scene, camera, controls } = this.three;
      clearTimeout(this.resting);
      if (soft) renderer.setPixelRatio(sharp ? SHARP : COARSE);
      if (soft && !sharp) this.resting = setTimeout(() => this.render(true), REST_MS);
      renderer.render(scene, camera);
      drawGauge(this.$refs.gauge, camera, controls.target, this.$refs.box.clientHeight);
      this.drawn = (this.drawn || 0) + 1;
      this.$refs.box.dataset.drawn = this.drawn;
    },
    look(from) {
      const meta = this.shell?.meta;
      if (!meta) return;
      const way = { side: [-2.6, -1.9, 1.6], top: [0, -0.01, 1], below: [0, -0.3, -1], front: [-1, 0, 0.15] }[from];
      const { camera, controls } = this.three;
      this.fit();
      const arm = new THREE.Vector3(...way).setLength(this.span);
      controls.target.set(0, 0, meta.height_mm * 0.42);
      camera.position.copy(controls.target).add(arm);
      this.placed = true;
      controls.update();
      this.render();
    },
    // Show the value of the colour under the pointer.
    probe(event) {
      const { canvas, probe } = this.$refs;
      const slot = stage.slots[this.slotName];
      probe.textContent = "";
      if (event.buttons || !slot.motion || isBlank(slot)) return;
      const { left, top, width, height } = canvas.getBoundingClientRect();
      const [x, y] = [event.clientX - left, event.clientY - top];
      const value = valueAt(this.three, new THREE.Vector2((2 * x) / width - 1, 1 - (2 * y) / height));
      if (value === null) return;
      probe.textContent = `${value.toPrecision(3)} ${/\((.+)\)/.exec(NAMES[this.colour])[1]}`;
      probe.style.transform = `translate(${Math.min(x + 12, width - 90)}px, ${Math.max(y - 26, 0)}px)`;
    },
    turn(event) {
      const step = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
      const zoom = { "+": 0.9, "=": 0.9, "-": 1.1 }[event.key];
      if (!step && !zoom) return;
      event.preventDefault();
      const { camera, controls } = this.three;
      const arm = camera.position.clone().sub(controls.target);
      const ball = new THREE.Spherical().setFromVector3(new THREE.Vector3(arm.x, arm.z, -arm.y));
      if (step) {
        ball.theta -= step[0];
        ball.phi = Math.min(Math.max(ball.phi + step[1], 0.02), Math.PI - 0.02);
      }
      if (zoom) ball.radius *= zoom;
      const turned = new THREE.Vector3().setFromSpherical(ball);
      camera.position.set(turned.x, -turned.z, turned.y).add(controls.target);
      controls.update();
    },
    savePicture(name) {
      this.render(true);
      save(name, this.three.renderer.domElement.toDataURL("image/png"), "image/png");
    },
    picturesDrawn() {
      return this.drawn;
    },
  },
};

function buildScene(canvas) {
  const soft = drawnBySoftware();
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: !soft, alpha: true, preserveDrawingBuffer: true });
  renderer.localClippingEnabled = true;
  const scene = new THREE.Scene();
  const camera = new THREE.PerspectiveCamera(32, 1, 1, 2000);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = false;
  scene.add(new THREE.HemisphereLight(0xffffff, 0xb8c4d0, 2.2), camera);
  const sun = new THREE.DirectionalLight(0xffffff, 1.5);
  sun.position.set(-30, 40, 60);
  camera.add(sun);
  const pivot = new THREE.Group();
  scene.add(pivot);
  return { soft, renderer, scene, camera, controls, pivot, fixed: addGroup(scene) };
}

// The fault of the server, unless the page itself shows it already.
function newFault() {
  const shown = [...document.querySelectorAll("[role=alert]")].some((box) => box.textContent.includes(stage.fault));
  return shown ? "" : stage.fault;
}

// The value of the colour between the corners of the nearest drawn triangle, or null beside the skin.
function valueAt(three, pointer) {
  const ray = new THREE.Raycaster();
  ray.setFromCamera(pointer, three.camera);
  const meshes = [three.section, three.whole, three.other].filter((mesh) => mesh.visible);
  meshes.forEach((mesh) => (mesh.geometry.boundingSphere = null)); // the skin has moved since
  const planes = three.skin.clippingPlanes;
  const hit = ray.intersectObjects(meshes).find(({ point }) => planes.every((plane) => plane.distanceToPoint(point) > -1e-3));
  if (!hit) return null;
  const at = (vertex) => (hit.object.userData.field ?? three.field)[vertex];
  return hit.barycoord.dot(new THREE.Vector3(at(hit.face.a), at(hit.face.b), at(hit.face.c)));
}

// Without a graphics card smooth edges and fine pixels cost more than they are worth.
let software = null;
function drawnBySoftware() {
  if (software !== null) return software;
  const gl = document.createElement("canvas").getContext("webgl");
  const told = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  software = /swiftshader|llvmpipe|software/i.test(name);
  return software;
}

function addGroup(scene) {
  const group = new THREE.Group();
  scene.add(group);
  return group;
}

function loadShell(three, shell) {
  const { rest, triangles } = shell.arrays;
  three.pivot.clear();
  three.fixed.clear();
  const geometry = new THREE.BufferGeometry();
  three.positions = new THREE.BufferAttribute(new Float32Array(rest), 3);
  three.colours = new THREE.BufferAttribute(new Float32Array(rest.length), 3);
  three.moved = new Float32Array(rest.length);
  three.field = new Float32Array(rest.length / 3);
  geometry.setAttribute("position", three.positions);
  geometry.setAttribute("color", three.colours);
  geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(triangles), 1));
  geometry.computeVertexNormals();
  three.geometry = geometry;
  const skin = new THREE.MeshPhongMaterial({ vertexColors: true, side: THREE.DoubleSide, shininess: 18, specular: 0x222222 });
  const whole = (three.whole = new THREE.Mesh(geometry, skin));
  three.skin = skin;
  three.section = buildSection();
  three.other = new THREE.Mesh(geometry, skin);
  three.other.visible = false;
  three.other.scale.set(-1, 1, 1);
  [whole, three.section, three.other].forEach((mesh) => (mesh.frustumCulled = false));
  three.pivot.add(whole, three.section, three.other, buildWall(three, shell.meta));
  buildMarkers(three, shell);
  three.fixed.add(buildClamps(shell.arrays.clamps));
}

function buildWall(three, meta) {
  const size = 2.5 * meta.outer_radius_mm;
  const pane = new THREE.Mesh(
    new THREE.PlaneGeometry(size, size),
    new THREE.MeshBasicMaterial({ color: 0x8fa3b5, transparent: true, opacity: 0.22, side: THREE.DoubleSide, depthWrite: false }),
  );
  const edge = new THREE.LineSegments(new THREE.EdgesGeometry(pane.geometry), new THREE.LineBasicMaterial({ color: 0x7b8fa1 }));
  pane.add(edge);
  pane.renderOrder = 2;
  pane.frustumCulled = false;
  three.pane = pane;
  return pane;
}

// A flange outward from every outer edge that is clamped: its face, rim and back.
function buildClamps(edges) {
  const [count, size] = edges.shape;
  const points = [];
  const corners = [];
  for (let i = 0; i < count * size; i++) {
    const [x, y, z] = edges.subarray(3 * i, 3 * i + 3);
    const out = 1 + CLAMP_MM[0] / Math.hypot(x, y);
    const back = i < size ? z - CLAMP_MM[1] : z + CLAMP_MM[1];
    for (const [share, level] of [[1, z], [out, z], [out, back], [1, back], [1, z]]) points.push(share * x, share * y, level);
    for (let k = 0; i % size && k < 4; k++) {
      const at = 5 * i + k;
      corners.push(at - 5, at - 4, at, at, at - 4, at + 1);
    }
  }
  const strip = new THREE.BufferGeometry();
  strip.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points), 3));
  strip.setIndex(corners);
  return new THREE.Mesh(strip, new THREE.MeshPhongMaterial({ color: 0xb4bfc9, side: THREE.DoubleSide, flatShading: true }));
}

function buildMarkers(three, shell) {
  const count = shell.arrays.rest_px.length / 2;
  const ball = new THREE.SphereGeometry(shell.meta.marker_diameter_mm * 0.4, ...(three.soft ? [10, 6] : [12, 8]));
  three.balls = new THREE.InstancedMesh(ball, three.soft
    ? new THREE.MeshBasicMaterial({ color: 0x14181d }) : new THREE.MeshPhongMaterial({ color: 0x14181d, shininess: 40 }), count);
  three.balls.frustumCulled = false;
  three.trails = new THREE.LineSegments(
    new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ color: 0xd55e00 }));
  three.trails.frustumCulled = false;
  three.fixed.add(three.balls, three.trails);
}

function placeWall(three, slot, depth) {
  const { normal, touch_mm: touch, way } = slot.motion.meta;
  three.pane.visible = stage.look.wall;
  // a hair above the surface, or pane and skin would flicker through each other
  const lift = 0.08;
  three.pane.position.set(...touch.map((at, i) => at + lift * normal[i] - depth * way[i]));
  three.pane.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...normal));
}

function placeMarkers(three, slot, place) {
  const { positions } = slot.markers.arrays;
  const [images, count] = positions.shape;
  three.balls.visible = stage.look.markers;
  three.trails.visible = stage.look.markers && stage.look.trails;
  const image = Math.min(place.image, images - 1);
  const at = { image, next: Math.min(place.next, images - 1), share: place.share };
  const now = between(positions, count * 3, at, new Float32Array(count * 3));
  const matrix = new THREE.Matrix4();
  const away = cutAway(positions, count, slot.shell.meta.turned ? stage.pose.azimuth : 0);
  for (let m = 0; m < count; m++) {
    if (away(m)) {
      three.balls.setMatrixAt(m, matrix.makeScale(0, 0, 0));
      continue;
    }
    three.balls.setMatrixAt(m, matrix.makeTranslation(now[3 * m], now[3 * m + 1], now[3 * m + 2]));
  }
  three.balls.instanceMatrix.needsUpdate = true;
  const points = roomFor(three.trails.geometry, images * count * 6);
  let used = 0;
  for (let m = 0; m < count; m++) {
    if (away(m)) continue;
    for (let k = 0; k <= image; k++) {
      points.set(positions.subarray(3 * (k * count + m), 3 * (k * count + m) + 3), used);
      points.set(k < image ? positions.subarray(3 * ((k + 1) * count + m), 3 * ((k + 1) * count + m) + 3)
        : now.subarray(3 * m, 3 * m + 3), used + 3);
      used += 6;
    }
  }
  three.trails.geometry.setDrawRange(0, used / 3);
}

// The coordinates of a line that is drawn anew in every picture: one buffer, made again only to be larger.
function roomFor(geometry, size) {
  let place = geometry.getAttribute("position");
  if (!place || place.array.length < size) {
    geometry.dispose();
    place = new THREE.BufferAttribute(new Float32Array(size), 3).setUsage(THREE.DynamicDrawUsage);
    geometry.setAttribute("position", place);
  }
  place.needsUpdate = true;
  return place.array;
}

// Whether a marker sits on the part that is cut away: on the far side of the cut at rest.
function cutAway(positions, count, azimuth) {
  if (!stage.look.cut) return () => false;
  const angle = (azimuth * Math.PI) / 180;
  const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
  return (m) => m < count && positions[3 * m] * cos + positions[3 * m + 1] * sin < stage.pose.cut_at - 0.1;
}

// Normals of the drawn half; in the mirror plane they lie in it, so that no crease shows.
function smooth(three, seam) {
  three.geometry.computeVertexNormals();
  const normals = three.geometry.getAttribute("normal");
  for (let i = 0; i < seam.length; i++) {
    if (!seam[i]) continue;
    const [y, z] = [normals.getY(i), normals.getZ(i)];
    const length = Math.hypot(y, z) || 1;
    normals.setXYZ(i, 0, y / length, z / length);
  }
  normals.needsUpdate = true;
}
