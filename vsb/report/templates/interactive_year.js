// A campaign's page: energies, gains and matrices of a year at the damping the reader chooses.
"use strict";

const MATRIX = { width: 720, left: 44, top: 8, cell: 26, bottom: 40 };

/** The interactive part of a campaign's page. */
class InteractiveYear {
  constructor(data, root) {
    this.data = data;
    this.bins = unpackedBins(data.bins);
    this.points = data.points.map(unpackedPoint);
    this.reference = data.designs.findIndex((design) => design.reference);
    this.part = (name) => root.querySelector(`[data-part="${name}"]`);
    const options = data.points.map((point, i) => new Option(point.words, i));
    this.part("point").replaceChildren(...options);
    this.part("points").hidden = options.length < 2;
    this.part("point").addEventListener("change", (event) => this.choose(Number(event.target.value)));
    this.part("matrix-of").addEventListener("change", () => this.show());
    this.part("damper").addEventListener("input", (event) => this.drag(Math.exp(Number(event.target.value))));
    this.part("own").addEventListener("click", () => this.drag(null));
    this.part("given").addEventListener("click", () => this.drag(this.point.given.find((value) => value !== null)));
    this.choose(0);
    root.hidden = false;
  }

  /** Go to a point of the campaign, each design at its optimal damping for the year. */
  choose(index) {
    this.point = this.points[index];
    const { ports, given } = this.point;
    this.squares = yearSquares(this.bins, this.point);
    this.own = ports.map((port) => (port ? bestDamper(port, this.squares) : null));
    const known = this.own.filter((value) => value > 0);
    this.reach = { low: Math.min(...known) / 30, high: Math.max(...known) * 30 };
    if (!known.length) this.reach = { low: 1, high: 1e6 };
    const { low, high } = this.reach;
    Object.assign(this.part("damper"), { min: Math.log(low), max: Math.log(high), step: "any" });
    const dampers = Float64Array.from({ length: 61 }, (_, i) => low * (high / low) ** (i / 60));
    this.curves = ports.map((port) => port && { x: dampers, y: dampers.map((c) => this.energy(power(port, this.squares, c))) });
    const same = given.filter((value) => value !== null);
    this.part("given").hidden = !same.length || same.some((value) => value !== same[0]);
    this.part("matrix-of").replaceChildren(...this.choices());
    this.drag(null);
  }

  /** Choices of the matrix: powers of each design, gains of all but the rigid one. */
  choices() {
    const there = this.data.designs.map((design, i) => ({ ...design, i })).filter(({ i }) => this.point.ports[i]);
    const rigid = there.find((design) => design.i === this.reference);
    const others = rigid ? there.filter((design) => design !== rigid) : [];
    const gains = others.map(({ name, i }) => new Option(`gain of ${name} over ${rigid.name} [%]`, `gain ${i}`));
    return [...gains, ...there.map(({ name, i }) => new Option(`mean power of ${name} [kW]`, `power ${i}`))];
  }

  /** Energy of a year's mean power [MWh]. */
  energy(mean) {
    return (mean * this.data.hours) / 1e6;
  }

  /** One damping for all designs, or null: optimal for each. */
  drag(damping) {
    this.damping = damping;
    this.show();
  }

  /** Show all of it. */
  show() {
    const { ports, weights } = this.point;
    const used = this.own.map((own) => (own === null ? null : this.damping ?? own));
    this.matrices = ports.map((port, i) => port && binPowers(this.bins, weights, port, used[i]));
    const means = this.matrices.map((matrix) => matrix && dot(matrix, this.bins.share));
    const shown = this.damping ?? Math.max(...this.own);
    this.part("damper").value = Math.log(shown || 1);
    this.part("damper-says").textContent = this.damping === null ? "its optimum for each design" : `${plain(this.damping)} ${this.data.port.damping}`;
    this.table(used, means);
    this.overDamper(used, means);
    this.matrix();
  }

  /** The table: gain, energy, damping, capture width, share of the optimum; the gain is seen on a narrow screen, too. */
  table(used, means) {
    const over = gains(means, this.reference);
    const rows = means.flatMap((mean, i) => {
      if (mean === null) return [];
      const best = power(this.point.ports[i], this.squares, this.own[i]);
      const gain = signed(over[i], 2);
      const share = best > 0 ? (100 * mean) / best : null;
      const numbers = [this.energy(mean), used[i], mean / this.point.flux, share].map(plain);
      const design = this.data.designs[i];
      return [tableRow([design.name, gain, ...numbers], design)];
    });
    this.part("rows").replaceChildren(...rows);
  }

  /** Chart of annual energy against damping. */
  overDamper(used, means) {
    const there = this.data.designs.map((design, i) => ({ ...design, i })).filter(({ i }) => this.curves[i]);
    const top = Math.max(...there.flatMap(({ i }) => [...this.curves[i].y]), 1e-9);
    const marks = there.map(({ i, colour }) => ({ x: used[i], y: this.energy(means[i]), colour }));
    if (this.damping !== null) marks.unshift({ x: this.damping });
    chart(this.part("over-damper"), {
      x: { label: `damping [${this.data.port.damping}]`, log: true, ...this.reach },
      y: { label: "energy [MWh/year]", low: 0, high: 1.08 * top },
      width: NARROW ? CHART.width : 760, // as wide as the text, with letters of its size
      curves: there.map((design) => ({ ...design, ...this.curves[design.i] })),
      marks: marks.filter((mark) => mark.x > 0),
      words: `Annual energy against damping: ${there.map(({ name, i }) => `${name} at most ${plain(Math.max(...this.curves[i].y))} MWh at ${plain(this.own[i])} ${this.data.port.damping}`).join(", ")}`,
    });
  }

  /** Mean power or gain in every bin of height and period. */
  matrix() {
    const [what, index] = this.part("matrix-of").value.split(" ");
    const own = this.matrices[Number(index)];
    const rigid = this.matrices[this.reference];
    const values = Array.from(own, (v, k) => (what === "gain" ? 100 * (v / rigid[k] - 1) : v / 1e3));
    const sizes = values.map(Math.abs).sort((a, b) => a - b);
    const largest = (what === "gain" ? sizes[Math.floor(0.95 * (sizes.length - 1))] : sizes.at(-1)) || 1;
    const { row, column, hs, te } = this.bins;
    const first = Math.min(...column);
    const last = Math.max(...column);
    const rows = Math.max(...row) + 1;
    const { left, top, cell, bottom } = MATRIX;
    const wide = (MATRIX.width - left - 4) / (last - first + 1);
    const height = top + rows * cell + bottom;
    const svg = this.part("matrix");
    svg.setAttribute("viewBox", `0 0 ${MATRIX.width} ${height}`);
    const shown = values.map((value, k) => {
      const [x, y] = [left + (column[k] - first) * wide, top + (rows - 1 - row[k]) * cell];
      const strength = Math.min(1, Math.abs(value) / largest);
      const colour = what === "gain" && value < 0 ? "213,94,0" : "0,114,178";
      const group = drawn("g", {});
      group.append(drawn("rect", { x, y, width: wide - 1, height: cell - 1, fill: `rgba(${colour},${0.06 + 0.6 * strength})` }));
      const text = what === "gain" ? value.toFixed(Math.abs(value) < 9.95 ? 1 : 0) : String(Number(value.toPrecision(2)));
      group.append(drawn("text", { x: x + wide / 2, y: y + cell / 2 + 4, class: "middle" }, text.replace(/^-(?=0\.0$)/, "").replace("-", "−")));
      return group;
    });
    for (let i = 0; i < rows; i++) {
      shown.push(drawn("text", { x: left - 5, y: top + (rows - 1 - i) * cell + cell / 2 + 4, class: "end" }, plain(hs[i])));
    }
    for (let j = first; j <= last; j++) {
      shown.push(drawn("text", { x: left + (j - first + 0.5) * wide, y: height - bottom + 14, class: "middle" }, plain(te[j])));
    }
    shown.push(drawn("text", { x: MATRIX.width / 2, y: height - 6, class: "middle" }, "energy period Te [s]"));
    const middle = top + (rows * cell) / 2;
    shown.push(drawn("text", { x: 11, y: middle, class: "middle", transform: `rotate(-90 11 ${middle})` }, "Hs [m]"));
    svg.replaceChildren(...shown);
    const words = this.part("matrix-of").selectedOptions[0].textContent;
    svg.setAttribute("aria-label", `${words} by height and period: ${plain(Math.min(...values))} to ${plain(Math.max(...values))}`);
  }
}
