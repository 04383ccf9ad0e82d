// The page's playhead: the views' pictures of one frame, and a bar to move it. Every redraw shows one frame in all
// views, on the track and as the cursors of the page's linked plots; a frame that is not there yet is waited for.

const STEPS = { ArrowLeft: -1, ArrowRight: 1, PageUp: -10, PageDown: 10, Home: -Infinity, End: Infinity };
const PRESSED_BY_SPACE = "button, a, summary, label, [role='button'], [role='switch'], [role='checkbox']";
const ASK_AGAIN_MS = 5000;

export default function mount(component) {
  return mountAs(TimeLine, component);
}

class TimeLine {
  constructor(parent) {
    this.root = element("div", "time-line", parent, { role: "group" });
    this.reports = new Reports(this.root);
    this.pictures = new Pictures(element("div", "time-line-pictures", this.root));
    this.bar = new Bar(element("div", "time-line-bar", this.root), this);
    this.player = new Player(this);
    this.frame = undefined; // what is shown
    this.wanted = 0; // what is to be shown next
    this.moving = false; // a key is held or the playhead dragged
    this.held = 0; // the step of a held key that waits for the pictures of the one before
    this.told = null; // the last report
    this.onKey = (event) => this.pressKey(event);
    this.onRelease = () => this.moving && !this.bar.track.isHeld && this.settle();
    document.addEventListener("keydown", this.onKey);
    document.addEventListener("keyup", this.onRelease);
    window.addEventListener("blur", this.onRelease);
  }

  remove() {
    document.removeEventListener("keydown", this.onKey);
    document.removeEventListener("keyup", this.onRelease);
    window.removeEventListener("blur", this.onRelease);
    this.player.remove();
    this.pictures.forget(() => true);
    this.reports.end();
    this.isRemoved = true;
    if (window.corsmalPlayhead === this) delete window.corsmalPlayhead;
    window.dispatchEvent(new Event("corsmal-playhead"));
    this.root.remove();
  }

  update(data) {
    const isOther = this.data?.recording !== data.recording;
    this.data = data;
    const isAnswered = this.reports.follow(data.acknowledged);
    if (isOther) this.player.stop({ quietly: true });
    if (isOther || (isAnswered && !this.moving && !this.player.isPlaying)) this.wanted = data.frame;
    if (isOther) this.moving = false;
    this.wanted = this.within(this.wanted);
    window.corsmalPlayhead = this;
    this.root.setAttribute("aria-label", data.label);
    this.root.classList.toggle("time-line-large", data.is_large);
    this.pictures.update(data);
    this.player.update(data);
    this.bar.update(data);
    this.isStale = true; // other pictures, or one that was not there
    this.showWanted();
    this.reports.acknowledge(data.acknowledged);
  }

  within(frame) {
    return Math.min(Math.max(frame, 0), this.data.frames - 1);
  }

  // Move the playhead. While `moving`, more is coming.
  goTo(frame, { moving = false } = {}) {
    this.player.stop({ quietly: true });
    this.wanted = this.within(frame);
    this.moving = moving;
    this.showWanted();
    if (!moving) this.settle();
  }

  settle() {
    this.moving = false;
    this.held = 0;
    this.tell({ frame: this.wanted });
  }

  tell(values) {
    const report = JSON.stringify(values);
    if (report === this.told && values.frame === this.data.frame) return;
    this.told = report;
    this.reports.add({ values, settled: true });
  }

  // Show the wanted frame as soon as all its pictures are there, one frame after the other.
  async showWanted() {
    if (this.isShowing) return;
    this.isShowing = true;
    while (!this.isRemoved && (this.isStale || this.frame !== this.wanted)) {
      this.isStale = false;
      const { isPlaying, every } = this.player;
      const frame = isPlaying ? this.pictures.newestReady(this.frame, this.wanted, every) : this.wanted;
      await this.pictures.ready(frame);
      await new Promise(requestAnimationFrame);
      if (this.isRemoved || this.isStale) continue;
      this.show(frame);
      this.wanted = this.within(this.wanted + this.held);
      this.held = 0;
    }
    this.isShowing = false;
  }

  show(frame) {
    const isLimited = this.player.isPlaying && this.player.every > 1;
    const step = isLimited ? this.player.every : Math.min(Math.max(frame - (this.frame ?? frame), -4), 4) || 1;
    this.frame = frame;
    this.root.dataset.frame = frame;
    const isWhole = this.pictures.show(frame);
    this.bar.show(frame);
    window.dispatchEvent(new Event("corsmal-playhead"));
    this.pictures.fetchAhead(frame, step, isLimited ? FEW : AHEAD);
    this.askForMissing(isWhole || this.moving || this.player.isPlaying);
  }

  // The server may have been started anew: then its page must run before it serves pictures.
  askForMissing(isLeft) {
    const now = performance.now();
    if (isLeft || now - this.askedMs < ASK_AGAIN_MS) return;
    this.askedMs = now;
    this.reports.add({ settled: true });
  }

  pressKey(event) {
    if (!this.data || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    const isInside = this.root.contains(target);
    const isOnTrack = this.bar.track.root.contains(target);
    if (!isOnTrack && target.closest?.(OWN_KEYS)) return;
    if (event.key === " ") {
      if (target.closest?.(PRESSED_BY_SPACE) || !(isInside || target === document.body)) return;
      if (!event.repeat) this.player.toggle();
    } else {
      if (!(event.key in STEPS) || !(isInside || this.data.keys.includes(event.key))) return;
      // A held key waits for the pictures: otherwise it runs away from them, and nothing is shown until it is released.
      if (event.repeat && this.frame !== this.wanted) this.held = STEPS[event.key];
      else this.goTo(this.wanted + STEPS[event.key], { moving: true });
    }
    event.preventDefault();
  }
}
