// Marks typed one below the other: Enter and the arrows go down and up, several lines that are pasted fill the cells below.

export function setUpColumnMarks() {
  const table = document.querySelector("[data-column-marks]");
  if (!table) return;
  const cells = [...table.querySelectorAll("input[name^='n-']")];

  const go = (from, by) => {
    const next = cells[cells.indexOf(from) + by];
    next?.focus();
    next?.select();
    return Boolean(next);
  };

  table.addEventListener("keydown", (event) => {
    const by = { Enter: event.shiftKey ? -1 : 1, ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!by || !cells.includes(event.target) || event.isComposing) return;
    // At the last cell too: Enter alone never sends what is half typed.
    event.preventDefault();
    go(event.target, by);
  });

  table.addEventListener("paste", (event) => {
    if (!cells.includes(event.target)) return;
    const lines = event.clipboardData.getData("text").replace(/\r?\n$/, "").split(/\r?\n/);
    if (lines.length < 2) return;
    event.preventDefault();
    const below = cells.slice(cells.indexOf(event.target));
    below.slice(0, lines.length).forEach((cell, at) => {
      cell.value = lines[at].trim();
    });
    const filled = Math.min(lines.length, below.length);
    const left = lines.length - filled;
    document.getElementById("annonce").textContent =
      `${filled} cases remplies${left ? `, ${left} lignes de trop laissées de côté` : ""}.`;
    below[filled - 1].focus();
  });
}
