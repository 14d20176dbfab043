// The sensor's image with its markers: rest as rings, found dots, arrows of displacement, numbers if wished.
const SVG = "http://www.w3.org/2000/svg";

export default {
  props: { label: String },
  template: `<div class="live-view"><p v-if="!begun">No image yet. Choose a source and press Start.</p><svg v-show="begun" ref="svg" role="img" :aria-label="label" xmlns="http://www.w3.org/2000/svg"></svg></div>`,
  data: () => ({ begun: false }),
  methods: {
    begin(width, height, rest) {
      this.begun = true;
      const svg = this.$refs.svg;
      svg.setAttribute("viewBox", `-0.5 -0.5 ${width} ${height}`);
      this.picture = make("image", { x: -0.5, y: -0.5, width, height });
      const thin = width / 500;
      const rings = make("g", { fill: "none", stroke: "#0072b2", "stroke-width": thin, opacity: 0.8 });
      const arrows = make("g", { stroke: "#d55e00", "stroke-width": 2 * thin, fill: "none", "stroke-linecap": "round" });
      const dots = make("g", { fill: "none", "stroke-width": 1.6 * thin });
      const words = make("g", { fill: "#d55e00", "font-size": 11 * thin, "text-anchor": "middle" });
      this.rest = rest;
      this.marks = rest.map(([x, y], number) => {
        rings.append(make("circle", { cx: x, cy: y, r: 3 * thin }));
        const mark = { arrow: make("path", {}), dot: make("circle", { r: 5 * thin }), word: make("text", {}) };
        mark.word.textContent = number;
        arrows.append(mark.arrow);
        dots.append(mark.dot);
        words.append(mark.word);
        return mark;
      });
      this.words = words;
      words.style.display = "none";
      svg.replaceChildren(this.picture, rings, arrows, dots, words);
    },
    show(picture, positions, found, stretch) {
      if (picture) this.picture.setAttribute("href", picture);
      positions.forEach(([x, y], m) => {
        const { arrow, dot, word } = this.marks[m];
        const [x0, y0] = this.rest[m];
        dot.setAttribute("cx", x);
        dot.setAttribute("cy", y);
        dot.setAttribute("stroke", found[m] ? "#009e73" : "#cc79a7");
        word.setAttribute("x", x);
        word.setAttribute("y", y - 4);
        arrow.setAttribute("d", `M${x0} ${y0}L${x0 + stretch * (x - x0)} ${y0 + stretch * (y - y0)}`);
      });
      this.$refs.svg.dataset.shown = Number(this.$refs.svg.dataset.shown || 0) + 1;
    },
    number(shown) {
      if (this.words) this.words.style.display = shown ? "" : "none";
    },
  },
};

function make(kind, attributes) {
  const element = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}
