// The key « / » leads to the search field, from anywhere but where one writes.

const WRITING = "input, textarea, select, [contenteditable]:not([contenteditable=false])";

export function setUpSearchKey() {
  document.addEventListener("keydown", (event) => {
    if (event.key !== "/" || event.ctrlKey || event.metaKey || event.altKey) return;
    const [target] = event.composedPath(); // in the editor's shadow tree too
    if (event.defaultPrevented || target.closest?.(WRITING)) return;
    const field = document.querySelector("[data-search]");
    if (!field) return;
    event.preventDefault();
    field.focus();
    field.select();
  });
}
