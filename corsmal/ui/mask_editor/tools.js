// What pointers do: draw with the tool, move a polygon's points, or move and enlarge the picture. A mouse's middle button,
// the space bar or a second finger moves it.

const NEAR = 10; // a pointer that is so near to a point takes it, in pixels of the screen
const CLICK = 3;

class Pointers {
  constructor(node, canvas) {
    this.canvas = canvas;
    this.node = node;
    this.down = new Map(); // by pointer, its place on the canvas
    this.at = null; // of the pointer, in the picture
    this.points = null; // of the stroke that is being drawn
    node.onpointerdown = (event) => this.press(event);
    node.onpointermove = (event) => this.move(event);
    node.onpointerup = node.onpointercancel = (event) => this.release(event);
    node.onpointerleave = () => {
      this.at = null;
      canvas.draw();
    };
    node.oncontextmenu = (event) => event.preventDefault();
    node.addEventListener("wheel", (event) => this.turn(event), { passive: false });
    node.ondblclick = () => this.editor.shape.finish();
    window.addEventListener("keydown", (event) => (this.isSpace = event.key === " " || this.isSpace));
    window.addEventListener("keyup", (event) => (this.isSpace = event.key === " " ? false : this.isSpace));
  }

  get editor() {
    return this.canvas.editor;
  }

  placeOf(event) {
    const { left, top } = this.node.getBoundingClientRect();
    const ratio = this.canvas.ratio ?? 1;
    return [(event.clientX - left) * ratio, (event.clientY - top) * ratio];
  }

  press(event) {
    this.node.focus({ preventScroll: true });
    this.node.setPointerCapture(event.pointerId);
    const place = this.placeOf(event);
    this.down.set(event.pointerId, place);
    if (this.down.size > 1) {
      this.points = null; // what one finger began was meant as the first of two
      this.canvas.showMask();
    }
    this.isMoving = this.down.size > 1 || event.button === 1 || this.isSpace || this.editor.data.is_read_only;
    if (!this.isMoving) this.begin(this.canvas.toPicture(place), event);
    event.preventDefault();
  }

  begin(at, event) {
    const { tool, shape } = this.editor;
    if (tool === "polygon") shape.takePoint(at, this.reach);
    else if (tool === "fill") this.editor.act("fill", { points: [at] });
    else this.points = [at];
    this.isOutside = event.shiftKey || event.button === 2;
    if (this.points && tool !== "propose") this.drawStroke([at]);
  }

  get reach() {
    return (NEAR * (this.canvas.ratio ?? 1)) / this.canvas.zoom;
  }

  move(event) {
    const place = this.placeOf(event);
    const before = this.down.get(event.pointerId);
    this.at = this.canvas.toPicture(place);
    if (before && this.isMoving) this.movePicture(event.pointerId, before, place);
    else if (before && this.points) this.extend(event);
    else if (before) this.editor.shape.movePoint(this.at);
    if (before) this.down.set(event.pointerId, place);
    this.canvas.draw();
  }

  extend(event) {
    const passed = (event.getCoalescedEvents?.() ?? []).map((each) => this.canvas.toPicture(this.placeOf(each)));
    const added = passed.length ? passed : [this.at];
    const from = this.points.at(-1);
    this.points.push(...added);
    if (this.editor.tool === "propose") this.editor.shape.trace(this.points, this.isOutside);
    else this.drawStroke([from, ...added]);
  }

  drawStroke(points) {
    this.canvas.stroke(points, this.editor.radius, this.editor.tool === "eraser");
    this.canvas.draw();
  }

  movePicture(id, before, place) {
    const other = [...this.down].find(([each]) => each !== id)?.[1];
    const moved = [place[0] - before[0], place[1] - before[1]];
    if (!other) return this.canvas.change(1, place, moved);
    const distance = ([x, y]) => Math.hypot(x - other[0], y - other[1]);
    const middle = [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
    this.canvas.change(distance(place) / Math.max(distance(before), 1), middle, [moved[0] / 2, moved[1] / 2]);
  }

  release(event) {
    this.down.delete(event.pointerId);
    const { points, editor } = this;
    this.points = null;
    if (!points) editor.shape.dropPoint();
    else if (editor.tool === "propose") editor.shape.endTrace(points, this.isOutside);
    else editor.act(editor.tool, { points: points.map(rounded), radius: editor.radius });
    this.canvas.draw();
  }

  turn(event) {
    this.canvas.change(Math.exp(-event.deltaY / 400), this.placeOf(event));
    event.preventDefault();
  }
}

function rounded([x, y]) {
  return [Math.round(16 * x) / 16, Math.round(16 * y) / 16];
}

// What is drawn on the picture before it is sent: a polygon whose points can be moved, or a box and strokes in and beside
// the container, for a proposal.
class Shape {
  constructor(editor) {
    this.editor = editor;
    this.clear();
  }

  clear() {
    this.points = [];
    this.box = null;
    this.inside = [];
    this.outside = [];
    this.held = this.last = null;
    this.wasSent = this.isClosing = false;
    this.traced = null;
    this.editor.canvas?.draw();
    this.editor.bar?.show();
  }

  // Take the point that is near, or put one into the side that is near, or add one.
  takePoint(at, reach) {
    const distances = this.points.map(([x, y]) => Math.hypot(x - at[0], y - at[1]));
    const nearest = distances.indexOf(Math.min(...distances));
    if (nearest === 0 && this.points.length > 2 && distances[0] < reach && !this.wasSent) this.isClosing = true;
    if (nearest >= 0 && distances[nearest] < reach) this.held = nearest;
    else {
      const side = this.sideNear(at, reach);
      this.held = side ?? this.points.length;
      this.points.splice(this.held, 0, at);
    }
    this.last = this.held;
    this.start = at;
    this.editor.bar.show();
  }

  sideNear(at, reach) {
    const count = this.points.length;
    for (let index = 1; index < count + (this.wasSent ? 1 : 0); index++) {
      const [from, to] = [this.points[index - 1], this.points[index % count]];
      const along = [to[0] - from[0], to[1] - from[1]];
      const share = ((at[0] - from[0]) * along[0] + (at[1] - from[1]) * along[1]) / (along[0] ** 2 + along[1] ** 2 || 1);
      const distance = Math.hypot(from[0] + share * along[0] - at[0], from[1] + share * along[1] - at[1]);
      if (share > 0 && share < 1 && distance < reach / 2) return index;
    }
    return null;
  }

  movePoint(at) {
    if (this.held === null) return;
    if (Math.hypot(at[0] - this.start[0], at[1] - this.start[1]) > CLICK / this.editor.canvas.zoom) this.isClosing = false;
    this.points[this.held] = at;
  }

  dropPoint() {
    const wasHeld = this.held !== null;
    this.held = null;
    if (this.isClosing) this.finish();
    else if (wasHeld && this.wasSent) this.send();
    this.isClosing = false;
  }

  removePoint() {
    if (!this.points.length) return;
    this.points.splice(this.last ?? this.points.length - 1, 1);
    this.last = null;
    if (this.points.length < 3) this.wasSent = false;
    else if (this.wasSent) this.send();
    this.editor.canvas.draw();
    this.editor.bar.show();
  }

  trace(points, isOutside) {
    this.traced = { points, isOutside };
  }

  endTrace(points, isOutside) {
    this.traced = null;
    if (!this.box) {
      const [from, to] = [points[0], points.at(-1)];
      const box = [Math.min(from[0], to[0]), Math.min(from[1], to[1]), Math.max(from[0], to[0]), Math.max(from[1], to[1])];
      if (box[2] - box[0] > 2 && box[3] - box[1] > 2) this.box = box.map((side) => Math.round(side));
    } else (isOutside ? this.outside : this.inside).push(points.map(rounded));
    if (this.box) this.finish();
  }

  finish() {
    if (this.editor.tool === "polygon" && this.points.length > 2) {
      this.wasSent = true;
      this.send();
    } else if (this.editor.tool === "propose" && this.box) {
      this.editor.act("propose", { box: this.box, inside: this.inside, outside: this.outside });
    }
    this.editor.bar.show();
  }

  send() {
    this.editor.act("polygon", { points: this.points.map(rounded) });
  }

  paint(context, line) {
    Object.assign(context, { strokeStyle: SHAPE_COLOUR, fillStyle: "#fff", lineWidth: line });
    if (this.points.length) {
      context.beginPath();
      this.points.forEach(([x, y]) => context.lineTo(x, y));
      if (this.wasSent) context.closePath();
      context.stroke();
      for (const [x, y] of this.points) {
        context.beginPath();
        context.arc(x, y, 3 * line, 0, 2 * Math.PI);
        context.fill();
        context.stroke();
      }
    }
    const traced = this.traced && !this.box ? [this.traced.points[0], this.traced.points.at(-1)] : null;
    const box = this.box ?? (traced && [...traced[0], ...traced[1]]);
    if (box) context.strokeRect(box[0], box[1], box[2] - box[0], box[3] - box[1]);
    const strokes = [...this.inside.map((points) => [points, "#fff"]), ...this.outside.map((points) => [points, "#d55e00"])];
    if (this.box && this.traced) strokes.push([this.traced.points, this.traced.isOutside ? "#d55e00" : "#fff"]);
    for (const [points, colour] of strokes) {
      Object.assign(context, { strokeStyle: colour, lineWidth: 2 * line });
      context.beginPath();
      points.forEach(([x, y]) => context.lineTo(x, y));
      context.stroke();
    }
  }
}
