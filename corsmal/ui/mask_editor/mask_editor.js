// The editor of masks by hand: one view's picture, enlarged, with its mask, and the other views beside it. Tools draw at
// once what they will do; the server does it, keeps it, fits the hull, and answers with the mask that counts.

const TOOL_KEYS = { b: "brush", e: "eraser", p: "polygon", f: "fill", g: "propose" };
const RADIUS_MAX = 100;
const NAME_KEY = "corsmal-name";

export default function mount(component) {
  return mountAs(MaskEditor, component);
}

class MaskEditor {
  constructor(parent) {
    this.root = element("div", "mask-editor", parent, { role: "group", tabIndex: -1 });
    this.reports = new Reports(this.root);
    this.tool = "brush";
    this.layer = "visible";
    this.radius = 8;
    this.shape = new Shape(this); // a polygon or a prompt that is not sent yet
    this.bar = new EditorBar(element("div", "mask-editor-bar", this.root), this);
    const stage = element("div", "mask-editor-stage", this.root);
    this.canvas = new EditorCanvas(element("div", "mask-editor-main", stage), this);
    const side = element("div", "mask-editor-side", stage);
    this.numbers = element("table", "mask-editor-numbers", side);
    this.others = new OtherViews(element("div", "mask-editor-others", side), this);
    this.said = element("p", "mask-editor-said", this.root, { role: "status" });
    this.onKey = (event) => this.pressKey(event);
    document.addEventListener("keydown", this.onKey);
  }

  remove() {
    document.removeEventListener("keydown", this.onKey);
    this.canvas.remove();
    this.reports.end();
    this.root.remove();
  }

  get view() {
    return this.data.views.find((view) => view.name === this.data.active);
  }

  // The mask that the chosen layer shows, as run lengths column by column.
  get runs() {
    return this.layer === "amodal" ? (this.view.amodal ?? this.view.mask) : this.view.mask;
  }

  update(data) {
    const place = `${data.recording} ${data.frame} ${data.active}`;
    const isOther = this.place !== place;
    this.place = place;
    this.data = data;
    const isAnswered = this.reports.follow(data.acknowledged);
    this.root.setAttribute("aria-label", data.label);
    if (isOther) this.shape.clear();
    if (isOther || isAnswered) this.canvas.showMask();
    if (isAnswered && this.sentMs) this.root.dataset.lagMs = Math.round(performance.now() - this.sentMs);
    if (isAnswered) this.sentMs = null;
    this.canvas.showPicture(isOther);
    this.others.update(data);
    this.showNumbers();
    this.bar.show();
    const { name, title, source } = this.view;
    this.said.textContent = [`${name}, ${title}: ${source}.`, ...data.said].join(" ");
    this.reports.acknowledge(data.acknowledged);
  }

  // The quantities with the masks as they are detected and as they are drawn, and the truth.
  showNumbers() {
    const { head, rows } = this.data.numbers;
    this.numbers.replaceChildren();
    for (const cells of [head, ...rows]) {
      const row = element("tr", "", this.numbers);
      for (const textContent of cells) element(cells === head ? "th" : "td", "", row, { textContent });
    }
  }

  choose(tool) {
    this.tool = tool;
    this.shape.clear();
    this.bar.show();
    this.canvas.draw();
  }

  chooseLayer(layer) {
    this.layer = layer;
    this.bar.show();
    this.canvas.showMask();
    this.canvas.draw();
  }

  setRadius(radius) {
    this.radius = Math.min(Math.max(Math.round(radius), 1), RADIUS_MAX);
    this.bar.show();
    this.canvas.draw();
  }

  // Have the server do something to the mask of the view that is edited.
  act(tool, details = {}) {
    if (this.data.is_read_only) return;
    const { name, version } = this.view;
    const who = localStorage.getItem(NAME_KEY) ?? "";
    const action = { tool, view: name, frame: this.data.frame, layer: this.layer, after: version, who, ...details };
    this.sentMs ??= performance.now();
    this.reports.add({ actions: [...(this.reports.pending?.actions ?? []), action] });
  }

  open(view) {
    this.reports.add({ values: { view } });
  }

  pressKey(event) {
    if (!this.data || event.defaultPrevented || event.altKey) return;
    const { target } = event;
    if (!this.root.contains(target) && target !== document.body) return;
    if (target.closest?.("input, textarea, select")) return;
    const key = event.key.toLowerCase();
    if (event.ctrlKey || event.metaKey) {
      if (key !== "z" && key !== "y") return;
      this.act(key === "y" || event.shiftKey ? "redo" : "undo");
    } else if (key in TOOL_KEYS) this.choose(TOOL_KEYS[key]);
    else if (key === "z") this.act("undo");
    else if (key === "y") this.act("redo");
    else if (key === "-" || key === ",") this.setRadius(this.radius / 1.25 - 0.5);
    else if (key === "+" || key === ".") this.setRadius(this.radius * 1.25 + 0.5);
    else if (key === "0") this.canvas.fit(false);
    else if (key === "9") this.canvas.fit(true);
    else if (key === "a") this.chooseLayer(this.layer === "amodal" ? "visible" : "amodal");
    else if (key === "enter") this.shape.finish();
    else if (key === "escape") this.shape.clear();
    else if (key === "delete" || key === "backspace") this.shape.removePoint();
    else return;
    event.preventDefault();
  }
}

// The other views: their masks, and the outline of the hull as a hint of where the edge should be. A click opens one.
class OtherViews {
  constructor(root, editor) {
    this.root = root;
    this.editor = editor;
    this.shown = new Map();
  }

  update(data) {
    for (const view of data.views) {
      if (!this.shown.has(view.name)) this.make(view.name);
      const { button, canvas, caption } = this.shown.get(view.name);
      button.hidden = view.name === data.active;
      caption.textContent = `${view.name}, ${view.title}: ${view.source}`;
      picture(view.url, () => this.draw(canvas, view));
    }
  }

  make(name) {
    const button = element("button", "mask-editor-other", this.root, { type: "button", onclick: () => this.editor.open(name) });
    button.setAttribute("aria-label", `Edit ${name}`);
    this.shown.set(name, { button, canvas: element("canvas", "", button), caption: element("span", "", button) });
  }

  draw(canvas, view) {
    const [width, height] = view.size;
    const scale = 480 / width;
    Object.assign(canvas, { width: 480, height: Math.round(height * scale) });
    const context = canvas.getContext("2d");
    context.scale(scale, scale);
    context.drawImage(picture(view.url), 0, 0, width, height);
    if (view.mask) context.drawImage(maskPicture(view.mask, view.size, MASK_COLOUR), 0, 0);
    drawOutlines(context, view.hull, HULL_COLOUR, 2 / scale, []);
  }
}
