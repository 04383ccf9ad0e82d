// Two handles on a figure's time axis. What lies outside them is faded at once; the server is told while they move.

class SpanHandles {
  constructor(plot) {
    this.plot = plot;
    this.root = element("div", "linked-plot-span", plot.root);
    this.shades = element("div", "", this.root);
    this.bar = element("div", "linked-plot-span-bar", this.root, { title: "Drag to move the whole stretch" });
    this.handles = [0, 1].map((side) => this.makeHandle(side));
    this.makeDraggable(this.bar, [0, 1]);
    this.values = null;
    this.held = false;
  }

  makeHandle(side) {
    const node = element("div", "linked-plot-handle", this.root, { tabIndex: 0, role: "slider" });
    node.label = element("span", "", node);
    this.makeDraggable(node, [side]);
    node.onkeydown = (event) => {
      const { step, min, max } = this.span;
      const moves = { ArrowLeft: -step, ArrowRight: step, PageDown: -10 * step, PageUp: 10 * step };
      const ends = { Home: min - max, End: max - min };
      const change = moves[event.key] ?? ends[event.key];
      if (change === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      this.move([side], this.values, change);
      this.pressed = true;
    };
    node.onkeyup = node.onblur = () => {
      if (this.pressed) this.plot.reports.add({ settled: true });
      this.pressed = false;
    };
    return node;
  }

  makeDraggable(node, sides) {
    let from = null;
    node.onpointerdown = (event) => {
      if (event.button) return;
      node.setPointerCapture(event.pointerId);
      from = { x: event.clientX, values: [...this.values] };
      this.held = true;
      event.preventDefault();
      if (node.tabIndex === 0) node.focus({ preventScroll: true });
    };
    node.onpointermove = (event) => {
      if (!from) return;
      const { xaxis } = this.plot.figure._fullLayout;
      this.move(sides, from.values, xaxis.p2d(event.clientX - from.x) - xaxis.p2d(0));
    };
    node.onpointerup = node.onpointercancel = () => {
      if (!from) return;
      from = null;
      this.held = false;
      this.plot.reports.add({ settled: true });
    };
  }

  move(sides, from, change) {
    const { min, max, step, gap, names } = this.span;
    const low = sides[0] === 1 ? from[0] + gap - from[1] : min - from[0];
    const high = sides.at(-1) === 0 ? from[1] - gap - from[0] : max - from[1];
    const moved = Math.min(Math.max(Math.round(change / step) * step, low), high);
    const values = from.map((value, side) => (sides.includes(side) ? Number((value + moved).toFixed(6)) : value));
    if (values.every((value, side) => value === this.values[side])) return;
    this.values = values;
    this.place();
    const changed = Object.fromEntries(sides.map((side) => [names[side], values[side]]));
    this.plot.reports.add({ values: changed, settled: false });
  }

  update(span, settled) {
    this.span = span;
    this.root.hidden = !span;
    if (!span) return;
    if (!this.values || (settled && !this.held && !this.pressed)) this.values = span.values;
    this.place();
  }

  place() {
    const layout = this.plot.ready && this.plot.figure._fullLayout;
    if (!layout || !this.span) return;
    const { xaxis, _size: size } = layout;
    const [bottom, top] = this.span.domain;
    const [left, right] = xaxis.range.map((value) => xaxis.d2p(value));
    const inside = (value) => Math.min(Math.max(xaxis.d2p(value), left), right);
    const [start, end] = this.values.map(inside);
    Object.assign(this.root.style, {
      left: `${xaxis._offset}px`,
      width: `${right}px`,
      top: `${size.t + (1 - top) * size.h}px`,
      height: `${(top - bottom) * size.h}px`,
    });
    this.shades.replaceChildren();
    for (const [low, high] of this.span.faded) {
      for (const [from, width] of [[0, start], [end, right - end]]) {
        const shade = element("div", "linked-plot-shade", this.shades);
        shade.style.cssText = `left: ${from}px; width: ${width}px; top: ${(top - high) * size.h}px; height: ${(high - low) * size.h}px`;
      }
    }
    Object.assign(this.bar.style, { left: `${start}px`, width: `${end - start}px` });
    this.handles.forEach((node, side) => {
      const { min, max, labels, unit } = this.span;
      const value = this.values[side];
      node.hidden = Math.abs(xaxis.d2p(value) - inside(value)) > 1;
      node.style.left = `${[start, end][side]}px`;
      node.label.textContent = `${value.toFixed(2)} ${unit}`;
      node.setAttribute("aria-label", labels[side]);
      node.setAttribute("aria-valuemin", min);
      node.setAttribute("aria-valuemax", max);
      node.setAttribute("aria-valuenow", value);
      node.setAttribute("aria-valuetext", `${value.toFixed(2)} ${unit}`);
    });
  }
}
