// Plays the frames by the clock, and the sound with them.

const FPS_UNKNOWN = 30;
const DRIFT_S = 0.15; // the sound is moved when it is off by more
const DRAWN_BY_CORES_PER_S = 2.5; // a redraw takes a twentieth of a second of a core there
const MUTED = "corsmal-muted";

let areCores; // found out once

// Whether pages are drawn without a graphics card.
function drawnByCores() {
  if (areCores === undefined) {
    const context = document.createElement("canvas").getContext("webgl");
    const names = context?.getExtension("WEBGL_debug_renderer_info");
    const name = context ? context.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER) : "software";
    areCores = /software|swiftshader|llvmpipe|basic render/i.test(name);
    context?.getExtension("WEBGL_lose_context")?.loseContext();
  }
  return areCores;
}

class Player {
  constructor(timeLine) {
    this.timeLine = timeLine;
    this.isPlaying = false;
    this.speed = 1;
    this.audio = element("audio", "", timeLine.root, { hidden: true, preload: "none" });
    this.audio.muted = localStorage.getItem(MUTED) === "true";
  }

  remove() {
    this.stop({ quietly: true });
    URL.revokeObjectURL(this.audio.src);
  }

  update(data) {
    this.fps = data.fps || FPS_UNKNOWN;
    if (this.sound === data.sound) return;
    this.sound = data.sound;
    this.audio.pause();
    URL.revokeObjectURL(this.audio.src);
    this.audio.removeAttribute("src");
    if (this.isPlaying) this.playSound();
  }

  toggle() {
    if (this.isPlaying) this.stop();
    else this.play();
  }

  play() {
    const { timeLine } = this;
    if (timeLine.wanted >= timeLine.data.frames - 1) timeLine.wanted = 0;
    this.isPlaying = true;
    this.begin();
    this.playSound();
    timeLine.bar.showPlaying(true);
    timeLine.showWanted();
  }

  stop({ quietly = false } = {}) {
    if (!this.isPlaying) return;
    this.isPlaying = false;
    this.rest();
    this.audio.pause();
    this.timeLine.bar.showPlaying(false);
    if (quietly) return;
    this.timeLine.wanted = this.timeLine.frame ?? this.timeLine.wanted;
    this.timeLine.settle();
  }

  setSpeed(speed) {
    this.speed = speed;
    this.audio.playbackRate = speed;
    if (this.isPlaying) this.begin();
  }

  setMuted(muted) {
    this.audio.muted = muted;
    localStorage.setItem(MUTED, muted);
  }

  // Count the clock from here.
  begin() {
    this.from = { frame: this.timeLine.wanted, ms: performance.now() };
    this.tickNext();
  }

  // At the next redraw of the screen; beside a search, whose cores that takes, twice per picture.
  tickNext() {
    this.rest();
    const tick = () => this.tick();
    if (this.mostPerS) this.waiting = setTimeout(tick, 500 / this.mostPerS);
    else this.ticking = requestAnimationFrame(tick);
  }

  rest() {
    clearTimeout(this.waiting);
    cancelAnimationFrame(this.ticking);
  }

  // How many pictures per second are shown at most; null: no limit.
  get mostPerS() {
    const { most_per_s } = this.timeLine.data;
    return most_per_s && drawnByCores() ? Math.min(most_per_s, DRAWN_BY_CORES_PER_S) : most_per_s;
  }

  // How many frames lie between two that are shown, where that is limited.
  get every() {
    return this.mostPerS ? Math.max(1, Math.round((this.fps * this.speed) / this.mostPerS)) : 1;
  }

  tick() {
    if (!this.isPlaying) return;
    const { timeLine, from } = this;
    const last = timeLine.data.frames - 1;
    const frame = from.frame + ((performance.now() - from.ms) / 1000) * this.fps * this.speed;
    const passed = this.every * Math.floor((frame - from.frame) / this.every);
    timeLine.wanted = frame < last ? Math.min(from.frame + passed, last) : last;
    if (frame > last + 1 && timeLine.frame === last) {
      this.stop();
      return;
    }
    this.keepSound(Math.min(frame, last) / this.fps);
    timeLine.showWanted();
    this.tickNext();
  }

  async playSound() {
    const { sound } = this;
    if (!sound) return;
    if (!this.audio.src) {
      // whole: without ranges browsers seek in nothing else
      const whole = await fetch(sound).then((reply) => (reply.ok ? reply.blob() : null), () => null).catch(() => null);
      if (!whole || this.sound !== sound) return;
      this.audio.src = URL.createObjectURL(whole);
    }
    if (!this.isPlaying) return;
    this.audio.playbackRate = this.speed;
    this.audio.currentTime = this.timeLine.wanted / this.fps;
    this.audio.play().catch(() => {}); // refused by the browser, or paused again: the pictures play without
  }

  keepSound(nowS) {
    const { audio } = this;
    if (audio.paused || audio.seeking || nowS >= audio.duration) return;
    if (Math.abs(audio.currentTime - nowS) > DRIFT_S * Math.max(1, this.speed)) audio.currentTime = nowS;
  }
}
