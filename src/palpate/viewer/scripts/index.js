// The stage: one pose and one look that every drawing on the page shares, and the designs that are shown.
// A design's triangles are fetched once, its motion once a tilt (of a skin that is not of revolution once a pose), its
// markers once a pose; depths are gone through here.

export const VIRIDIS = ["#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21918c", "#22a884", "#44bf70",
  "#7ad151", "#bddf26", "#fde725"];
export const CIVIDIS = ["#00224e", "#083370", "#35456c", "#4f576c", "#666970", "#7d7c78", "#948e77", "#aea371",
  "#c8b866", "#e5cf52", "#fee838"];

// Fields that the server computes on request.
export const FIELDS = ["stress", "pressure"];

const listeners = new Set();
let drawn = false;

export const stage = {
  pose: { depth: 0, tilt: 0, azimuth: 0, cut_at: 0 },
  look: { colour: "displacement", cut: true, markers: true, trails: true, wall: true, dark: false },
  slots: { a: emptySlot(), b: emptySlot() },
  fault: "",
};

function emptySlot() {
  return { name: null, shell: null, motion: null, markers: null, busy: false };
}

// Call `draw` once before each picture in which something changed.
export function listen(draw) {
  listeners.add(draw);
  return () => listeners.delete(draw);
}

export function changed() {
  if (drawn) return;
  drawn = true;
  requestAnimationFrame(() => {
    drawn = false;
    listeners.forEach((draw) => draw());
  });
}

export async function show(name, slotName) {
  const slot = stage.slots[slotName];
  if (!name) {
    stage.slots[slotName] = emptySlot();
    changed();
    return;
  }
  if (slot.name === name) return;
  const shell = await ask(`/data/shell/${encodeURIComponent(name)}`);
  if (!shell) return;
  if (stage.slots[slotName] !== slot) return;
  Object.assign(slot, { name, shell, motion: null, markers: null });
  changed();
  await follow(slotName);
}

export function setPose(pose) {
  const before = { ...stage.pose };
  Object.assign(stage.pose, pose);
  changed();
  if (before.tilt !== stage.pose.tilt || before.azimuth !== stage.pose.azimuth) {
    Object.keys(stage.slots).forEach((name) => follow(name));
  }
}

export function setLook(look) {
  const before = stage.look.colour;
  Object.assign(stage.look, look);
  changed();
  if (before !== stage.look.colour) Object.keys(stage.slots).forEach((name) => follow(name));
}

// Fetch what the present pose needs; while an answer is on its way only the newest wish is kept.
async function follow(slotName) {
  const slot = stage.slots[slotName];
  if (!slot.name) return;
  if (slot.busy) {
    slot.again = true;
    return;
  }
  slot.busy = true;
  do {
    slot.again = false;
    await fetchPose(slot);
  } while (slot.again);
  slot.busy = false;
}

async function fetchPose(slot) {
  const name = slot.name;
  const tilts = slot.shell.meta.tilts_deg;
  const tilt = Math.min(Math.max(stage.pose.tilt, tilts[0]), tilts[tilts.length - 1]);
  const azimuth = stage.pose.azimuth;
  const way = slot.shell.meta.turned ? 0 : azimuth;
  const field = FIELDS.includes(stage.look.colour) ? stage.look.colour : "";
  const known = slot.motion && slot.motion.tilt === tilt && slot.motion.way === way && (!field || slot.motion.arrays[field]);
  const [motion, markers] = await Promise.all([
    known ? slot.motion : ask(`/data/motion/${encodeURIComponent(name)}?tilt=${tilt}&azimuth=${way}&field=${field}`),
    ask(`/data/markers/${encodeURIComponent(name)}?tilt=${tilt}&azimuth=${azimuth}`),
  ]);
  if (slot.name !== name || !motion || !markers) return;
  Object.assign(motion, { tilt, way });
  Object.assign(slot, { motion, markers, azimuth });
  changed();
}

async function ask(address) {
  try {
    const response = await fetch(address);
    if (response.ok) {
      say("");
      return readMessage(await response.arrayBuffer());
    }
    const said = await response.json().catch(() => ({ problem: `The server answered ${response.status}.` }));
    say([said.problem, said.remedy].filter(Boolean).join(" ") || "The server did not understand the page.");
  } catch {
    say("The server does not answer. Is palpate still running?");
  }
  return null;
}

function say(sentence) {
  if (stage.fault === sentence) return;
  stage.fault = sentence;
  changed();
}

export function readMessage(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const arrays = {};
  for (const [name, [kind, offset, shape]] of Object.entries(head.arrays)) {
    const count = shape.reduce((product, size) => product * size, 1);
    const Values = kind === "f4" ? Float32Array : Uint32Array;
    arrays[name] = Object.assign(new Values(buffer, 4 + length + offset, count), { shape });
  }
  return { meta: head.meta, arrays };
}

// Where the present depth lies between the images: number of the one above and the share of the way to the next.
export function placeOf(motion, depth = stage.pose.depth) {
  const depths = motion.meta.depths_mm;
  const last = depths.length - 1;
  if (depth >= depths[last]) return { image: last, next: last, share: 0, depth: depths[last] };
  const image = Math.max(0, depths.findIndex((value) => value > depth) - 1);
  return { image, next: image + 1, share: (depth - depths[image]) / (depths[image + 1] - depths[image]), depth };
}

export function between(values, width, place, out) {
  const a = place.image * width;
  const b = place.next * width;
  for (let i = 0; i < width; i++) out[i] = values[a + i] + place.share * (values[b + i] - values[a + i]);
  return out;
}

export function mix(steps, share) {
  const at = Math.min(Math.max(share, 0), 1) * (steps.length - 1);
  const low = Math.min(Math.floor(at), steps.length - 2);
  const channel = (step, i) => parseInt(step.slice(1 + 2 * i, 3 + 2 * i), 16) / 255;
  return [0, 1, 2].map((i) => channel(steps[low], i) + (at - low) * (channel(steps[low + 1], i) - channel(steps[low], i)));
}

export function save(name, content, type) {
  const link = document.createElement("a");
  link.href = typeof content === "string" && content.startsWith("data:")
    ? content : URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
