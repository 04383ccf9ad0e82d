// The editor's buttons.

const EDITOR_ICONS = {
  brush: "M7 14c-1.7 0-3 1.3-3 3 0 1.3-1.2 2-2 2 .9 1.2 2.5 2 4 2 2.2 0 4-1.8 4-4 0-1.700-1.300-3-3-3zm13.700-9.400-1.300-1.300a1 1 0 0 0-1.400 0L9 12.200 11.800 15l8.900-8.900a1 1 0 0 0 0-1.500z",
  eraser: "M15.100 3.600 2.900 15.800a2 2 0 0 0 0 2.800L5.300 21H21v-2h-8.200l7.600-7.600a2 2 0 0 0 0-2.800l-5-5a2 2 0 0 0-.3 0zM9 19H6.100l-1.800-1.800 4-4 4.800 4.800z",
  polygon: "M12 2 2 9.500 5.800 21h12.400L22 9.500zm0 2.500 7.600 5.700L16.800 19H7.200L4.400 10.200z",
  fill: "M16.600 9 7.600 0 6.200 1.400l2.400 2.400-5.100 5.100a1.500 1.500 0 0 0 0 2.100l5.500 5.500a1.500 1.500 0 0 0 2.100 0l5.500-5.500a1.500 1.500 0 0 0 0-2zM5.200 10 10 5.200l4.800 4.800zM19 11.500s-2 2.200-2 3.500a2 2 0 0 0 4 0c0-1.300-2-3.500-2-3.500z",
  propose: "M7.500 5.600 10 7 8.600 4.500 10 2 7.500 3.400 5 2l1.400 2.500L5 7zm12 9.800L17 14l1.400 2.500L17 19l2.500-1.400L22 19l-1.400-2.500L22 14zM14.400 7.300a1 1 0 0 0-1.400 0L1.300 19a1 1 0 0 0 0 1.400l2.300 2.300a1 1 0 0 0 1.400 0L16.700 11a1 1 0 0 0 0-1.400z",
  undo: "M12.500 8c-2.600 0-5 1-6.900 2.600L2 7v9h9l-3.600-3.600a8 8 0 0 1 12.700 3.100l2.400-.8A10.500 10.500 0 0 0 12.500 8z",
  redo: "M18.400 10.600A10.500 10.500 0 0 0 1.500 14.700l2.400.8a8 8 0 0 1 12.700-3.100L13 16h9V7z",
};
const TOOL_NAMES = {
  brush: "Brush (B)",
  eraser: "Eraser (E)",
  polygon: "Polygon (P): click corners, Enter or a double click ends it, then drag them",
  fill: "Fill a hole (F)",
  propose: "Propose (G): draw a box, then strokes on the container, with Shift beside it",
};
const LAYERS = { visible: "Visible pixels", amodal: "Whole outline" };

class EditorBar {
  constructor(root, editor) {
    this.editor = editor;
    this.root = root;
    this.tools = Object.entries(TOOL_NAMES).map(([tool, name]) => [tool, this.button(tool, name, () => editor.choose(tool))]);
    const size = element("label", "mask-editor-size", root, { title: "Radius of brush and eraser, in pixels (− and +)" });
    this.size = element("input", "", size, { type: "range", min: 1, max: RADIUS_MAX, step: 1 });
    this.size.setAttribute("aria-label", "Radius (px)");
    this.size.oninput = () => editor.setRadius(this.size.valueAsNumber);
    this.radius = element("span", "", size);
    this.undo = this.button("undo", "Undo (Z)", () => editor.act("undo"));
    this.redo = this.button("redo", "Redo (Y)", () => editor.act("redo"));
    this.layers = Object.entries(LAYERS).map(([layer, name]) => [layer, this.text(name, () => editor.chooseLayer(layer), `${name} (A)`)]);
    this.text("Whole picture", () => editor.canvas.fit(false), "Whole picture (0)");
    this.text("Container", () => editor.canvas.fit(true), "Enlarge the container (9)");
    this.hide = this.text("Hide mask", () => this.toggleMask());
    this.accept = this.text("Accept", () => editor.act("accept"));
    this.propagate = this.text("Propagate", () => editor.act("propagate"), "Carry the masks of this frame on to the next frames, in all views");
    this.removing = this.text("Use detection", () => editor.act("remove"), "Remove the mask by hand of this view and frame; undo brings it back");
    this.name = element("input", "mask-editor-name", root, { placeholder: "Your name", maxLength: 60, value: localStorage.getItem(NAME_KEY) ?? "" });
    this.name.setAttribute("aria-label", "Your name, kept with the masks you draw");
    this.name.onchange = () => localStorage.setItem(NAME_KEY, this.name.value.trim());
  }

  button(icon, label, onclick) {
    const node = element("button", "mask-editor-button", this.root, { type: "button", title: label, onclick });
    const svg = node.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "svg"));
    svg.setAttribute("viewBox", "0 0 24 24");
    svg.setAttribute("aria-hidden", "true");
    svg.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "path")).setAttribute("d", EDITOR_ICONS[icon]);
    node.setAttribute("aria-label", label.replace(/ \(.*$/, ""));
    return node;
  }

  text(label, onclick, title = "") {
    return element("button", "mask-editor-button", this.root, { type: "button", textContent: label, title, onclick });
  }

  toggleMask() {
    this.isHidden = !this.isHidden;
    this.show();
    this.editor.canvas.draw();
  }

  show() {
    const { editor } = this;
    if (!editor.data) return;
    const { is_read_only: isReadOnly } = editor.data;
    const press = (node, isPressed) => {
      node.classList.toggle("mask-editor-pressed", Boolean(isPressed));
      node.setAttribute("aria-pressed", Boolean(isPressed));
    };
    for (const [tool, node] of this.tools) {
      press(node, tool === editor.tool);
      node.disabled = isReadOnly;
    }
    for (const [layer, node] of this.layers) press(node, layer === editor.layer);
    press(this.hide, this.isHidden);
    this.size.value = editor.radius;
    this.radius.textContent = `${editor.radius} px`;
    this.undo.disabled = isReadOnly || !editor.view.can_undo;
    this.redo.disabled = isReadOnly || !editor.view.can_redo;
    this.undo.title = `Undo (Z): ${editor.view.can_undo} steps`;
    this.accept.hidden = !editor.data.views.some((view) => view.is_open);
    this.propagate.disabled = isReadOnly || !editor.data.views.some((view) => view.is_by_hand);
    this.removing.disabled = isReadOnly || !editor.view.is_by_hand;
    this.name.hidden = isReadOnly;
  }
}
