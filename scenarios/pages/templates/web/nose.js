/* The spindle's nose seen along an axis, its drift drawn larger than it is. */
const SVG = "http://www.w3.org/2000/svg";

class Nose {
  constructor(svg, across) {
    this.across = across;
    this.scale = 1; // pixels a micrometre
    const add = (parent, kind, attributes) => {
      const element = document.createElementNS(SVG, kind);
      for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
      return parent.appendChild(element);
    };
    svg.setAttribute("viewBox", "0 0 220 250");
    const spindle = (name) => {
      const group = add(svg, "g", { class: name });
      const body = add(group, "g", {});
      add(body, "rect", { x: 70, y: -60, width: 80, height: 130, rx: 4, class: "housing" });
      add(body, "rect", { x: 82, y: 70, width: 56, height: 14, class: "steel" });
      add(body, "path", { d: "M92 84 h36 l-6 20 h-24 z", class: "steel" });
      const tool = add(body, "rect", { x: 104, y: 104, width: 12, height: 60, class: "tool" });
      return { group, tool, warm: body.firstChild };
    };
    this.ghost = spindle("ghost");
    this.real = spindle("real");
    this.target = add(svg, "g", { class: "target" });
    add(this.target, "path", { d: "M-16 0 h32 M0 -16 v32" });
    add(this.target, "circle", { r: 8 });
    add(svg, "text", { x: 8, y: 242 }).textContent = `${across} →`;
    add(svg, "text", { x: 8, y: 226 }).textContent = "Z ↑";
    this.note = add(svg, "text", { x: 212, y: 242, "text-anchor": "end" });
  }

  draw(drift, error, toolLength, longest, warmth) {
    const sideways = this.across, far = Math.max(
      ...[drift, error].flatMap((p) => [Math.abs(p[sideways]), Math.abs(p.Z)]), 20);
    const fitting = 34 / far;
    this.scale += 0.05 * (fitting - this.scale);
    const length = 34 + 66 * Math.min(1, toolLength / longest);
    for (const [part, at] of [[this.ghost, drift], [this.real, error]]) {
      part.tool.setAttribute("height", length);
      const right = at[sideways] * this.scale, up = at.Z * this.scale;
      part.group.setAttribute("transform", `translate(${right.toFixed(2)} ${(-up).toFixed(2)})`);
      part.warm.style.setProperty("--warmth", warmth.toFixed(3));
    }
    this.target.setAttribute("transform", `translate(110 ${104 + length})`);
    // On the screen a pixel is about a quarter of a millimetre.
    const magnified = Number((this.scale * 265).toPrecision(2));
    this.note.textContent = `drawn ${magnified.toLocaleString("en")} times larger`;
  }
}
