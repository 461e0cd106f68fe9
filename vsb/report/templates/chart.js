// Charts of a page: curves over one axis, and values read off curves, drawn here or by the figures, under the pointer.
"use strict";

const NARROW = globalThis.matchMedia?.("(max-width: 40rem)").matches; // there letters are larger beside the curves
const CHART = { width: 520, height: NARROW ? 340 : 250, left: 58, right: 12, top: 12, bottom: 40 };

/** A number of four digits, without an exponent where people need none. */
function plain(value) {
  if (value === null || !Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  return size !== 0 && (size >= 1e7 || size < 1e-3) ? value.toExponential(2) : String(Number(value.toPrecision(4)));
}

/** A number with its sign, of some decimals; what rounds to zero is +0. */
function signed(value, decimals) {
  if (value === null) return "–";
  const size = Math.abs(value).toFixed(decimals);
  return `${value < 0 && Number(size) !== 0 ? "−" : "+"}${size}`;
}

/** The numbers of an axis, all of them with powers of ten if one needs it: 10⁵, 2·10⁵. */
function alike(values) {
  if (!values.some((value) => plain(value).includes("e"))) return values.map(plain);
  const raised = (power) => [...power].map((digit) => (digit === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])).join("");
  return values.map((value) => {
    const [factor, power] = Number(value.toPrecision(4)).toExponential().replace("+", "").split("e");
    return value === 0 ? "0" : `${factor === "1" ? "" : `${factor}·`}10${raised(power)}`;
  });
}

/** An element of SVG with attributes. */
function drawn(name, attributes, text = "") {
  const element = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== "") element.textContent = text;
  return element;
}

/** Round numbers between two ends, about as many as wanted; of a logarithmic axis powers of ten. */
function ticks(low, high, log, wanted = 6) {
  if (log) {
    const found = [];
    for (let p = Math.floor(Math.log10(low)); p <= Math.log10(high); p++) {
      for (const m of [1, 2, 5]) if (m * 10 ** p >= low * 0.999 && m * 10 ** p <= high * 1.001) found.push(m * 10 ** p);
    }
    const decades = found.filter((v) => Number.isInteger(Math.log10(v)));
    return found.length > wanted && decades.length > 1 ? decades : found;
  }
  const raw = (high - low) / wanted || 1;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((m) => m * decade).find((s) => s >= raw);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}

/** Draw curves, areas and marks into an SVG element; axes say where they lie, as those of figures do. */
function chart(svg, { x, y, curves, areas = [], marks = [], words, width = CHART.width }) {
  const { height, left, right, top, bottom } = CHART;
  const place = (v) => (x.log ? Math.log(v / x.low) / Math.log(x.high / x.low) : (v - x.low) / (x.high - x.low));
  const across = (v) => left + (width - left - right) * place(v);
  const up = (v) => height - bottom - ((height - top - bottom) * (v - y.low)) / (y.high - y.low);
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", words);
  const frame = drawn("g", {
    "data-x": `${left} ${width - right} ${x.low} ${x.high} ${x.log ? "log" : "linear"}`,
    "data-y": `${height - bottom} ${top} ${y.low} ${y.high} linear`,
    "data-x-label": x.label,
    "data-y-label": y.label,
  });
  const [along, aside] = [ticks(x.low, x.high, x.log), ticks(y.low, y.high, false, 5)];
  const [named, level] = [alike(along), alike(aside)];
  for (const [i, v] of along.entries()) {
    frame.append(drawn("path", { d: `M${across(v)} ${top}V${height - bottom}`, class: "rule" }));
    const within = Math.min(across(v), width - 5 * named[i].length); // half of it, at the size it has on a phone
    frame.append(drawn("text", { x: within, y: height - bottom + 15, class: "middle" }, named[i]));
  }
  for (const [i, v] of aside.entries()) {
    frame.append(drawn("path", { d: `M${left} ${up(v)}H${width - right}`, class: "rule" }));
    frame.append(drawn("text", { x: left - 5, y: up(v) + 4, class: "end" }, level[i]));
  }
  frame.append(drawn("text", { x: (left + width - right) / 2, y: height - 6, class: "middle" }, x.label));
  const middle = (top + height - bottom) / 2;
  const turned = { x: 15, y: middle, class: "middle", transform: `rotate(-90 15 ${middle})` };
  frame.append(drawn("text", turned, y.label));
  const line = (of) => Array.from(of.x, (v, i) => `${across(v).toFixed(2)} ${up(of.y[i]).toFixed(2)}`).join("L");
  for (const area of areas) {
    frame.append(drawn("path", { d: `M${left} ${up(0)}L${line(area)}L${width - right} ${up(0)}z`, class: "area" }));
  }
  for (const curve of curves) {
    const looks = { fill: "none", stroke: curve.colour, "stroke-width": 2, "stroke-dasharray": curve.dash };
    frame.append(drawn("path", { d: `M${line(curve)}`, "data-curve": curve.name, ...looks }));
  }
  for (const mark of marks) {
    if (mark.y === undefined) {
      frame.append(drawn("path", { d: `M${across(mark.x)} ${top}V${height - bottom}`, class: "here" }));
    } else {
      frame.append(drawn("circle", { cx: across(mark.x), cy: up(mark.y), r: 4, fill: mark.colour, class: "mark" }));
    }
  }
  svg.replaceChildren(frame);
}

/** Polylines of a path of M, L, l and z, as lists of x and y. */
function polylines(path) {
  const found = [];
  let [x, y, how] = [0, 0, "M"];
  for (const [, letter, first, second] of path.matchAll(/([MLlz])|(-?[\d.]+(?:e-?\d+)?)[ ,]?(-?[\d.]+(?:e-?\d+)?)/g)) {
    if (letter) {
      how = letter;
      continue;
    }
    [x, y] = how === "l" ? [x + Number(first), y + Number(second)] : [Number(first), Number(second)];
    if (how === "M") {
      found.push({ x: [], y: [] });
      how = "L";
    }
    found.at(-1).x.push(x);
    found.at(-1).y.push(y);
  }
  return found;
}

/** Height of polylines at a place; none where no line passes, or where lines go back on themselves. */
function heightAt(lines, x) {
  for (const line of lines) {
    const last = line.x.length - 1;
    if (last < 1 || x < line.x[0] || x > line.x[last]) continue;
    let [a, b] = [0, last];
    while (b - a > 1) {
      const c = (a + b) >> 1;
      if (line.x[c] <= x) a = c;
      else b = c;
    }
    const width = line.x[b] - line.x[a];
    return width > 0 ? line.y[a] + ((line.y[b] - line.y[a]) * (x - line.x[a])) / width : line.y[a];
  }
  return null;
}

/** Value on an axis "start end low high scale" at a place on the page. */
function onAxis(text, at) {
  const [start, end, low, high, scale] = text.split(" ").map((word, i) => (i < 4 ? Number(word) : word));
  const share = (at - start) / (end - start);
  return scale === "log" ? low * (high / low) ** share : low + share * (high - low);
}

/** What axes show at a place: the value across, and that of every curve there. */
function readAt(axes, x, y) {
  const [start, end] = axes.dataset.x.split(" ").map(Number);
  const [foot, head] = axes.dataset.y.split(" ").map(Number);
  if (x < start || x > end || y > foot || y < head) return null;
  const rows = [[axes.dataset.xLabel, onAxis(axes.dataset.x, x)]];
  for (const curve of axes.querySelectorAll("[data-curve]")) {
    const path = curve.matches("path") ? curve : curve.querySelector(":scope > path");
    if (!path) continue;
    const key = path.getAttribute("d");
    if (path.drawnFrom !== key) Object.assign(path, { drawnFrom: key, lines: polylines(key) });
    const height = path.lines.every(forwards) ? heightAt(path.lines, x) : null;
    if (height !== null) rows.push([curve.dataset.curve, onAxis(axes.dataset.y, height)]);
  }
  return rows;
}

/** Whether a polyline never goes back. */
function forwards(line) {
  return line.x.every((v, i) => i === 0 || v >= line.x[i - 1] - 0.02);
}

/** A row of a table, its first cell the name of a design beside the line it has in charts. */
function tableRow(cells, { colour, dash }) {
  const row = document.createElement("tr");
  row.append(
    ...cells.map((text, i) => {
      const cell = document.createElement("td");
      return Object.assign(cell, { textContent: text, className: i ? "" : "text" });
    }),
  );
  const key = drawn("svg", { viewBox: "0 0 28 10", class: "key", "aria-hidden": "true" });
  key.append(drawn("path", { d: "M1 5H27", fill: "none", stroke: colour, "stroke-width": 2, "stroke-dasharray": dash }));
  row.cells[0].prepend(key);
  return row;
}

/** Show values under the pointer on all drawings of the page. */
function showValues() {
  const tip = document.createElement("div");
  tip.className = "tip";
  tip.hidden = true;
  document.body.append(tip);
  document.addEventListener("pointermove", (event) => {
    const svg = event.target.closest?.("svg");
    const frames = svg ? [...svg.querySelectorAll("[data-x]")] : [];
    let rows = null;
    if (frames.length) {
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      rows = frames.map((axes) => readAt(axes, at.x, at.y)).find((found) => found !== null);
    }
    tip.hidden = !rows;
    if (!rows) return;
    tip.replaceChildren(...rows.map(([name, value]) => Object.assign(document.createElement("div"), { textContent: `${name}: ${plain(value)}` })));
    const left = Math.min(event.clientX + 14, document.documentElement.clientWidth - tip.offsetWidth - 6);
    tip.style.transform = `translate(${Math.max(4, left)}px, ${event.clientY + 16}px)`;
  });
}

/** Give every table with a head buttons that sort its rows. */
function sortTables() {
  for (const table of document.querySelectorAll(".scroll table")) {
    const heads = [...table.querySelectorAll("thead th")];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const turn = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
        for (const other of heads) other.removeAttribute("aria-sort");
        head.setAttribute("aria-sort", turn > 0 ? "ascending" : "descending");
        const rows = [...table.tBodies[0].rows];
        const text = (row) => row.cells[column].textContent.trim();
        const order = (a, b) => {
          const [p, q] = [parseFloat(text(a)), parseFloat(text(b))];
          if (Number.isNaN(p) || Number.isNaN(q)) return text(a).localeCompare(text(b), "en", { numeric: true });
          return p - q;
        };
        table.tBodies[0].append(...rows.sort((a, b) => turn * order(a, b)));
      });
    });
  }
}

if (typeof module !== "undefined") module.exports = { plain, ticks, polylines, heightAt, onAxis };
