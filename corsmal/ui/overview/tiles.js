// The numbers side by side: one element of the page, which a browser draws in a fraction of the time that as many
// elements of Streamlit take. The label of each leads to the page that explains it.

const LOOKS = 3; // at the main thread, in a row, until it counts as resting
const LOOK_MS = 100;
const LATE_MS = 30;

export default function mount(component) {
  return mountAs(Tiles, component);
}

class Tiles {
  constructor(parent) {
    this.root = element("div", "tiles", parent);
    this.tiles = new Map();
    this.reports = new Reports(this.root);
  }

  remove() {
    this.reports.end();
    this.root.remove();
  }

  update({ tiles, acknowledged, drawn_url: drawnUrl }) {
    this.reports.follow(acknowledged);
    for (const tile of tiles) this.fill(this.tiles.get(tile.label) ?? this.make(tile.label), tile);
    this.reports.acknowledge(acknowledged);
    if (drawnUrl && drawnUrl !== this.drawnUrl) this.tell((this.drawnUrl = drawnUrl));
  }

  // The server waits for a moment until the numbers stand, and until the browser rests.
  tell(url) {
    const tell = (part) => fetch(`${url}/${part}`, { method: "POST" }).catch(() => {});
    requestAnimationFrame(() => setTimeout(() => tell("numbers").then(() => whenAtRest(() => tell("rest")))));
  }

  make(label) {
    const root = element("div", "tile", this.root, { role: "group" });
    root.setAttribute("aria-label", label);
    const link = element("button", "tile-link", root, { type: "button", onclick: () => this.reports.add({ opens: label }) });
    const icon = element("span", "tile-icon", link, { translate: false });
    icon.setAttribute("aria-hidden", "true");
    element("span", "", link, { textContent: label });
    const part = (name) => element("div", `tile-${name}`, root);
    const made = { link, icon, value: part("value"), interval: part("interval"), verdict: part("verdict") };
    this.tiles.set(label, made);
    return made;
  }

  fill({ link, icon, ...texts }, tile) {
    Object.assign(link, { disabled: !tile.icon, title: tile.help });
    Object.assign(icon, { hidden: !tile.icon, textContent: tile.icon });
    for (const [name, node] of Object.entries(texts)) node.textContent = tile[name];
    texts.interval.hidden = !tile.interval;
  }
}

function whenAtRest(done, looks = 0) {
  const began = performance.now();
  setTimeout(() => {
    if (performance.now() - began > LOOK_MS + LATE_MS) whenAtRest(done);
    else if (looks + 1 < LOOKS) whenAtRest(done, looks + 1);
    else done();
  }, LOOK_MS);
}
