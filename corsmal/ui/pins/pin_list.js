// The pins of a collection: ordered by dragging or with the arrow keys, each with a note; the server owns them.

export default function mount(component) {
  return mountAs(PinList, component);
}

const DETAILS = 4; // numbers that are shown of a pin; the others are in its tooltip, and in the report

class PinList {
  constructor(parent) {
    this.root = element("div", "pin-list", parent);
    this.list = element("ol", "pin-list-pins", this.root);
    this.list.setAttribute("aria-label", "Pins in order");
    this.undo = element("div", "pin-list-undo", this.root);
    this.undone = element("span", "", this.undo);
    const button = element("button", "pin-list-button", this.undo, { type: "button", textContent: "Undo" });
    button.onclick = () => this.act({ do: "restore" });
    this.said = element("p", "pin-list-said", this.root, { role: "status" });
    this.reports = new Reports(this.root);
    this.rows = new Map();
    this.list.onpointermove = (event) => this.drag(event);
    this.list.onpointerup = this.list.onpointercancel = () => this.drop();
  }

  remove() {
    this.reports.end();
    this.root.remove();
  }

  update(data) {
    this.data = data;
    const settled = this.reports.follow(data.acknowledged);
    if (settled && !this.dragged) this.show();
    this.reports.acknowledge(data.acknowledged);
  }

  show() {
    const { pins, removed, can_change: canChange } = this.data;
    this.undo.hidden = !removed || !canChange;
    this.undone.textContent = `Removed: ${removed}`;
    const ids = new Set(pins.map((pin) => pin.id));
    for (const [id, row] of this.rows) {
      if (ids.has(id)) continue;
      row.item.remove();
      this.rows.delete(id);
    }
    pins.forEach((pin, index) => {
      if (!this.rows.has(pin.id)) this.rows.set(pin.id, this.makeRow(pin.id));
      const row = this.rows.get(pin.id);
      if (this.list.children[index] !== row.item) this.list.insertBefore(row.item, this.list.children[index] ?? null);
      this.fill(row, pin);
    });
    this.number();
  }

  makeRow(id) {
    const item = element("li", "pin-list-pin", this.list);
    item.dataset.id = id;
    const handle = element("button", "pin-list-handle", item, { type: "button", textContent: "⠿", title: "Drag, or press ↑ or ↓" });
    const text = element("div", "pin-list-text", item);
    const title = element("a", "pin-list-title", text);
    const detail = element("div", "pin-list-detail", text);
    const note = element("textarea", "pin-list-note", text, { rows: 1, placeholder: "Note" });
    const remove = element("button", "pin-list-button", item, { type: "button", textContent: "✕", title: "Remove" });
    handle.onpointerdown = (event) => this.take(event, item, handle);
    handle.onkeydown = (event) => this.step(event, item, handle);
    note.onchange = () => this.act({ do: "note", id, text: note.value });
    note.oninput = () => fitHeight(note);
    remove.onclick = () => this.act({ do: "remove", id });
    return { item, handle, title, detail, note, remove };
  }

  fill(row, pin) {
    const canChange = this.data.can_change;
    row.name = pin.title;
    row.title.textContent = pin.title;
    if (pin.link) row.title.href = pin.link;
    row.detail.textContent = [pin.kind, ...pin.detail.slice(0, DETAILS), ...(pin.detail.length > DETAILS ? ["…"] : [])].join(" · ");
    row.detail.title = pin.detail.join("\n");
    row.note.setAttribute("aria-label", `Note on ${pin.title}`);
    row.note.maxLength = this.data.note_max;
    row.note.readOnly = !canChange;
    row.remove.setAttribute("aria-label", `Remove ${pin.title}`);
    row.remove.hidden = row.handle.hidden = !canChange;
    if (document.activeElement !== row.note && this.root.getRootNode().activeElement !== row.note) row.note.value = pin.note;
    fitHeight(row.note);
  }

  number() {
    const items = [...this.list.children];
    items.forEach((item, index) => {
      const row = this.rows.get(item.dataset.id);
      row.handle.setAttribute("aria-label", `Move ${row.name}: ${index + 1} of ${items.length}, arrow keys up and down`);
    });
  }

  take(event, item, handle) {
    if (event.button) return;
    event.preventDefault();
    handle.focus();
    this.dragged = item;
    this.before = this.order();
    item.classList.add("pin-list-dragged");
    this.list.setPointerCapture(event.pointerId); // the list stays where it is, unlike what is dragged
  }

  drag(event) {
    if (!this.dragged) return;
    const below = [...this.list.children].find((item) => {
      const { top, height } = item.getBoundingClientRect();
      return item !== this.dragged && event.clientY < top + height / 2;
    });
    if (this.dragged.nextElementSibling !== (below ?? null)) this.list.insertBefore(this.dragged, below ?? null);
  }

  drop() {
    if (!this.dragged) return;
    this.dragged.classList.remove("pin-list-dragged");
    this.dragged = null;
    this.moved();
  }

  step(event, item, handle) {
    const { key } = event;
    if (key !== "ArrowUp" && key !== "ArrowDown") return;
    event.preventDefault();
    event.stopPropagation();
    this.before = this.order();
    if (key === "ArrowUp") item.previousElementSibling?.before(item);
    else item.nextElementSibling?.after(item);
    handle.focus();
    this.moved();
  }

  moved() {
    const order = this.order();
    if (order.join() === this.before.join()) return;
    this.number();
    const moved = document.activeElement?.closest?.(".pin-list-pin");
    if (moved) this.said.textContent = `${this.rows.get(moved.dataset.id)?.name}: now ${order.indexOf(moved.dataset.id) + 1} of ${order.length}`;
    this.act({ do: "order", order });
  }

  order() {
    return [...this.list.children].map((item) => item.dataset.id);
  }

  act(action) {
    this.reports.add({ actions: [...(this.reports.pending?.actions ?? []), action] });
  }
}

function fitHeight(note) {
  note.style.height = "auto";
  if (note.scrollHeight) note.style.height = `${note.scrollHeight + 2}px`;
}
