/* Curves over the last hours, on canvases. */
const WINDOW_S = 8 * 3600, RECORD_S = 20;

class History {
  constructor(names) {
    this.names = names;
    this.clear();
  }

  clear() {
    this.time = [];
    this.rows = Object.fromEntries(this.names.map((name) => [name, []]));
    this.due = 0;
  }

  add(time, value) {
    if (time < this.due) return;
    this.due = time + RECORD_S;
    this.time.push(time);
    for (const name of this.names) this.rows[name].push(value(name));
    if (this.time[0] >= time - WINDOW_S) return;
    this.time.shift();
    for (const name of this.names) this.rows[name].shift();
  }

  get span() {
    const end = Math.max(WINDOW_S, this.time.at(-1) ?? 0);
    return [end - WINDOW_S, end];
  }
}

function niceStep(range, most) {
  const raw = range / most, power = 10 ** Math.floor(Math.log10(raw));
  return [1, 2, 5, 10].map((k) => k * power).find((step) => step >= raw);
}

const colour = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/* curves: [{ values, colour, width, dash }]; band: { low, high, colour }, all rows of the history. */
function drawChart(canvas, history, { curves, band, least, zero, hours }) {
  const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
  if (canvas.width !== wide * ratio || canvas.height !== high * ratio) {
    [canvas.width, canvas.height] = [wide * ratio, high * ratio];
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, wide, high);
  const left = 42, right = wide - 8, top = 8, bottom = high - (hours ? 20 : 8);
  const all = [...curves.map((curve) => curve.values), ...(band ? [band.low, band.high] : [])];
  let [low, most] = zero ? [-least, least] : [Infinity, -Infinity];
  for (const values of all) for (const value of values) {
    if (Number.isFinite(value)) { low = Math.min(low, value); most = Math.max(most, value); }
  }
  if (!Number.isFinite(low)) [low, most] = [0, 1];
  if (most - low < least) { const middle = (low + most) / 2; low = middle - least / 2; most = low + least; }
  const grid = niceStep(most - low, 4);
  low = Math.floor(low / grid) * grid;
  most = Math.ceil(most / grid) * grid;
  const [from, to] = history.span;
  const x = (time) => left + (right - left) * (time - from) / (to - from);
  const y = (value) => bottom - (bottom - top) * (value - low) / (most - low);
  pen.font = "11px system-ui, sans-serif";
  pen.lineWidth = 1;
  pen.textBaseline = "middle";
  pen.textAlign = "right";
  const digits = Math.max(0, -Math.floor(Math.log10(grid)));
  for (let k = Math.round(low / grid); k <= Math.round(most / grid); k++) {
    const value = k * grid;
    pen.strokeStyle = colour(k === 0 && zero ? "axis" : "line");
    pen.beginPath(); pen.moveTo(left, y(value)); pen.lineTo(right, y(value)); pen.stroke();
    pen.fillStyle = colour("soft");
    pen.fillText(value.toFixed(digits).replace("-", "−"), left - 6, y(value));
  }
  pen.textAlign = "center";
  for (let hour = Math.ceil(from / 3600); hour * 3600 <= to; hour++) {
    pen.strokeStyle = colour("line");
    pen.beginPath(); pen.moveTo(x(hour * 3600), top); pen.lineTo(x(hour * 3600), bottom); pen.stroke();
    if (hours) pen.fillText(`${hour} h`, Math.min(x(hour * 3600), right - 8), high - 8);
  }
  const path = (values, back) => {
    let begun = false;
    for (let i = 0; i < values.length; i++) {
      const k = back ? values.length - 1 - i : i;
      if (!Number.isFinite(values[k])) continue;
      pen[begun || back ? "lineTo" : "moveTo"](x(history.time[k]), y(values[k]));
      begun = true;
    }
  };
  if (band && history.time.length > 1) {
    pen.fillStyle = band.colour;
    pen.beginPath(); path(band.high); path(band.low, true); pen.closePath(); pen.fill();
  }
  for (const curve of curves) {
    pen.strokeStyle = curve.colour;
    pen.lineWidth = curve.width ?? 1.5;
    pen.setLineDash(curve.dash ?? []);
    pen.beginPath(); path(curve.values); pen.stroke();
  }
  pen.setLineDash([]);
}

/* The status over the same hours, as a bar. */
function drawBar(canvas, history, states) {
  const ratio = window.devicePixelRatio || 1, wide = canvas.clientWidth, high = canvas.clientHeight;
  [canvas.width, canvas.height] = [wide * ratio, high * ratio];
  const pen = canvas.getContext("2d"), [from, to] = history.span;
  pen.scale(ratio, ratio);
  const x = (time) => 42 + (wide - 50) * (time - from) / (to - from);
  pen.fillStyle = colour("line");
  pen.fillRect(42, 0, wide - 50, high);
  history.time.forEach((time, k) => {
    pen.fillStyle = states[history.rows.state[k]][1];
    pen.fillRect(x(time), 0, x(time + RECORD_S) - x(time) + 0.6, high);
  });
}
