// A study's page: powers, capture widths and gains at the damping, or peak period, the reader chooses.
"use strict";

/** The interactive part of a study's page. */
class InteractiveStudy {
  constructor(data, root) {
    this.data = data;
    this.root = root;
    this.grids = data.grids.map(unpackedGrid);
    this.bands = data.bands.map(unpackedGrid);
    this.limit = unpacked(data.limit);
    root.querySelector('[data-part="bound"]').textContent = data.bound;
    this.reference = data.designs.findIndex((design) => design.reference);
    this.damping = null; // each design at its optimal damping
    this.part = (name) => root.querySelector(`[data-part="${name}"]`);
    this.listen();
    this.choose(0);
    root.hidden = false;
  }

  /** Connect the controls. */
  listen() {
    const words = this.data.seas.map((sea) => sea.words);
    this.part("sea").replaceChildren(...words.map((text, i) => new Option(text, i)));
    this.part("seas").hidden = words.length < 2;
    this.part("sea").addEventListener("change", (event) => this.choose(Number(event.target.value)));
    this.part("damper").addEventListener("input", (event) => {
      this.damping = Math.exp(Number(event.target.value));
      this.show();
    });
    this.part("own").addEventListener("click", () => {
      this.damping = null;
      this.show();
    });
    this.part("given").addEventListener("click", () => {
      this.damping = this.sea.given[0];
      this.show();
    });
    this.part("period").addEventListener("input", (event) => this.swell(Number(event.target.value)));
    this.part("take-off").addEventListener("change", () => this.show());
    this.part("limit").addEventListener("input", () => this.show());
  }

  /** Go to a sea as the study has it. */
  choose(index) {
    this.sea = this.data.seas[index];
    this.grid = this.grids[this.sea.grid];
    this.band = this.bands[this.sea.band];
    const { jonswap, limited, given, steps } = this.sea;
    this.part("periods").hidden = !jonswap;
    if (jonswap) {
      Object.assign(this.part("period"), { min: jonswap.shortest, max: jonswap.longest, step: 0.01 });
      this.part("period").value = jonswap.tp;
    }
    this.part("given").hidden = given[0] === null || given.some((value) => value !== given[0]);
    this.part("within").hidden = limited.every((value) => value === null);
    this.part("limited").hidden = !steps;
    Object.assign(this.part("limit"), { max: steps ? steps.limits.length - 1 : 0 });
    this.part("limit").value = 2;
    this.part("take-off").value = "damper";
    this.swell(jonswap ? jonswap.tp : null);
  }

  /** Use the sea with a peak period: its components and optimal dampings. */
  swell(tp) {
    this.tp = tp;
    this.squares = seaSquares(this.sea, this.grid, tp);
    this.flux = dot(this.squares, this.grid.flux);
    this.own = this.grid.ports.map((port) => bestDamper(port, this.squares));
    const known = this.own.filter((value) => value > 0);
    const [low, high] = known.length ? [Math.min(...known) / 30, Math.max(...known) * 30] : [1, 1e6];
    Object.assign(this.part("damper"), { min: Math.log(low), max: Math.log(high), step: "any" });
    this.reach = { low, high };
    this.curves = this.powerOverDamper();
    this.show();
  }

  /** Mean power against damping, of every design. */
  powerOverDamper() {
    const { low, high } = this.reach;
    const dampers = Float64Array.from({ length: 61 }, (_, i) => low * (high / low) ** (i / 60));
    return this.grid.ports.map((port) => ({ x: dampers, y: dampers.map((c) => this.powerUnder(port, c)) }));
  }

  /** Mean electrical power at a damping in the sea [W]. */
  powerUnder(port, damping) {
    return this.data.efficiency * power(port, this.squares, damping);
  }

  /** Damping, if any, and power of each design with the chosen take-off [W]. */
  absorbed() {
    const how = this.part("take-off").value;
    return this.grid.ports.map((port, i) => {
      if (how === "matched") return { damping: null, power: this.data.efficiency * dot(this.squares, port.matched) };
      if (how === "within") return { damping: null, power: this.sea.limited[i] };
      if (how === "limited") return { damping: null, power: this.sea.steps.powers[i][Number(this.part("limit").value)] };
      const damping = this.damping ?? this.own[i];
      return { damping, power: this.powerUnder(port, damping) };
    });
  }

  /** Show all of it. */
  show() {
    const moved = this.tp !== null && this.tp !== this.sea.jonswap.tp;
    for (const name of ["within", "limited"]) {
      this.part(name).disabled = this.part(name).hidden || moved;
      if (this.part(name).disabled && this.part("take-off").value === name) this.part("take-off").value = "damper";
    }
    const how = this.part("take-off").value;
    this.part("dampers").hidden = how !== "damper";
    this.part("limits").hidden = how !== "limited";
    this.part("over-band").parentNode.hidden = how === "within" || how === "limited"; // such a force mixes frequencies
    const banded = !this.part("over-band").parentNode.hidden;
    this.part("common").hidden = how === "damper" ? this.damping === null : how !== "limited";
    this.part("at-wave").hidden = !banded || this.squares.length > 1;
    this.part("spectrum").hidden = !banded || this.squares.length === 1;
    this.part("limited-by").hidden = !banded || !this.data.bound; // none is known of a body
    const found = this.absorbed();
    const shown = this.damping ?? Math.max(...this.own);
    this.part("damper").value = Math.log(shown || 1);
    this.part("damper-says").textContent = this.damping === null ? "its optimum for each design" : `${plain(this.damping)} ${this.data.port.damping}`;
    this.part("period-says").textContent = this.tp === null ? "" : `${this.tp.toFixed(2)} s`;
    this.table(found);
    if (how === "limited") this.overLimit(found);
    else this.overDamper(found);
    this.overBand(found);
  }

  /** The table: gain, power, damping, capture width, share of the optimum; the gain is seen on a narrow screen, too. */
  table(found) {
    const over = gains(found.map((one) => one.power), this.reference);
    const rows = found.map((one, i) => {
      const best = this.powerUnder(this.grid.ports[i], this.own[i]);
      const gain = signed(over[i], 1);
      const width = one.power === null ? null : one.power / this.flux;
      const share = one.power === null || !(best > 0) ? null : (100 * one.power) / best;
      return [this.data.designs[i].name, gain, ...[one.power, one.damping, width, share].map(plain)];
    });
    this.part("rows").replaceChildren(...rows.map((cells, i) => tableRow(cells, this.data.designs[i])));
  }

  /** Chart of mean power against damping. */
  overDamper(found) {
    const top = Math.max(...this.curves.flatMap((curve) => [...curve.y]), 1e-9);
    const marks = found.flatMap((one, i) => {
      const colour = this.data.designs[i].colour;
      return one.damping > 0 ? [{ x: one.damping, y: one.power / 1e3, colour }] : [];
    });
    if (this.damping !== null) marks.unshift({ x: this.damping });
    const curves = this.curves.map((curve, i) => ({ ...this.data.designs[i], x: curve.x, y: curve.y.map((v) => v / 1e3) }));
    chart(this.part("over-damper"), {
      x: { label: `damping [${this.data.port.damping}]`, log: true, ...this.reach },
      y: { label: "mean power [kW]", low: 0, high: (1.08 * top) / 1e3 },
      curves,
      marks,
      words: `Mean power against damping: ${this.data.designs.map((d, i) => `${d.name} at most ${plain(Math.max(...this.curves[i].y))} W at ${plain(this.own[i])} ${this.data.port.damping}`).join(", ")}`,
    });
  }

  /** Chart of mean power of the optimal load within a limit against that limit. */
  overLimit(found) {
    const { limits, of, repeats, powers } = this.sea.steps;
    const limit = limits[Number(this.part("limit").value)];
    const share = `${plain((100 * limit) / limits.at(-1))} % of what optimal damping of ${of} needs`;
    const again = repeats === null ? "" : `; waves assumed to repeat after ${plain(repeats)} s`;
    this.part("limit-says").textContent = `${plain(limit / 1e3)} k${this.data.port.load_unit}, ${share}${again}`;
    const curves = powers.map((power, i) => {
      const known = [...power.keys()].filter((k) => power[k] !== null);
      return { ...this.data.designs[i], x: known.map((k) => limits[k] / 1e3), y: known.map((k) => power[k] / 1e3) };
    });
    const dots = found.map(({ power }, i) => ({ x: limit / 1e3, y: power / 1e3, colour: this.data.designs[i].colour, power }));
    chart(this.part("over-damper"), {
      x: { label: `${this.data.port.load} limit [k${this.data.port.load_unit}]`, log: true, low: limits[0] / 1e3, high: limits.at(-1) / 1e3 },
      y: { label: "mean power [kW]", low: 0, high: Math.max(...curves.flatMap((curve) => curve.y), 1e-9) * 1.08 },
      curves: curves.filter((curve) => curve.x.length),
      marks: [{ x: limit / 1e3 }, ...dots.filter((dot) => dot.power !== null)],
      words: `Mean power of the optimal ${this.data.port.load} within a limit: ${curves.map((c) => `${c.name} at most ${plain(1e3 * Math.max(...c.y, 0))} W`).join(", ")} at ${plain(limits.at(-1) / 1e3)} k${this.data.port.load_unit}`,
    });
  }

  /** Chart of absorbed power per squared amplitude over frequency, with the limit and the sea. */
  overBand(found) {
    const { omega, ports } = this.band;
    const { limit } = this;
    const curves = ports.map((port, i) => {
      const damping = found[i].damping;
      const value = (_, j) => (damping === null ? port.matched[j] : powerAt(port, j, damping)) / 1e3;
      return { ...this.data.designs[i], x: omega, y: Float64Array.from(omega, value) };
    });
    const top = 1.15 * Math.max(...this.curvesTop(), 1e-9);
    const low = [...omega.keys()].filter((j) => this.data.bound && limit[j] / 1e3 <= top);
    const bound = { x: low.map((j) => omega[j]), y: low.map((j) => limit[j] / 1e3) };
    const clipped = { name: this.data.bound, colour: "#999999", dash: "", ...bound };
    const largest = Math.max(...this.squares);
    const sea = this.squares.length > 1 ? [{ x: this.grid.omega, y: this.squares.map((v) => (0.3 * top * v) / largest) }] : [];
    const inside = sea.map((area) => {
      const kept = [...area.x.keys()].filter((j) => area.x[j] >= omega[0] && area.x[j] <= omega.at(-1));
      return { x: kept.map((j) => area.x[j]), y: kept.map((j) => area.y[j]) };
    });
    const marks = this.squares.length === 1 ? [{ x: this.grid.omega[0] }] : [];
    chart(this.part("over-band"), {
      x: { label: "wave frequency [rad/s]", low: omega[0], high: omega.at(-1) },
      y: { label: "power per amplitude² [kW/m²]", low: 0, high: top },
      curves: [clipped, ...curves.map((curve) => ({ ...curve, y: curve.y.map((v) => Math.min(v, top)) }))],
      areas: inside,
      marks,
      words: `Absorbed power per squared amplitude over wave frequency: ${curves.map((c) => `${c.name} at most ${plain(Math.max(...c.y))} kW/m²`).join(", ")}`,
    });
  }

  /** Largest powers at any damping over the band [kW/m^2], for a constant axis. */
  curvesTop() {
    this.band.highest ??= this.band.ports.map((port) => {
      const best = (_, j) => powerAt(port, j, Math.hypot(port.resistance[j], port.reactance[j]));
      return Math.max(...Float64Array.from(this.band.omega, best)) / 1e3;
    });
    return this.band.highest;
  }
}
