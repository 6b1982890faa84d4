/* The page: controls in, pictures out. */
const AXES = ["X", "Y", "Z"], STEP_S = 1, FRAME_MS = 12;
const UNITS = { degC: "°C", rpm: "r/min", mm_min: "mm/min", um: "µm", Nm: "N m" };
const told = JSON.parse(document.getElementById("told").textContent);
const code = (role) => document.getElementById(`${role}-code`).textContent.trim();
const at = (id) => document.getElementById(id);
const fixed = (value, digits = 1) =>
  Number.isFinite(value) ? value.toFixed(digits).replace("-", "−") : "–";

function clockOf(seconds) {
  const whole = Math.floor(seconds), two = (n) => String(n).padStart(2, "0");
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}`;
}

function slider(loop, name, place) {
  const variable = loop.plant.variable(name), [low, high, step] = told.sliders[name];
  const row = document.createElement("label");
  row.className = "slider";
  const unit = UNITS[variable.unit] ?? variable.unit;
  row.innerHTML = "<span></span><output></output><input type=range>";
  const [title, shown, input] = row.children;
  title.textContent = told.titles[name];
  Object.assign(input, { min: low, max: high, step, value: loop.signals[name], id: `input-${name}` });
  const show = () => { shown.textContent = `${fixed(loop.signals[name], step < 1 ? 1 : 0)} ${unit}`; };
  input.addEventListener("input", () => {
    loop.signals[name] = Number(input.value);
    if (name === told.speed) at("programme").checked = false;
    show();
  });
  place.append(row);
  show();
  return { set(value) { loop.signals[name] = value; input.value = value; show(); } };
}

class Page {
  constructor(loop) {
    this.loop = loop;
    this.running = true;
    this.owed = 0;
    const others = loop.driven.filter((name) => !told.main.includes(name));
    this.sliders = Object.fromEntries([...told.main, ...others].map((name) => {
      return [name, slider(loop, name, at(others.includes(name) ? "more" : "main"))];
    }));
    at("more-box").hidden = others.length === 0;
    for (const name of loop.measured) at("sensor").add(new Option(name, name));
    this.noses = ["X", "Y"].map((axis) => new Nose(at(`nose-${axis}`), axis));
    const ofAxes = AXES.flatMap((axis) => [
      `drift_${axis}`, `error_${axis}`, `d${axis}`, `low_${axis}`, `high_${axis}`]);
    this.history = new History([...ofAxes, ...loop.measured, "state", told.speed].filter(Boolean));
    at("play").addEventListener("click", () => this.play(!this.running));
    at("again").addEventListener("click", () => this.restart());
    at("compensating").addEventListener("change", () => {
      loop.compensating = at("compensating").checked;
      at("offsets").classList.toggle("unused", !loop.compensating);
    });
    for (const id of ["sensor", "kind"]) at(id).addEventListener("change", () => this.breakOne());
    this.restart();
  }

  breakOne() {
    const [kind, value] = at("kind").value.split(" "), sensor = at("sensor").value;
    at("kind").disabled = sensor === "";
    this.loop.fault = sensor === "" ? null : { sensor, kind, value: Number(value) };
  }

  play(on) {
    this.running = on;
    at("play").textContent = on ? "Pause" : "Go on";
  }

  restart() {
    this.history.clear();
    this.follow();
    this.breakOne();
    this.loop.start();
    this.ended = "";
    this.play(true);
    this.record();
    this.draw();
  }

  /* The day's work sets the speed, until a hand does. */
  follow() {
    if (!at("programme").checked || !told.speed) return;
    const hour = Math.floor(this.loop.plant.time / told.programme.each_s);
    const speed = told.programme.speeds[hour % told.programme.speeds.length];
    if (speed !== this.loop.signals[told.speed]) this.sliders[told.speed].set(speed);
  }

  advance(steps) {
    for (let k = 0; k < steps; k++) {
      this.follow();
      this.loop.step(STEP_S);
      this.record();
    }
  }

  record() {
    const { loop, history } = this, code = loop.codes.get()[0];
    if (loop.plant.time < history.due) return;
    const bound = (axis, side) => {
      const half = loop.value(`d${axis}_uncertainty`);
      return half < 0 ? NaN : side * half - loop.value(`d${axis}`);
    };
    history.add(loop.plant.time, (name) => {
      if (name === "state") return told.stateOf[code];
      if (name === told.speed) return loop.signals[name];
      if (name.startsWith("low_")) return bound(name.at(-1), -1);
      if (name.startsWith("high_")) return bound(name.at(-1), 1);
      return loop.measured.includes(name) ? loop.saw[name] : loop.value(name);
    });
  }

  /* One frame of the screen: as many steps as are due, but no longer than a frame lasts. */
  frame(elapsed_s) {
    if (this.running) {
      this.owed += Math.min(elapsed_s, 0.1) * Number(at("pace").value);
      const stop = performance.now() + FRAME_MS;
      try {
        while (this.owed >= STEP_S && performance.now() < stop) {
          const steps = Math.min(Math.floor(this.owed / STEP_S), 8);
          this.advance(steps);
          this.owed -= steps * STEP_S;
        }
      } catch (error) {
        this.ended = error.message;
        this.play(false);
      }
      this.owed = Math.min(this.owed, Number(at("pace").value) / 10);
    }
    this.draw();
  }

  draw() {
    const { loop, history } = this, [code] = loop.codes.get(), [words] = loop.words.get();
    const state = told.states[told.stateOf[code]];
    at("clock").textContent = clockOf(loop.plant.time);
    at("state").textContent = this.ended ? "stopped" : state[0];
    at("state").style.setProperty("--state", state[1]);
    at("words").textContent = this.ended || words || state[2];
    at("code").textContent = `status ${code}, valid ${loop.flag.get()[0] ? "true" : "false"}`;
    const point = (what) => Object.fromEntries(AXES.map((axis) => [axis, loop.value(`${what}_${axis}`)]));
    const drift = point("drift"), error = point("error");
    for (const axis of AXES) {
      const half = loop.value(`d${axis}_uncertainty`);
      at(`drift-${axis}`).textContent = fixed(drift[axis]);
      at(`offset-${axis}`).textContent = fixed(loop.value(`d${axis}`));
      at(`left-${axis}`).textContent = fixed(error[axis]);
      at(`half-${axis}`).textContent = half < 0 ? "–" : `± ${fixed(half)}`;
      drawChart(at(`chart-${axis}`), history, {
        zero: true, least: 10, hours: axis === "Z",
        band: { low: history.rows[`low_${axis}`], high: history.rows[`high_${axis}`], colour: colour("band") },
        curves: [
          { values: history.rows[`d${axis}`], colour: colour("offset"), dash: [4, 3], width: 1.2 },
          { values: history.rows[`drift_${axis}`], colour: colour("drift") },
          { values: history.rows[`error_${axis}`], colour: colour("left"), width: 2.2 },
        ],
      });
    }
    drawBar(at("bar"), history, told.states);
    const warmest = Math.max(...loop.measured.map((name) => loop.value(name)));
    const rise = warmest - loop.signals[told.hall];
    const tool = loop.signals.tool_length, longest = told.sliders.tool_length[1];
    for (const nose of this.noses) {
      nose.draw(drift, error, tool, longest, Math.min(1, Math.max(0, rise / 25)));
    }
    const chosen = at("sensor").value;
    drawChart(at("chart-T"), history, {
      least: 4, hours: true,
      curves: loop.measured.map((name) => ({
        values: history.rows[name], colour: colour(name === chosen ? "left" : "drift"),
        width: name === chosen ? 2.2 : 1,
      })),
    });
  }
}

async function begin() {
  const [plant, compensator] = await Promise.all(
    ["plant", "compensator"].map((role) => Fmu.load(code(role), told[role])));
  const page = new Page(new Loop(plant, compensator, told.wiring));
  window.spindle = { Fmu, Loop, page, told, code };
  let last = performance.now();
  const frame = (now) => {
    page.frame((now - last) / 1000);
    last = now;
    requestAnimationFrame(frame);
  };
  requestAnimationFrame(frame);
}

begin().catch((error) => { at("words").textContent = error.message; at("state").textContent = "stopped"; });
