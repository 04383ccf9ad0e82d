// The controls under the pictures.

const SPEEDS = [0.25, 0.5, 1, 2];
const ICONS = {
  play: "M8 5v14l11-7z",
  pause: "M6 5h4v14H6zm8 0h4v14h-4z",
  back: "M15.4 7.4 14 6l-6 6 6 6 1.4-1.4L10.8 12z",
  forward: "M8.6 16.6 10 18l6-6-6-6-1.4 1.4 4.6 4.6z",
  next: "M6 18l8.5-6L6 6zM16 6v12h2V6z",
  best: "M12 17.3 18.2 21l-1.6-7L22 9.2l-7.2-.6L12 2 9.2 8.6 2 9.2 7.5 14l-1.7 7z",
  sound: "M3 9v6h4l5 5V4L7 9zm13.5 3A4.5 4.5 0 0 0 14 8v8a4.5 4.5 0 0 0 2.5-4z",
  muted: "M3 9v6h4l5 5V4L7 9zm18 .4L19.6 8 17.5 10.1 15.4 8 14 9.4l2.1 2.1L14 13.6l1.4 1.4 2.1-2.1 2.1 2.1 1.4-1.4-2.1-2.1z",
  inspect: "M9.5 3a6.5 6.5 0 0 1 5.2 10.4l.3.3h.8l5 5-1.5 1.5-5-5v-.8l-.3-.3A6.5 6.5 0 1 1 9.5 3m0 2a4.5 4.5 0 1 0 0 9 4.5 4.5 0 0 0 0-9",
};

class Bar {
  constructor(root, timeLine) {
    this.timeLine = timeLine;
    const controls = element("div", "time-line-controls", root);
    const step = (count) => () => timeLine.goTo(timeLine.wanted + count);
    this.makeButton(controls, "back", "Previous frame (←)", step(-1));
    this.playing = this.makeButton(controls, "play", "Play (space)", () => timeLine.player.toggle());
    this.makeButton(controls, "forward", "Next frame (→)", step(1));
    this.makeSpeed(controls);
    this.makeNumber(controls);
    this.time = element("span", "time-line-time", controls);
    this.next = this.makeButton(controls, "next", "Next inspected frame", () => this.goToNext());
    this.best = this.makeButton(controls, "best", "", () => timeLine.tell({ best: 1 }));
    this.best.text = element("span", "", this.best);
    this.inspect = this.makeButton(controls, "inspect", "Detect containers in this frame", () => this.askToInspect());
    element("span", "", this.inspect, { textContent: "Inspect this frame" });
    this.muted = this.makeButton(controls, "sound", "", () => this.toggleMuted());
    this.track = new Track(element("div", "time-line-track", root), timeLine);
  }

  makeButton(parent, icon, label, onclick) {
    const node = element("button", "time-line-button", parent, { type: "button", onclick });
    const svg = node.appendChild(document.createElementNS(SVG, "svg"));
    svg.setAttribute("viewBox", "0 0 24 24");
    svg.setAttribute("aria-hidden", "true");
    node.path = svg.appendChild(document.createElementNS(SVG, "path"));
    this.name(node, icon, label);
    return node;
  }

  name(node, icon, label) {
    node.path.setAttribute("d", ICONS[icon]);
    node.title = label;
    node.setAttribute("aria-label", label.replace(/ \(.*\)$/, ""));
  }

  makeSpeed(parent) {
    const node = element("select", "time-line-speed", parent, { title: "Speed" });
    node.setAttribute("aria-label", "Speed");
    for (const speed of SPEEDS) element("option", "", node, { value: speed, textContent: `${speed}×`, selected: speed === 1 });
    node.onchange = () => this.timeLine.player.setSpeed(Number(node.value));
  }

  makeNumber(parent) {
    this.number = element("input", "time-line-number", parent, { type: "number", min: 0, step: 1 });
    this.number.oninput = () => (this.isTyping = true);
    this.number.onchange = () => {
      this.isTyping = false;
      const frame = Math.round(this.number.valueAsNumber);
      if (Number.isFinite(frame)) this.timeLine.goTo(frame);
      else this.number.value = this.timeLine.frame;
    };
  }

  update(data) {
    this.data = data;
    this.number.max = data.frames - 1;
    this.number.setAttribute("aria-label", `Frame (0 to ${data.frames - 1})`);
    this.next.disabled = !data.inspected.length;
    this.best.disabled = data.best === null;
    const best = data.best === null ? "No best frame" : `${data.best_name}: ${data.best}`;
    this.name(this.best, "best", best);
    this.best.text.textContent = best;
    this.inspect.hidden = !data.can_inspect || data.inspected.length >= data.frames;
    this.muted.hidden = !data.sound;
    this.showMuted();
    this.inspectedSet = new Set(data.inspected);
    this.track.update(data);
  }

  show(frame) {
    const { frames, fps, best } = this.data;
    const time = fps ? `${(frame / fps).toFixed(2)} s` : "";
    if (!this.isTyping) this.number.value = frame;
    this.time.textContent = `of ${frames - 1}${time && `, ${time}`}`;
    this.best.classList.toggle("time-line-pressed", frame === best);
    this.inspect.disabled = this.inspectedSet.has(frame);
    this.track.show(frame, `frame ${frame}${time && `, ${time}`}`);
  }

  showPlaying(isPlaying) {
    this.name(this.playing, isPlaying ? "pause" : "play", isPlaying ? "Pause (space)" : "Play (space)");
  }

  showMuted() {
    const isMuted = this.timeLine.player.audio.muted;
    this.name(this.muted, isMuted ? "muted" : "sound", isMuted ? "Sound off" : "Sound on");
  }

  toggleMuted() {
    const { player } = this.timeLine;
    player.setMuted(!player.audio.muted);
    this.showMuted();
  }

  goToNext() {
    const { inspected } = this.data;
    this.timeLine.goTo(inspected.find((frame) => frame > this.timeLine.wanted) ?? inspected[0]);
  }

  askToInspect() {
    this.inspect.disabled = true;
    this.timeLine.tell({ frame: this.timeLine.wanted, inspect: this.timeLine.wanted });
  }
}
