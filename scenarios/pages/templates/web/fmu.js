/* An FMU in WebAssembly, called as any host calls one of FMI 3.0. */
class Fmu {
  static async load(base64, told) {
    const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
    const { instance } = await WebAssembly.instantiate(bytes, {});
    return new Fmu(instance.exports, told);
  }

  constructor(code, told) {
    this.code = code;
    this.variables = told.variables;
    this.refs = new Map(told.variables.map((variable, ref) => [variable.name, ref]));
    code._initialize();
    const token = this.kept(told.token);
    this.instance = code.fmi3InstantiateCoSimulation(
      token, token, 0, 0, 1, 0, 0, 0, 0, 0, code.web_logger(), 0);
    this.answers = code.memory_take(1, 16); // three flags and the time of a step
    this.time = 0;
    this.check(this.instance === 0);
  }

  kept(text) {
    const bytes = new TextEncoder().encode(`${text}\0`);
    const place = this.code.memory_take(bytes.length, 1);
    new Uint8Array(this.code.memory.buffer, place).set(bytes);
    return place;
  }

  text(place) {
    const bytes = new Uint8Array(this.code.memory.buffer, place);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  check(failed) {
    if (failed) throw new Error(this.text(this.code.web_message()));
  }

  names(causality, kind = "real") {
    return this.variables
      .filter((variable) => variable.causality === causality && variable.kind === kind)
      .map((variable) => variable.name);
  }

  variable(name) {
    return this.variables[this.refs.get(name)];
  }

  /* Variables of one kind that are read or set together. */
  port(names, kind = "real") {
    const [type, rows] = { real: ["Float64", Float64Array], integer: ["Int32", Int32Array],
      boolean: ["Boolean", Uint8Array], string: ["String", Uint32Array] }[kind];
    const count = names.length, { code } = this;
    const refs = code.memory_take(count, 4);
    const values = code.memory_take(count, rows.BYTES_PER_ELEMENT);
    new Uint32Array(code.memory.buffer, refs, count).set(names.map((name) => this.refs.get(name)));
    const call = (verb) => this.check(
      code[`fmi3${verb}${type}`](this.instance, refs, count, values, count) !== 0);
    const row = () => new rows(code.memory.buffer, values, count);
    return {
      names,
      get: () => (call("Get"), kind === "string" ? [...row()].map((p) => this.text(p)) : row()),
      set: (given) => (row().set(given), call("Set")),
    };
  }

  reset() {
    this.check(this.code.fmi3Reset(this.instance) !== 0);
    this.time = 0;
  }

  start() {
    const { code, instance } = this;
    this.check(code.fmi3EnterInitializationMode(instance, 0, 0, 0, 0, 0) !== 0);
    this.check(code.fmi3ExitInitializationMode(instance) !== 0);
  }

  step(step_s) {
    const at = this.answers;
    this.check(this.code.fmi3DoStep(
      this.instance, this.time, step_s, 0, at, at + 1, at + 2, at + 8) !== 0);
    this.time += step_s;
  }
}
