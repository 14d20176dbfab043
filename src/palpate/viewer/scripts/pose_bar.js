// Depth, tilt and azimuth of the wall, and the place of the cut. Sliders move the stage at once; the server hears of it when they rest.
import { changed, listen, placeOf, setLook, setPose, show, stage } from "palpate-stage";

const REST_MS = 250;
const PLAY_MM_S = 2.2;

export default {
  props: { first: Object, alone: Boolean },
  template: `
    <div class="pose-bar" role="group" aria-label="Pose of the wall, and cut">
      <button type="button" class="pose-play" :aria-label="playing ? 'Stop' : 'Play the press'" @click="play">{{ playing ? "❚❚" : "▶" }}</button>
      <label v-for="axis in axes" :key="axis.name">
        <span>{{ axis.title }}</span>
        <input type="range" :aria-label="axis.title + ' in ' + axis.unit" :name="axis.name" :min="axis.low" :max="axis.high"
          :step="axis.step" :value="values[axis.name]" :disabled="axis.high <= axis.low"
          @input="move(axis.name, $event.target.valueAsNumber)">
        <output>{{ values[axis.name].toFixed(axis.digits) }} {{ axis.unit }}</output>
      </label>
    </div>`,
  data() {
    return { playing: false, values: { depth: 0, tilt: 0, azimuth: 0, cut_at: 0 }, deepest: 8, tilts: [0, 12],
      wide: 0, cutting: true };
  },
  computed: {
    axes() {
      const [low, high] = this.tilts;
      return [
        { name: "depth", title: "Depth", unit: "mm", low: 0, high: this.deepest, step: 0.02, digits: 2 },
        { name: "tilt", title: "Tilt", unit: "°", low, high, step: 0.1, digits: 1 },
        { name: "azimuth", title: "Azimuth", unit: "°", low: 0, high: 360, step: 1, digits: 0 },
        { name: "cut_at", title: "Cut", unit: "mm", low: -this.wide, high: this.wide, step: 0.1, digits: 1 },
      ].slice(0, this.cutting ? 4 : 3);
    },
  },
  mounted() {
    Object.assign(this.values, this.first);
    setPose({ ...this.values });
    this.stop = listen(() => this.fit());
  },
  beforeUnmount() {
    this.stop();
    cancelAnimationFrame(this.ticking);
  },
  methods: {
    show(name, slotName) {
      return show(name, slotName);
    },
    look(look) {
      setLook(look);
    },
    pose(pose) {
      Object.assign(this.values, pose);
      setPose({ ...this.values });
    },
    move(name, value) {
      if (name === "depth" && this.playing) this.play();
      this.values[name] = value;
      setPose({ [name]: value });
      this.report();
    },
    report() {
      clearTimeout(this.waiting);
      this.waiting = setTimeout(() => this.$emit("rest", { ...this.values }), REST_MS);
    },
    // The sliders reach as far as the designs on the stage do.
    fit() {
      this.cutting = stage.look.cut;
      const shown = Object.values(stage.slots).filter((slot) => slot.motion);
      if (!shown.length) return;
      const deepest = Math.max(...shown.map((slot) => slot.motion.meta.depths_mm.at(-1)));
      const tilts = shown.map((slot) => slot.shell.meta.tilts_deg);
      this.deepest = deepest;
      this.tilts = [Math.min(...tilts.map((all) => all[0])), Math.max(...tilts.map((all) => all.at(-1)))];
      this.wide = Math.max(...shown.map((slot) => Math.floor(10 * slot.shell.meta.outer_radius_mm) / 10));
      const within = (name, low, high) => Math.min(Math.max(this.values[name], low), high);
      const reached = { depth: within("depth", 0, deepest), tilt: within("tilt", ...this.tilts),
        cut_at: within("cut_at", -this.wide, this.wide) };
      if (Object.keys(reached).some((name) => reached[name] !== this.values[name])) {
        Object.assign(this.values, reached);
        setPose(reached);
      }
    },
    play() {
      this.playing = !this.playing;
      if (!this.playing) {
        this.report();
        return;
      }
      if (this.values.depth >= this.deepest - 1e-6) this.values.depth = 0;
      let before = performance.now();
      const tick = (now) => {
        if (!this.playing) return;
        const depth = Math.min(this.values.depth + ((now - before) / 1000) * PLAY_MM_S, this.deepest);
        before = now;
        this.values.depth = depth;
        setPose({ depth });
        if (depth >= this.deepest) this.play();
        else this.ticking = requestAnimationFrame(tick);
      };
      this.ticking = requestAnimationFrame(tick);
    },
    playWhenReady() {
      const wait = setInterval(() => {
        if (!(stage.slots.a.motion?.meta.depths_mm.length > 1)) return;
        clearInterval(wait);
        this.fit();
        if (!this.playing) this.play();
      }, 50);
      setTimeout(() => clearInterval(wait), 5000);
    },
    told() {
      const slot = stage.slots.a;
      if (!slot.motion) return null;
      const place = placeOf(slot.motion);
      return { depth: place.depth, branch: slot.motion.meta.branch[place.image], ...stage.pose };
    },
    redraw() {
      changed();
    },
  },
};
