// "[" and "]" step to the previous and the next recording on every page, except in an input.
if (!window.corsmalPickerKeys) {
  window.corsmalPickerKeys = true;
  const buttons = { "[": "Previous", "]": "Next" };
  const inputs = "input, textarea, select, [contenteditable]:not([contenteditable='false']), [role='textbox']";
  document.addEventListener("keydown", (event) => {
    const name = buttons[event.key];
    if (!name || (event.ctrlKey && !event.altKey) || event.metaKey || event.target.closest?.(inputs)) return;
    event.preventDefault();
    document.querySelector(`.st-key-picker_${name} button`)?.click();
  });
}
