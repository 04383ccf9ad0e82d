// What our components share. The server owns every value: the browser reports what the user did, at most one report
// at a time, and shows what the server answers.

const REPORT_TIMEOUT_MS = 2000; // an answer may get lost (a run that failed): then the next report goes out anyway
const OWN_KEYS =
  "input, textarea, select, audio, video, [contenteditable]:not([contenteditable='false']), [role='slider'], [role='tab'], " +
  "[role='radio'], [role='grid'], [role='listbox'], [role='combobox'], [role='menu'], [role='spinbutton'], [role='textbox']";

const mounted = new WeakMap();

function mountAs(Kind, { data, parentElement, setStateValue, setTriggerValue }) {
  if (!mounted.has(parentElement)) mounted.set(parentElement, new Kind(parentElement));
  const view = mounted.get(parentElement);
  view.reports.send = (report) => setStateValue("report", report);
  view.trigger = setTriggerValue;
  view.update(data);
  // Streamlit also calls this for renders that a newer one overtook; only leaving the page counts.
  return () => setTimeout(() => parentElement.isConnected || view.remove());
}

function element(tag, className, parent, attributes = {}) {
  const node = Object.assign(document.createElement(tag), attributes);
  node.className = className;
  parent.append(node);
  return node;
}

class Reports {
  constructor(root) {
    this.root = root;
    this.sequence = 0; // of the last report sent
    this.waiting = false; // for its answer
    this.pending = null; // what happened since
  }

  add({ values, ...change }) {
    this.pending = { ...this.pending, ...change };
    if (values) this.pending.values = { ...this.pending.values, ...values };
    this.flush();
  }

  flush() {
    if (this.waiting || !this.pending) return;
    const report = { sequence: ++this.sequence, ...this.pending };
    this.pending = null;
    this.waiting = true;
    this.timer = setTimeout(() => this.acknowledge(this.sequence), REPORT_TIMEOUT_MS);
    this.send(report);
  }

  acknowledge(sequence) {
    this.root.dataset.acknowledged = sequence;
    if (sequence < this.sequence) return;
    clearTimeout(this.timer);
    this.waiting = false;
    this.flush();
  }

  // Whether the server's values are the answer to everything that was reported.
  follow(acknowledged) {
    this.sequence = Math.max(this.sequence, acknowledged);
    return acknowledged >= this.sequence && !this.pending?.values && !this.pending?.camera && !this.pending?.actions;
  }

  end() {
    clearTimeout(this.timer);
  }
}
