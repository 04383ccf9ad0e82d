// Copies the page's address. The address bar always says all that is chosen, so nothing is asked of the server.

const COPIED_MS = 2500;

export default function mount({ data, parentElement }) {
  let view = parentElement.corsmalCopyLink;
  if (!view) {
    const button = Object.assign(document.createElement("button"), { type: "button", className: "copy-link" });
    const shown = Object.assign(document.createElement("input"), { className: "copy-link-shown", readOnly: true, hidden: true });
    shown.setAttribute("aria-label", "The link, to be copied by hand");
    button.setAttribute("aria-live", "polite");
    parentElement.append(button, shown);
    view = parentElement.corsmalCopyLink = { button, shown };
    button.onclick = () => copyLink(view);
  }
  view.data = data;
  if (!view.timer) view.button.textContent = data.label;
}

function linkOf({ has_pins }) {
  const link = new URL(window.location.href);
  if (!has_pins) link.searchParams.delete("pins");
  link.hash = "";
  return link.href;
}

async function copyLink(view) {
  const link = linkOf(view.data);
  const isCopied = (await copyByClipboard(link)) || copyBySelection(link);
  Object.assign(view.shown, { value: link, hidden: isCopied });
  if (!isCopied) view.shown.select();
  view.button.textContent = isCopied ? "Link copied" : "Copy it from below";
  clearTimeout(view.timer);
  view.timer = setTimeout(() => {
    view.timer = null;
    view.button.textContent = view.data.label;
  }, COPIED_MS);
}

async function copyByClipboard(link) {
  try {
    await navigator.clipboard.writeText(link);
    return true;
  } catch {
    return false; // there is no clipboard without a secure connection
  }
}

function copyBySelection(link) {
  const field = Object.assign(document.createElement("textarea"), { value: link });
  document.body.append(field);
  field.select();
  try {
    return document.execCommand("copy");
  } finally {
    field.remove();
  }
}
