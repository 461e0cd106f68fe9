// Power of a damper in seas and years, from ports; also runs outside a page.
// A port has drive = |Z V0|^2, resistance R and reactance X over frequency; a damping c absorbs
// c drive / (2 ((R + c)^2 + X^2)) per squared wave amplitude (vsb.engine.motion.port).
"use strict";

/** Numbers of base64 text of little-endian floats of four or eight bytes. */
function unpacked(text, bytes = 4) {
  const raw = atob(text);
  const view = new DataView(new ArrayBuffer(raw.length));
  for (let i = 0; i < raw.length; i++) view.setUint8(i, raw.charCodeAt(i));
  const values = new Float64Array(raw.length / bytes);
  for (let i = 0; i < values.length; i++) {
    values[i] = bytes === 4 ? view.getFloat32(4 * i, true) : view.getFloat64(8 * i, true);
  }
  return values;
}

/** A port as stored, with its numbers unpacked. */
function unpackedPort(stored) {
  return Object.fromEntries(Object.entries(stored).map(([name, text]) => [name, unpacked(text)]));
}

/** Frequencies, energy flux per squared amplitude and ports that seas share, unpacked. */
function unpackedGrid(stored) {
  return { omega: unpacked(stored.omega, 8), flux: unpacked(stored.flux), ports: stored.ports.map(unpackedPort) };
}

/** Squared amplitudes of a sea's components, of a spectrum with another peak period if one is given [m^2]. */
function seaSquares(sea, grid, tp = null) {
  return sea.jonswap ? jonswapSquares(sea.jonswap, grid.omega, tp ?? sea.jonswap.tp) : unpacked(sea.squares);
}

/** Power of a damper per squared amplitude at one frequency of a port [W/m^2]. */
function powerAt(port, j, damping) {
  const r = port.resistance[j] + damping;
  const x = port.reactance[j];
  const size = r * r + x * x;
  return size > 0 ? (0.5 * damping * port.drive[j]) / size : 0;
}

/** Mean power of a damper in a sea, by the squares of its components' amplitudes [W]. */
function power(port, squares, damping) {
  let sum = 0;
  for (let j = 0; j < squares.length; j++) sum += squares[j] * powerAt(port, j, damping);
  return sum;
}

/** The optimal damping in a sea: the best of a table, then golden sections to round-off. */
function bestDamper(port, squares) {
  const value = (u) => power(port, squares, Math.exp(u));
  let low = Infinity;
  let high = -Infinity;
  for (let j = 0; j < squares.length; j++) {
    const size = Math.hypot(port.resistance[j], port.reactance[j]);
    if (squares[j] > 0 && size > 0) {
      low = Math.min(low, Math.log(size));
      high = Math.max(high, Math.log(size));
    }
  }
  if (!(high >= low)) return 0;
  const count = Math.max(1, Math.ceil((high - low) / 0.1));
  const step = (high - low) / count || 0.1;
  let best = low;
  let most = value(low);
  for (let i = 1; i <= count; i++) {
    const here = value(low + i * step);
    if (here > most) [best, most] = [low + i * step, here];
  }
  return Math.exp(peak(value, best - step, best + step));
}

/** Where a function with one peak between two places is highest, by golden sections. */
function peak(value, from, to) {
  const part = (Math.sqrt(5) - 1) / 2;
  let [a, b] = [from, to];
  let [c, d] = [b - part * (b - a), a + part * (b - a)];
  let [atC, atD] = [value(c), value(d)];
  while (b - a > 1e-5) {
    if (atC >= atD) {
      [b, d, atD] = [d, c, atC];
      c = b - part * (b - a);
      atC = value(c);
    } else {
      [a, c, atC] = [c, d, atD];
      d = a + part * (b - a);
      atD = value(d);
    }
  }
  return (a + b) / 2;
}

/** Squared amplitudes of the components of a JONSWAP sea [m^2] (vsb.engine.waves.seas.IrregularSea.components). */
function jonswapSquares({ hs, gamma, integral, width }, omega, tp) {
  const top = (2 * Math.PI) / tp;
  const inside = Math.ceil(width / (0.02 * top));
  const factor = ((hs * hs) / 16 / integral) * top ** 4;
  const density = (w) => {
    const x = w / top;
    const sigma = x <= 1 ? 0.07 : 0.09;
    const bump = gamma ** Math.exp(-((x - 1) ** 2) / (2 * sigma * sigma));
    return factor * w ** -5 * Math.exp(-1.25 / x ** 4) * bump;
  };
  const squares = new Float64Array(omega.length);
  for (let j = 0; j < squares.length; j++) {
    let sum = 0;
    for (let i = 0; i < inside; i++) sum += density(omega[j] + width * ((i + 0.5) / inside - 0.5));
    squares[j] = (2 * width * sum) / inside;
  }
  return squares;
}

/** Sum of the products of two lists of numbers. */
function dot(a, b) {
  let sum = 0;
  for (let j = 0; j < a.length; j++) sum += a[j] * b[j];
  return sum;
}

/** Mean spectra of the bins of a year, one after the other, and the share of each, unpacked. */
function unpackedBins(stored) {
  return { ...stored, share: unpacked(stored.share, 8), density: unpacked(stored.density, 8) };
}

/** A point of a campaign, unpacked; the weight of a frequency in a band is 2 int h dw (vsb.results.year). */
function unpackedPoint(stored) {
  const { band, at, value } = stored.weights;
  const weights = { band: unpacked(band), at: unpacked(at), value: unpacked(value, 8) };
  return { ...stored, weights, ports: stored.ports.map((port) => port && unpackedPort(port)) };
}

/** Squared amplitudes of the year's mean spectrum at the frequencies of a point's ports [m^2]. */
function yearSquares(bins, { weights, ports }) {
  const mean = new Float64Array(bins.bands);
  bins.share.forEach((share, i) => {
    for (let b = 0; b < bins.bands; b++) mean[b] += share * bins.density[i * bins.bands + b];
  });
  const squares = new Float64Array(ports.find((port) => port).drive.length);
  for (let k = 0; k < weights.value.length; k++) squares[weights.at[k]] += weights.value[k] * mean[weights.band[k]];
  return squares;
}

/** Mean power of a damper in every bin of the year [W]: one small product. */
function binPowers(bins, weights, port, damping) {
  const taken = new Float64Array(bins.bands);
  for (let k = 0; k < weights.value.length; k++) {
    taken[weights.band[k]] += weights.value[k] * powerAt(port, weights.at[k], damping);
  }
  return bins.share.map((_, i) => dot(taken, bins.density.subarray(i * bins.bands, (i + 1) * bins.bands)));
}

/** Gains over one of some powers [%]; none over nothing. */
function gains(powers, reference) {
  const base = reference < 0 ? 0 : powers[reference];
  return powers.map((value) => (base > 0 && value !== null ? 100 * (value / base - 1) : null));
}

if (typeof module !== "undefined") {
  const ofSeas = { unpacked, unpackedGrid, seaSquares, powerAt, power, bestDamper, dot, gains };
  module.exports = { ...ofSeas, unpackedBins, unpackedPoint, yearSquares, binPowers };
}
