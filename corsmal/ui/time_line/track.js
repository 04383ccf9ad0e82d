// The track in seconds, with the marks and the playhead that can be dragged.

const SVG = "http://www.w3.org/2000/svg";
const TICKS_MAX = 8;
const TICK_STEPS = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 3600];

class Track {
  constructor(root, timeLine) {
    this.root = root;
    this.timeLine = timeLine;
    Object.assign(root, { tabIndex: 0, role: "slider" });
    root.setAttribute("aria-valuemin", 0);
    element("div", "time-line-line", root);
    this.crop = element("div", "time-line-crop", root);
    this.inspected = document.createElementNS(SVG, "svg");
    this.inspected.setAttribute("class", "time-line-inspected");
    this.inspected.setAttribute("preserveAspectRatio", "none");
    this.ticks = this.inspected.appendChild(document.createElementNS(SVG, "path"));
    root.append(this.inspected);
    this.scale = element("div", "time-line-scale", root);
    this.star = element("div", "time-line-star", root, { textContent: "★" });
    this.head = element("div", "time-line-head", root);
    this.isHeld = false;
    root.onpointerdown = (event) => this.hold(event);
    root.onpointermove = (event) => this.isHeld && this.follow(event, true);
    root.onpointerup = root.onpointercancel = (event) => this.isHeld && this.release(event);
  }

  // The middle of a frame, as a share of the track: half a frame is left at both ends.
  share(frame) {
    return (frame + 0.5) / this.data.frames;
  }

  update(data) {
    this.data = data;
    const percent = (frame) => `${100 * this.share(frame)}%`;
    this.root.setAttribute("aria-valuemax", data.frames - 1);
    this.root.setAttribute("aria-label", "Frame");
    this.inspected.setAttribute("viewBox", `0 0 ${data.frames} 1`);
    this.ticks.setAttribute("d", data.inspected.map((frame) => `M${frame + 0.5} 0V1`).join(""));
    this.star.hidden = data.best === null;
    this.star.style.left = percent(data.best ?? 0);
    this.star.title = `Best frame: ${data.best}`;
    this.crop.hidden = !data.crop;
    const [start, end] = data.crop ?? [0, 0];
    Object.assign(this.crop.style, { left: percent(start), width: `${(100 * (end - start)) / data.frames}%` });
    this.updateScale(percent);
  }

  updateScale(percent) {
    const { fps, frames } = this.data;
    const perUnit = fps || 1; // without a rate the track counts frames
    const length = (frames - 1) / perUnit;
    const step = TICK_STEPS.find((one) => length / one <= TICKS_MAX && one * perUnit >= 1) ?? length;
    const labels = [];
    for (let count = 0; step && count * step <= length + 1e-9; count += 1) labels.push(Number((count * step).toFixed(1)));
    this.scale.replaceChildren();
    for (const label of labels) {
      const node = element("span", "", this.scale, { textContent: fps ? `${label} s` : label });
      node.style.left = percent(label * perUnit);
    }
  }

  show(frame, text) {
    this.head.style.left = `${100 * this.share(frame)}%`;
    this.root.setAttribute("aria-valuenow", frame);
    this.root.setAttribute("aria-valuetext", text);
  }

  hold(event) {
    if (event.button) return;
    this.isHeld = true;
    this.root.setPointerCapture(event.pointerId);
    this.root.focus({ preventScroll: true });
    event.preventDefault();
    this.follow(event, true);
  }

  follow(event, moving) {
    const box = this.root.getBoundingClientRect();
    const frame = Math.floor(((event.clientX - box.left) / box.width) * this.data.frames);
    this.timeLine.goTo(frame, { moving });
  }

  release(event) {
    this.isHeld = false;
    this.follow(event, false);
  }
}
