// A picture that is enlarged and moved, and what is drawn on it. All places are in pixels of the picture: (0.5, 0.5) is
// the middle of its first one.

const MASK_COLOUR = [0, 158, 115];
const AMODAL_COLOUR = [86, 180, 233];
const HULL_COLOUR = "#cc79a7";
const DETECTED_COLOUR = "#f0e442";
const SHAPE_COLOUR = "#e69f00";
const ZOOM_MAX = 40;
const AROUND = 0.6; // of a mask's size, shown around it

const pictures = new Map();

// A picture by its address; `ready` is called once it is there.
function picture(url, ready = () => {}) {
  if (!pictures.has(url)) {
    pictures.set(url, Object.assign(new Image(), { src: url }));
    if (pictures.size > 24) pictures.delete(pictures.keys().next().value);
  }
  const image = pictures.get(url);
  if (image.complete && image.naturalWidth) ready();
  else image.addEventListener("load", ready, { once: true });
  return image;
}

// Run lengths, column by column, as a picture that is transparent where the mask is not.
function maskPicture(runs, [width, height], [red, green, blue], opacity = 80) {
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  const context = canvas.getContext("2d");
  const pixels = context.createImageData(width, height);
  let place = 0;
  runs.forEach((length, index) => {
    if (index % 2) {
      for (let step = place; step < place + length; step++) {
        pixels.data.set([red, green, blue, opacity], 4 * ((step % height) * width + Math.floor(step / height)));
      }
    }
    place += length;
  });
  context.putImageData(pixels, 0, 0);
  return canvas;
}

function boxOf(runs, height) {
  let [place, left, right, top, bottom] = [0, Infinity, -Infinity, Infinity, -Infinity];
  runs.forEach((length, index) => {
    if (index % 2 && length) {
      const [first, last] = [Math.floor(place / height), Math.floor((place + length - 1) / height)];
      left = Math.min(left, first);
      right = Math.max(right, last + 1);
      top = Math.min(top, last > first ? 0 : place % height);
      bottom = Math.max(bottom, last > first ? height : (place % height) + length);
    }
    place += length;
  });
  return right > left ? [left, top, right, bottom] : null;
}

function drawOutlines(context, outlines, colour, width, dash) {
  context.save();
  Object.assign(context, { strokeStyle: colour, lineWidth: width });
  context.setLineDash(dash);
  for (const outline of outlines) {
    context.beginPath();
    outline.forEach(([x, y]) => context.lineTo(x, y));
    context.closePath();
    context.stroke();
  }
  context.restore();
}

class EditorCanvas {
  constructor(root, editor) {
    this.editor = editor;
    this.node = element("canvas", "mask-editor-canvas", root, { tabIndex: 0 });
    this.node.setAttribute("aria-label", "Mask");
    this.context = this.node.getContext("2d");
    this.zoom = 1;
    this.origin = [0, 0]; // of the picture, in pixels of the canvas
    this.pointers = new Pointers(this.node, this);
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(root);
    this.root = root;
  }

  remove() {
    this.observer.disconnect();
  }

  resize() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.root;
    if (!width || !height) return;
    Object.assign(this.node, { width: width * ratio, height: height * ratio });
    this.ratio = ratio;
    if (this.isFitted !== undefined) this.fit(this.isFitted);
    else this.draw();
  }

  showPicture(isOther) {
    if (isOther) this.fit(true); // not once the picture is there: somebody may have moved it by then
    picture(this.editor.view.url, () => this.draw());
  }

  // Take over the server's mask.
  showMask() {
    const { editor } = this;
    const { runs, view } = editor;
    const colour = editor.layer === "amodal" ? AMODAL_COLOUR : MASK_COLOUR;
    this.mask = runs ? maskPicture(runs, view.size, colour) : Object.assign(document.createElement("canvas"), { width: view.size[0], height: view.size[1] });
  }

  // Draw a stroke as the server will do it.
  stroke(points, radius, isEraser) {
    const context = this.mask.getContext("2d");
    context.save();
    context.globalCompositeOperation = isEraser ? "destination-out" : "source-over";
    const colour = `rgb(${(this.editor.layer === "amodal" ? AMODAL_COLOUR : MASK_COLOUR).join(" ")} / ${isEraser ? 1 : 0.31})`;
    Object.assign(context, { strokeStyle: colour, lineWidth: 2 * radius, lineCap: "round", lineJoin: "round" });
    context.beginPath();
    points.forEach(([x, y]) => context.lineTo(x, y));
    context.lineTo(points.at(-1)[0] + 0.01, points.at(-1)[1]);
    context.stroke();
    context.restore();
  }

  // Show the whole picture, or the surroundings of the mask.
  fit(isAroundMask) {
    const { view } = this.editor;
    const [width, height] = view.size;
    const around = isAroundMask && (boxOf(view.mask ?? [], height) ?? view.around);
    let box = [0, 0, width, height];
    if (around) {
      const margin = AROUND * Math.max(around[2] - around[0], around[3] - around[1]);
      box = [around[0] - margin, around[1] - margin, around[2] + margin, around[3] + margin];
    }
    this.isFitted = isAroundMask;
    this.zoom = Math.min(this.node.width / (box[2] - box[0]), this.node.height / (box[3] - box[1]));
    this.origin = [this.node.width / 2 - (this.zoom * (box[0] + box[2])) / 2, this.node.height / 2 - (this.zoom * (box[1] + box[3])) / 2];
    this.draw();
  }

  // Enlarge about a place of the canvas, and move by a distance on it.
  change(factor, [x, y], [dx, dy] = [0, 0]) {
    const smallest = 0.5 * Math.min(this.node.width / this.editor.view.size[0], this.node.height / this.editor.view.size[1]);
    const zoom = Math.min(Math.max(this.zoom * factor, smallest), ZOOM_MAX * (this.ratio ?? 1));
    this.origin = [x - (zoom / this.zoom) * (x - this.origin[0]) + dx, y - (zoom / this.zoom) * (y - this.origin[1]) + dy];
    this.zoom = zoom;
    this.isFitted = undefined;
    this.draw();
  }

  toPicture([x, y]) {
    return [(x - this.origin[0]) / this.zoom, (y - this.origin[1]) / this.zoom];
  }

  draw() {
    if (this.isDrawing) return;
    this.isDrawing = true;
    requestAnimationFrame(() => {
      this.isDrawing = false;
      if (this.editor.data) this.paint();
    });
  }

  paint() {
    const { context, node, editor } = this;
    const { view } = editor;
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, node.width, node.height);
    context.setTransform(this.zoom, 0, 0, this.zoom, ...this.origin);
    node.dataset.shown = [this.zoom, ...this.origin].map((value) => (value / (this.ratio ?? 1)).toFixed(3)).join(" ");
    const shown = picture(view.url);
    context.imageSmoothingEnabled = this.zoom < 3;
    if (shown.complete && shown.naturalWidth) context.drawImage(shown, 0, 0, ...view.size);
    if (this.mask && !editor.bar.isHidden) context.drawImage(this.mask, 0, 0);
    const line = (1.5 * (this.ratio ?? 1)) / this.zoom;
    drawOutlines(context, view.detected, DETECTED_COLOUR, line, [4 * line, 3 * line]);
    drawOutlines(context, view.hull, HULL_COLOUR, line, []);
    editor.shape.paint(context, line);
    const { at } = this.pointers;
    if (at && (editor.tool === "brush" || editor.tool === "eraser")) {
      Object.assign(context, { strokeStyle: "#fff", lineWidth: line });
      context.beginPath();
      context.arc(...at, editor.radius, 0, 2 * Math.PI);
      context.stroke();
    }
  }
}
