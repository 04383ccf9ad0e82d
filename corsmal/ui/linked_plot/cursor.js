// Where the page's time line stands, as a line across a figure. It moves in the same redraw as the pictures.

class PlayheadCursor {
  constructor(plot) {
    this.plot = plot;
    this.line = element("div", "linked-plot-cursor", plot.root, { hidden: true });
    this.onMove = () => this.place();
    window.addEventListener("corsmal-playhead", this.onMove);
  }

  remove() {
    window.removeEventListener("corsmal-playhead", this.onMove);
  }

  // A click at a place of the axis is one at its frame.
  follow(x) {
    const { frame_on_x: perFrame } = this.plot.data;
    if (!perFrame || !window.corsmalPlayhead || !Number.isFinite(x)) return false;
    window.corsmalPlayhead.goTo(Math.round(x / perFrame));
    return true;
  }

  place() {
    const layout = this.plot.ready && this.plot.figure._fullLayout;
    const { frame_on_x: perFrame } = this.plot.data ?? {};
    const frame = window.corsmalPlayhead?.frame;
    this.line.hidden = true;
    if (!layout || !perFrame || frame === undefined) return;
    const { xaxis, _size: size } = layout;
    const left = xaxis.d2p(frame * perFrame);
    if (left < -1 || left > xaxis._length + 1) return;
    this.line.hidden = false;
    this.line.dataset.frame = frame;
    Object.assign(this.line.style, { height: `${size.h}px`, transform: `translate(${xaxis._offset + left}px, ${size.t}px)` });
  }
}
