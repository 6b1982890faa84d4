/* Plant and compensator in a loop: the order of a step is that of scenarios/cosimulation.py. */
class Loop {
  constructor(plant, compensator, { driven, by_signals, shared, measured, offsets }) {
    Object.assign(this, { plant, compensator, driven, offsets });
    this.told = by_signals.map((name) => shared[name] ?? name);
    this.drive = plant.port(driven);
    this.move = plant.port(offsets);
    this.seed = plant.port(["noise_seed"], "integer");
    this.shown = plant.port(plant.names("output"));
    this.see = compensator.port([...measured, ...by_signals]);
    this.sent = compensator.port(compensator.names("output"));
    this.codes = compensator.port(["status", "status_sensor"], "integer");
    this.flag = compensator.port(["valid"], "boolean");
    this.words = compensator.port(["status_text"], "string");
    this.take = measured.map((name) => this.shown.names.indexOf(name));
    this.give = offsets.map((name) => this.sent.names.indexOf(name));
    this.signals = Object.fromEntries(driven.map((name) => [name, plant.variable(name).start]));
    this.fault = null; // { sensor, kind, value }
    this.compensating = true;
    this.measured = measured;
  }

  start() {
    this.plant.reset();
    this.compensator.reset();
    this.seed.set([1]);
    this.drive.set(this.driven.map((name) => this.signals[name]));
    this.plant.start();
    this.read = this.shown.get().slice();
    this.compensator.start();
    this.given = this.sent.get().slice();
    this.seen();
  }

  /* What the compensator sees: the plant's readings with the broken thermometer's instead. */
  seen() {
    const values = this.take.map((place) => this.read[place]);
    const place = this.fault ? this.measured.indexOf(this.fault.sensor) : -1;
    if (place >= 0) values[place] = this.broken(values[place]);
    this.saw = Object.fromEntries(this.measured.map((name, k) => [name, values[k]]));
    return [...values, ...this.told.map((name) => this.signals[name])];
  }

  broken(reading) {
    const { fault } = this, now = this.plant.time;
    fault.since ??= now;
    fault.first ??= reading;
    return { missing: NaN, frozen: fault.first, offset: reading + fault.value,
      drift: reading + fault.value * (now - fault.since) / 3600 }[fault.kind];
  }

  step(step_s) {
    this.see.set(this.seen());
    this.drive.set(this.driven.map((name) => this.signals[name]));
    this.move.set(this.give.map((place) => (this.compensating ? this.given[place] : 0)));
    this.compensator.step(step_s);
    this.plant.step(step_s);
    this.read = this.shown.get().slice();
    this.given = this.sent.get().slice();
  }

  value(name) {
    const place = this.shown.names.indexOf(name);
    return place >= 0 ? this.read[place] : this.given[this.sent.names.indexOf(name)];
  }
}
