// The pictures of the views. They are fetched ahead and decoded before they are shown; those not needed are given up.

const AHEAD = { ahead: 8, behind: 2 };
const FEW = { ahead: 3, behind: 0 }; // while few are shown per second
const KEPT_FRAMES = 60;

class Pictures {
  constructor(root) {
    this.root = root;
    this.kept = new Map(); // pictures by address, the ones used last at the end
    this.slots = new Map(); // by view
  }

  update(data) {
    this.data = data;
    const names = data.views.map((view) => view.name).join();
    if (names !== this.names) {
      this.names = names;
      this.root.replaceChildren();
      this.slots = new Map(data.views.map((view) => [view.name, this.makeSlot(view)]));
    }
    this.forget((url) => !url.startsWith(data.url) || !url.endsWith(data.version));
  }

  makeSlot(view) {
    const root = element("figure", "time-line-view", this.root);
    const place = element("div", "time-line-picture", root);
    const caption = element("figcaption", "", root);
    caption.title = view.title;
    return { place, caption };
  }

  url(view, frame) {
    return `${this.data.url}${view.name}/${frame}.jpg?${this.data.version}`;
  }

  // The picture of a view, asked for if need be; null where the view has no such frame.
  get(view, frame) {
    if (frame < 0 || frame >= view.frames) return null;
    const url = this.url(view, frame);
    const picture = this.kept.get(url) ?? this.fetch(url);
    this.kept.delete(url);
    this.kept.set(url, picture);
    return picture;
  }

  fetch(url) {
    const image = new Image();
    image.decoding = "sync"; // shown in one redraw with the others, even if the browser has to decode it again
    image.draggable = false;
    image.src = url;
    const picture = { image, isReady: false, isBroken: false };
    picture.ready = image.decode().then(
      () => (picture.isReady = true),
      () => (picture.isBroken = true),
    );
    return picture;
  }

  of(frame) {
    return this.data.views.map((view) => this.get(view, frame)).filter(Boolean);
  }

  ready(frame) {
    return Promise.all(this.of(frame).map((picture) => picture.ready));
  }

  // The newest of every so many frames up to the wanted one whose pictures are there; the wanted one where none is.
  newestReady(shown, wanted, every) {
    for (let frame = wanted; frame > (shown ?? wanted); frame -= every) {
      const isThere = (view) => frame >= view.frames || this.kept.get(this.url(view, frame))?.isReady;
      if (this.data.views.every(isThere)) return frame;
    }
    return wanted;
  }

  // Show a frame in all views; returns whether every picture was there.
  show(frame) {
    let isWhole = true;
    for (const view of this.data.views) {
      const { place, caption } = this.slots.get(view.name);
      const picture = this.get(view, frame);
      if (picture?.isReady) {
        picture.image.alt = `${view.name}, frame ${frame}`;
        if (place.firstChild !== picture.image) place.replaceChildren(picture.image);
      } else {
        place.replaceChildren();
        const absent = view.frames ? `${view.name} ends at frame ${view.frames - 1}` : `${view.name} cannot be read`;
        const textContent = picture ? `Frame ${frame} of ${view.name} cannot be shown` : absent;
        element("p", "", place, { textContent });
        if (picture) {
          isWhole = false;
          this.kept.delete(this.url(view, frame)); // to be asked for again
        }
      }
      place.dataset.frame = frame;
      const star = frame === this.data.best && view.is_of_pair ? ` ★ ${this.data.best_name.toLowerCase()}` : "";
      caption.textContent = `${view.name}, frame ${frame}${star}`;
    }
    return isWhole;
  }

  fetchAhead(frame, step, { ahead, behind }) {
    const wanted = [];
    for (let count = 1; count <= ahead; count += 1) wanted.push(frame + count * step);
    for (let count = 1; count <= behind; count += 1) wanted.push(frame - count * step);
    const urls = new Set([frame, ...wanted].flatMap((one) => this.data.views.map((view) => this.url(view, one))));
    this.forget((url, picture) => !urls.has(url) && !picture.isReady);
    for (const one of wanted) this.of(one);
    const most = KEPT_FRAMES * this.data.views.length;
    this.forget(() => this.kept.size > most);
  }

  // Give up pictures, the ones used longest ago first; those still on their way are not fetched any more.
  forget(isToGo) {
    for (const [url, picture] of this.kept) {
      if (!isToGo(url, picture)) continue;
      this.kept.delete(url);
      if (!picture.isReady) picture.image.src = "";
    }
  }
}
