// Figures are pictures until one is clicked. Plotly is unpacked when it is first needed.
"use strict";

let library;
const loadPlotly = () => (library ??= unpack(document.getElementById("plotly").textContent));

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const code = await new Response(new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"))).blob();
  await new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = URL.createObjectURL(new Blob([code], { type: "text/javascript" }));
    script.onload = resolve;
    script.onerror = () => reject(new Error("Plotly could not be unpacked"));
    document.head.append(script);
  });
  return window.Plotly;
}

class Plot {
  constructor(figure) {
    this.picture = figure.querySelector(".picture");
    this.live = figure.querySelector(".live");
    this.button = figure.querySelector("button");
    this.json = figure.querySelector("script").textContent;
    this.isSpatial = "spatial" in figure.dataset;
    this.label = this.button.textContent;
    this.button.hidden = false;
    this.button.onclick = () => (this.live.hidden ? this.show() : this.hide());
  }

  parts() {
    return JSON.parse(this.json);
  }

  async show() {
    for (const other of plots) if (!other.live.hidden) other.hide(); // a browser has few 3D canvases
    this.button.textContent = "Opening …";
    const Plotly = await loadPlotly();
    const { data, layout } = this.parts();
    delete layout.width;
    this.picture.style.display = "none";
    this.live.hidden = false;
    await Plotly.newPlot(this.live, data, layout, { displaylogo: false, responsive: true, showSendToCloud: false });
    this.button.textContent = "Back to the picture";
  }

  hide() {
    window.Plotly?.purge(this.live);
    this.live.hidden = true;
    this.picture.style.display = "";
    this.button.textContent = this.label;
  }

  // Where the file holds no picture, it is drawn here.
  async draw() {
    const Plotly = await loadPlotly();
    const { data, layout } = this.parts();
    delete layout.updatemenus;
    const { width, height } = layout;
    const size = { width, height, format: this.isSpatial ? "png" : "svg", scale: 1 };
    const image = document.createElement("img");
    const shown = data.filter((trace) => trace.visible !== "legendonly");
    image.src = await Plotly.toImage({ data: shown, layout, config: { plotGlPixelRatio: 1 } }, size);
    image.alt = "";
    await image.decode();
    this.picture.replaceChildren(image);
  }
}

const plots = [...document.querySelectorAll("figure.plot")].map((figure) => new Plot(figure));

(async () => {
  const missing = plots.filter((plot) => !plot.picture.firstElementChild);
  for (const plot of missing.filter((each) => !each.isSpatial)) await plot.draw(); // these are quick
  for (const plot of missing.filter((each) => each.isSpatial)) await plot.draw();
  document.documentElement.dataset.drawn = "all";
})();
