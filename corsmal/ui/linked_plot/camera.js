// From where a plot in 3D is seen, kept by the page: reported when the user turned it, and moved when the page says so.

const CAMERA_REST_MS = 150; // the view still turns a little after the mouse button came up

class FollowedCamera {
  constructor(plot) {
    this.plot = plot;
    this.asked = null; // what the page said last
    this.at = null; // where the camera is, as last reported or moved to
  }

  remove() {
    clearTimeout(this.timer);
  }

  isToMove(asked) {
    if (sameCamera(asked, this.asked)) return false;
    this.asked = asked;
    return !sameCamera(asked, this.at);
  }

  async move(asked, first) {
    this.at = asked;
    await window.Plotly.relayout(this.plot.figure, { "scene.camera": asked ? plotlyCamera(asked) : first });
    this.at = this.now();
  }

  report(before = null) {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => {
      const now = this.now();
      if (!now) return;
      if (!sameCamera(now, before)) this.report(now);
      else if (!sameCamera(now, this.at)) {
        this.at = now;
        this.plot.reports.add({ camera: now });
      }
    }, CAMERA_REST_MS);
  }

  now() {
    const camera = this.plot.figure._fullLayout?.scene?._scene?.getCamera();
    if (!camera) return null;
    return [camera.eye, camera.center].flatMap(({ x, y, z }) => [x, y, z].map((value) => Math.round(1000 * value) / 1000));
  }
}

function plotlyCamera([x, y, z, ...center]) {
  return { eye: { x, y, z }, center: { x: center[0], y: center[1], z: center[2] }, up: { x: 0, y: 0, z: 1 } };
}

function sameCamera(one, other) {
  if (!one || !other) return one === other;
  return one.every((value, index) => Math.abs(value - other[index]) < 0.002);
}
