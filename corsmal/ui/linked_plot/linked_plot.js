// One Plotly figure with range inputs under it.

export default function mount(component) {
  return mountAs(LinkedPlot, component);
}

function loadPlotly(url) {
  window.corsmalPlotly ??= new Promise((resolve, reject) => {
    const script = document.createElement("script");
    script.src = url;
    script.onload = () => resolve(window.Plotly);
    script.onerror = () => {
      window.corsmalPlotly = undefined;
      reject(new Error(`${url} could not be loaded; start the app with "streamlit run app.py"`));
    };
    document.head.append(script);
  });
  return window.corsmalPlotly;
}

class LinkedPlot {
  constructor(parent) {
    this.root = element("div", "linked-plot", parent, { role: "group" });
    this.figure = element("div", "linked-plot-figure", this.root);
    this.download = element("button", "linked-plot-download", this.root, { type: "button", title: "Download figure" });
    this.download.innerHTML = '<svg viewBox="0 0 16 16"><path d="M8 2v8M4.5 7 8 10.5 11.5 7M2.5 13.5h11"/></svg>';
    this.download.setAttribute("aria-label", "Download figure");
    this.download.onclick = () => this.trigger("download", this.view());
    this.bar = element("div", "linked-plot-sliders", this.root);
    this.span = null; // the handles, once a figure has some
    this.sliders = new Map();
    this.reports = new Reports(this.root);
    this.cursor = new PlayheadCursor(this);
    this.camera = new FollowedCamera(this);
    this.drawn = ""; // the figure, its size and its colours, as last given to Plotly
    this.queue = Promise.resolve();
    const fit = () => this.ready && this.figure.clientWidth > 0 && window.Plotly.Plots.resize(this.figure);
    this.resizer = new ResizeObserver(fit);
    this.resizer.observe(this.figure);
  }

  remove() {
    this.resizer.disconnect();
    this.cursor.remove();
    this.camera.remove();
    this.reports.end();
    if (this.ready) window.Plotly.purge(this.figure);
    this.root.remove();
  }

  update(data) {
    this.data = data;
    const settled = this.reports.follow(data.acknowledged);
    this.root.setAttribute("aria-label", data.label);
    this.figure.style.height = `${data.height}px`;
    this.updateSliders(settled);
    // Drawn one after the other, and only the newest: answers that come faster than Plotly draws are skipped.
    this.queue = this.queue.then(async () => {
      if (data !== this.data) return;
      await this.draw(data, data.follows_camera && settled && this.camera.isToMove(data.camera));
      this.reports.acknowledge(data.acknowledged);
    });
  }

  async draw(data, movesCamera) {
    const theme = this.theme();
    const drawn = [data.figure, data.height, data.revision, JSON.stringify(theme)].join("\n");
    if (drawn === this.drawn && !movesCamera) return;
    try {
      const Plotly = await loadPlotly(data.plotly_url);
      const { data: traces, layout = {} } = JSON.parse(data.figure);
      const config = { displaylogo: false, showSendToCloud: false };
      Object.assign(layout, { template: theme, height: data.height, uirevision: data.revision, autosize: true });
      delete layout.width;
      const first = layout.scene?.camera;
      if (!this.ready) this.figure.replaceChildren();
      if (this.ready && this.revision === data.revision) this.keepCameras(layout);
      else if (data.camera) layout.scene.camera = plotlyCamera(data.camera);
      await Plotly.react(this.figure, traces, layout, config);
      if (!this.ready) this.listen();
      if (movesCamera) await this.camera.move(data.camera, first);
      Object.assign(this, { ready: true, drawn, revision: data.revision });
      this.placeOverlays();
    } catch (error) {
      Object.assign(this, { ready: false, drawn: "" });
      this.figure.replaceChildren();
      element("div", "linked-plot-problem", this.figure, { textContent: `This plot cannot be shown: ${error.message}` });
    }
  }

  // Plotly's own uirevision goes back to where the mouse button came up, although the view still turns a little then.
  keepCameras(layout) {
    const { _fullLayout: full } = this.figure;
    for (const id of full._subplots.gl3d) layout[id] = { ...layout[id], camera: full[id]._scene.getCamera() };
  }

  // How the figure is turned and zoomed and which traces it shows, for a download that looks the same.
  view() {
    const { _fullLayout: full, _fullData: traces = [] } = this.figure;
    const [cameras, ranges] = [{}, {}];
    for (const id of full?._subplots.gl3d ?? []) cameras[id] = full[id]._scene.getCamera();
    for (const name of Object.keys(full ?? {}).filter((key) => /^[xy]axis\d*$/.test(key)))
      if (!full[name].autorange) ranges[name] = full[name].range;
    return { cameras, ranges, visible: traces.map((trace) => trace.visible) };
  }

  theme() {
    const style = getComputedStyle(this.root);
    const color = (name) => style.getPropertyValue(`--st-${name}`).trim();
    const [text, paper, border] = [color("text-color"), color("background-color"), color("border-color")];
    const axis = { gridcolor: border, linecolor: border, zerolinecolor: border, tickcolor: border };
    const spatial = { ...axis, showbackground: false };
    const layout = {
      paper_bgcolor: paper,
      plot_bgcolor: paper,
      font: { color: text, family: color("font"), size: 13 },
      colorway: color("chart-categorical-colors").split(/,(?![^(]*\))/).map((name) => name.trim()),
      hoverlabel: { bgcolor: color("secondary-background-color"), bordercolor: border, font: { color: text } },
      modebar: { bgcolor: "rgba(0, 0, 0, 0)", color: color("gray-text-color"), activecolor: color("primary-color") },
      legend: { bgcolor: "rgba(0, 0, 0, 0)" },
      shapedefaults: { line: { color: text } },
      updatemenudefaults: { bgcolor: paper, bordercolor: border, font: { color: text, size: 12 } },
      margin: { l: 56, r: 16, t: 32, b: 48 },
      xaxis: { ...axis, automargin: true },
      yaxis: { ...axis, automargin: true },
      scene: { xaxis: spatial, yaxis: spatial, zaxis: spatial },
    };
    return { layout };
  }

  listen() {
    this.figure.on("plotly_click", ({ points: [point] }) => {
      if (!this.cursor.follow(point.x)) this.reports.add({ click: clickOf(point) });
    });
    this.figure.on("plotly_afterplot", () => this.placeOverlays());
    this.figure.on("plotly_relayout", (change) => {
      if (this.data.follows_camera && Object.keys(change).some((name) => name.startsWith("scene.camera"))) this.camera.report();
    });
  }

  placeOverlays() {
    this.span?.place();
    this.cursor.place();
  }

  updateSliders(settled) {
    const names = this.data.sliders.map((slider) => slider.name);
    if (names.join("\n") !== [...this.sliders.keys()].join("\n")) {
      this.bar.replaceChildren();
      this.sliders = new Map(names.map((name) => [name, this.makeSlider(name)]));
    }
    for (const slider of this.data.sliders) {
      const view = this.sliders.get(slider.name);
      view.label.textContent = slider.label;
      view.unit.textContent = slider.unit;
      view.number.setAttribute("aria-label", `${slider.label}, number`);
      const { min, max, step } = slider;
      for (const input of [view.range, view.number]) Object.assign(input, { min, max, step });
      if (settled && !view.held) this.show(view, slider.value, slider.unit);
    }
    if (this.data.span) this.span ??= new SpanHandles(this);
    this.span?.update(this.data.span, settled);
  }

  makeSlider(name) {
    const box = element("div", "linked-plot-slider", this.bar);
    const id = `linked-plot-${crypto.getRandomValues(new Uint32Array(1))[0]}`;
    const view = {
      label: element("label", "", box, { htmlFor: id }),
      number: element("input", "", box, { type: "number" }),
      unit: element("span", "linked-plot-unit", box),
      range: element("input", "", box, { type: "range", id }),
      held: false,
    };
    view.range.dataset.name = name;
    view.range.onpointerdown = () => (view.held = true);
    view.range.onpointerup = view.range.onpointercancel = () => (view.held = false);
    view.range.oninput = () => this.move(name, view.range.valueAsNumber, false);
    view.range.onchange = () => this.move(name, view.range.valueAsNumber, true);
    view.number.onchange = () => {
      view.range.value = view.number.value; // the range input keeps it between min and max, on a step
      this.move(name, view.range.valueAsNumber, true);
    };
    return view;
  }

  move(name, value, settled) {
    const slider = this.data.sliders.find((one) => one.name === name);
    this.show(this.sliders.get(name), value, slider.unit);
    this.reports.add({ values: { [name]: value }, settled });
  }

  show(view, value, unit) {
    view.range.value = value;
    view.number.value = value;
    view.range.setAttribute("aria-valuetext", `${value} ${unit}`.trim());
  }
}

function clickOf(point) {
  const plain = (value) => (ArrayBuffer.isView(value) ? Array.from(value) : (value ?? null));
  return { x: plain(point.x), y: plain(point.y), curve: point.curveNumber, customdata: plain(point.customdata) };
}
