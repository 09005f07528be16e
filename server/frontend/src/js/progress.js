// What is done in the background, told as it goes on; the page is loaded again at its end.

const POLL_MS = 3000;

export function followProgress() {
  const place = document.querySelector("[data-progress]");
  if (!place) return;
  if (!window.EventSource) {
    setTimeout(() => location.reload(), POLL_MS);
    return;
  }
  const bar = place.querySelector("progress");
  const words = place.querySelector("[data-words]");
  const source = new EventSource(place.dataset.progress);
  source.addEventListener("progress", (event) => {
    const { done, graded, total, text } = JSON.parse(event.data);
    bar.max = Math.max(1, total);
    bar.value = graded;
    words.textContent = text;
    if (!done) return;
    source.close();
    location.reload();
  });
  source.onerror = () => {
    if (source.readyState === EventSource.CLOSED) setTimeout(() => location.reload(), POLL_MS);
  };
}
