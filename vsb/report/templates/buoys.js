// The buoys or the body in the waves, designs side by side: played, paused, or stepped by hand.
"use strict";

class Buoys {
  constructor(data, root) {
    const { shapes } = data;
    this.data = data;
    this.shape = Object.fromEntries(
      Object.entries(shapes).map(([name, value]) => [name, typeof value === "string" ? unpacked(value) : value]),
    );
    this.part = (name) => root.querySelector(`[data-part="${name}"]`);
    this.canvas = this.part("canvas");
    this.part("sea").replaceChildren(...data.seas.map((sea, i) => new Option(sea.words, i)));
    this.part("seas").hidden = data.seas.length < 2;
    this.part("sea").addEventListener("change", (event) => this.choose(Number(event.target.value)));
    this.part("play").addEventListener("click", () => this.play(!this.playing));
    this.part("moment").addEventListener("input", (event) => {
      this.play(false);
      this.draw(Number(event.target.value));
    });
    root.hidden = false;
    this.choose(0);
    addEventListener("resize", () => this.draw(this.frame));
    this.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  /** Go to the first frame of a sea. */
  choose(index) {
    const stored = this.data.seas[index];
    const moved = (value) => (typeof value === "string" ? unpacked(value) : value);
    const designs = stored.designs.map((one) => Object.fromEntries(Object.entries(one).map(([name, value]) => [name, moved(value)])));
    this.sea = { ...stored, surface: unpacked(stored.surface), designs };
    this.across = this.sea.surface.length / this.sea.frames;
    Object.assign(this.part("moment"), { min: 0, max: this.sea.frames - 1, step: 1, value: 0 });
    this.draw(0);
  }

  /** Play, or pause. */
  play(on) {
    this.playing = on;
    this.part("play").textContent = on ? "pause" : "play";
    if (!on) return;
    let [last, moment] = [null, this.frame];
    const step = (now) => {
      if (!this.playing) return;
      moment += last === null ? 0 : Math.min(now - last, 100) / 1000 / this.sea.step;
      last = now;
      if (moment >= this.sea.frames - 1) moment = 0;
      if (Math.floor(moment) !== this.frame) this.draw(Math.floor(moment));
      requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** Points of a meridian about the sphere's centre: x = (r + v) sin + u cos, z = (r + v) cos - u sin.
   * Of the one opposite, where shapes of odd order are the other way, x is counted to its own side. */
  meridian(design, frame, opposite = false) {
    const { colatitude, radial, meridional, rest, order } = this.shape;
    const count = colatitude.length;
    return Array.from(colatitude, (_, i) => {
      let [v, u] = [0, 0];
      for (let n = 0; n < rest.length; n++) {
        const side = opposite && order && order[n] % 2 ? -1 : 1;
        const moved = n < design.modes ? side * this.data.factor * design.shell[frame * design.modes + n] : 0;
        v += (rest[n] + moved) * radial[n * count + i];
        u += (rest[n] + moved) * meridional[n * count + i];
      }
      return this.point(i, v, u);
    });
  }

  /** A point of the meridian moved by v along the sphere's radius and u along its meridian, from its place at rest. */
  point(i, v, u) {
    const { radius, colatitude, rest_radial: beyond, rest_meridional: along } = this.shape;
    const [sine, cosine] = [Math.sin(colatitude[i]), Math.cos(colatitude[i])];
    const [out, down] = beyond ? [radius + beyond[i] + v, along[i] + u] : [radius + v, u];
    return [out * sine + down * cosine, out * cosine - down * sine];
  }

  /** How many designs stand side by side, and the widest piece of water of each. */
  layout(room) {
    const { length } = this.data.designs;
    return [room < 480 ? Math.min(2, length) : length, 260];
  }

  /** What of the height is seen above still water and below, and the factor on waves. */
  seen() {
    return [this.data.width, this.data.width, 1];
  }

  /** Draw a frame: every design in its piece of water. */
  draw(frame) {
    this.frame = frame;
    this.part("moment").value = frame;
    this.part("moment-says").textContent = `${(this.sea.start + frame * this.sea.step).toFixed(2)} s`;
    const { designs, width } = this.data;
    const [columns, widest] = this.layout(this.canvas.clientWidth);
    const cell = Math.min(this.canvas.clientWidth / columns, widest);
    const scale = (cell / 2 - 4) / width;
    const [top, bottom] = this.seen().map((height) => height * scale);
    const row = top + bottom + 26;
    const ratio = globalThis.devicePixelRatio || 1;
    this.canvas.style.height = `${row * Math.ceil(designs.length / columns)}px`;
    this.canvas.width = this.canvas.clientWidth * ratio;
    this.canvas.height = this.canvas.clientHeight * ratio;
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    designs.forEach((design, i) => {
      pen.save();
      pen.translate((i % columns) * cell + cell / 2, Math.floor(i / columns) * row + top + 18);
      this.drawWater(pen, design, frame, scale);
      this.drawHull(pen, design, this.sea.designs[i], frame, scale);
      pen.restore();
    });
  }

  /** The name of a design over its piece of water; up is up. */
  drawWater(pen, look, frame, scale) {
    const half = this.data.width * scale;
    const [top, bottom, factor] = this.seen();
    pen.fillStyle = "#1c2430";
    pen.font = '12px "DejaVu Sans", Verdana, sans-serif';
    pen.textAlign = "center";
    pen.fillText(look.name, 0, -top * scale - 3);
    pen.beginPath();
    pen.rect(-half, -top * scale, 2 * half, (top + bottom) * scale);
    pen.clip();
    pen.beginPath();
    pen.moveTo(-half, bottom * scale);
    for (let k = 0; k < this.across; k++) {
      pen.lineTo(half * ((2 * k) / (this.across - 1) - 1), -scale * factor * this.sea.surface[frame * this.across + k]);
    }
    pen.lineTo(half, bottom * scale);
    pen.fillStyle = "#d5ebf8";
    pen.fill();
  }

  /** A buoy: its meridian on both sides, and dotted the one at rest. */
  drawHull(pen, look, design, frame, scale) {
    const [right, left] = [this.meridian(design, frame), this.meridian(design, frame, true)];
    const rest = Array.from(this.shape.colatitude, (_, i) => this.point(i, 0, 0));
    const line = (points) => {
      pen.beginPath();
      for (const point of points) pen.lineTo(...this.placed(design, frame, point, scale));
    };
    const around = (one, other) => [...one, ...other.toReversed().map(([x, z]) => [-x, z])];
    line(around(right, left));
    pen.closePath();
    pen.fillStyle = `${look.colour}22`;
    pen.fill();
    pen.strokeStyle = look.colour;
    pen.lineWidth = design.modes ? 2 : 4;
    pen.stroke();
    pen.setLineDash([2, 4]);
    pen.lineWidth = 1;
    pen.strokeStyle = "#566170";
    line(around(rest, rest));
    pen.stroke();
    if (!design.pitch) return;
    line([[0, 0], rest[0]]);
    pen.stroke();
  }

  /** Where a point of the buoy is on the canvas: turned by pitch, which brings the top to the right, then moved. */
  placed(design, frame, [x, z], scale) {
    const turn = design.pitch ? design.pitch[frame] : 0;
    const across = (design.surge ? design.surge[frame] : 0) + x * Math.cos(turn) + z * Math.sin(turn);
    const height = this.shape.centre + design.heave[frame] + z * Math.cos(turn) - x * Math.sin(turn);
    return [scale * across, -scale * height];
  }
}

/** A body of any shape: the lines of its hull, displaced by its degrees of freedom; motion and waves magnified alike. */
class Body extends Buoys {
  layout(room) {
    return [room < 640 ? 1 : Math.min(2, this.data.designs.length), 480];
  }

  seen() {
    return [this.data.top, this.data.bottom, this.data.factor];
  }

  /** Ends of the lines, x and z [m] in turn: x + factor sum q psi(x). */
  lines(design, frame) {
    const { outline, displacement } = this.shape;
    return outline.map((at, i) => {
      let moved = 0;
      for (let n = 0; n < design.modes; n++) moved += design.shell[frame * design.modes + n] * displacement[n * outline.length + i];
      return at + this.data.factor * moved;
    });
  }

  drawHull(pen, look, design, frame, scale) {
    const [middle] = this.data.middle;
    const line = (ends) => {
      pen.beginPath();
      for (let i = 0; i < ends.length; i += 2) pen[i % 4 ? "lineTo" : "moveTo"](scale * (ends[i] - middle), -scale * ends[i + 1]);
      pen.stroke();
    };
    pen.strokeStyle = look.colour;
    pen.lineWidth = 2;
    line(this.lines(design, frame));
    pen.setLineDash([2, 4]);
    pen.lineWidth = 1;
    pen.strokeStyle = "#566170";
    line(this.shape.outline);
    pen.setLineDash([]);
    const half = this.data.width / 2;
    const bar = [5, 2, 1].map((digit) => digit * 10 ** Math.floor(Math.log10(half))).find((length) => length <= half);
    const [left, low] = [6 - this.data.width * scale, this.data.bottom * scale - 6];
    pen.beginPath();
    pen.moveTo(left, low);
    pen.lineTo(left + bar * scale, low);
    pen.stroke();
    pen.fillStyle = "#1c2430";
    pen.textAlign = "left";
    pen.fillText(`${bar} m`, left, low - 4);
  }
}
