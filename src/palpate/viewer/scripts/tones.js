// Colours of the skin by a quantity, in one range for all designs on the stage: equal colours are equal values.
import { THREE } from "nicegui-scene";
import { between, CIVIDIS, FIELDS, mix, stage, VIRIDIS } from "palpate-stage";

export const FAR_MM = 2;
const TABLE = 256;
const TABLES = { displacement: VIRIDIS, stress: VIRIDIS, pressure: VIRIDIS, contact: CIVIDIS };
const GREY = 0.45;

// Whether the quantity of the colour is missing: stress that is not computed yet, or a skin that was not pressed.
export function isBlank(slot) {
  const { colour: name } = stage.look;
  return name !== "contact" && (slot.motion.meta.depths_mm.length < 2 || !slot.motion.arrays[name]);
}

export function topOfAll() {
  return Math.max(...Object.values(stage.slots).map((slot) => (slot.motion && !isBlank(slot) ? maximum(slot.motion) : 0))) || 1;
}

function maximum(motion) {
  const name = stage.look.colour;
  motion.tops ??= {};
  if (name in motion.tops) return motion.tops[name];
  let top = 0;
  if (FIELDS.includes(name)) {
    for (const value of motion.arrays[name]) top = Math.max(top, value);
  } else {
    const values = motion.arrays.displacement;
    for (let i = 0; i < values.length; i += 3) top = Math.max(top, Math.hypot(values[i], values[i + 1], values[i + 2]));
  }
  motion.tops[name] = top;
  return top;
}

export function ramp(name) {
  return name === "contact" ? [...CIVIDIS].reverse() : TABLES[name];
}

const tables = {};
function table(name) {
  if (!tables[name]) {
    const steps = ramp(name);
    tables[name] = new Float32Array(TABLE * 3);
    for (let i = 0; i < TABLE; i++) {
      const tone = new THREE.Color(...mix(steps, i / (TABLE - 1))).convertSRGBToLinear();
      tables[name].set([tone.r, tone.g, tone.b], 3 * i);
    }
  }
  return tables[name];
}

export function colour(three, slot, place, top) {
  const out = three.colours.array;
  three.colours.needsUpdate = true;
  if (isBlank(slot)) {
    out.fill(GREY);
    return;
  }
  const { field, moved } = three;
  const name = stage.look.colour;
  if (FIELDS.includes(name)) {
    between(slot.motion.arrays[name], field.length, place, field);
  } else if (name === "contact") {
    const { normal: n, touch_mm: touch, way } = slot.motion.meta;
    const at = three.positions.array;
    const level = n.reduce((sum, part, i) => sum + part * (touch[i] - place.depth * way[i]), 0);
    for (let i = 0; i < field.length; i++) {
      field[i] = level - (n[0] * at[3 * i] + n[1] * at[3 * i + 1] + n[2] * at[3 * i + 2]);
    }
  } else {
    for (let i = 0; i < field.length; i++) field[i] = Math.hypot(moved[3 * i], moved[3 * i + 1], moved[3 * i + 2]);
  }
  const scale = (TABLE - 1) / (name === "contact" ? FAR_MM : top);
  const tones = table(name);
  for (let i = 0; i < field.length; i++) {
    const step = 3 * Math.min(Math.max(Math.round(field[i] * scale), 0), TABLE - 1);
    out[3 * i] = tones[step];
    out[3 * i + 1] = tones[step + 1];
    out[3 * i + 2] = tones[step + 2];
  }
}
