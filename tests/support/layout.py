"""Finds words on a page that stand on each other, or that are cut."""

from __future__ import annotations

from typing import Any

#: Of texts and buttons, the boxes that are seen: cut by what scrolls around them.
_FAULTS = """() => {
  const faults = [], boxes = []
  const isShown = (e) => e.checkVisibility({ visibilityProperty: true })
  const hidden = (e) => e.closest(".visually-hidden, dialog:not([open])") || !isShown(e)
  const seen = (rect, element) => {
    let [left, top, right, bottom] = [rect.left, rect.top, rect.right, rect.bottom]
    for (let e = element; e && e !== document.documentElement; e = e.parentElement) {
      const style = getComputedStyle(e)
      if (style.position === "fixed" || (style.overflowX === "visible" && style.overflowY === "visible")) continue
      const around = e.getBoundingClientRect()
      left = Math.max(left, around.left), right = Math.min(right, around.right)
      top = Math.max(top, around.top), bottom = Math.min(bottom, around.bottom)
    }
    return right - left > 1 && bottom - top > 1 ? { left, top, right, bottom } : null
  }
  const add = (rect, element, text) => {
    const box = seen(rect, element)
    if (box) boxes.push({ ...box, element, text })
  }
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT)
  while (texts.nextNode()) {
    const node = texts.currentNode, parent = node.parentElement
    if (!node.data.trim() || parent.closest("script, style, svg, .katex") || hidden(parent)) continue
    const range = document.createRange()
    range.selectNodeContents(node)
    for (const rect of range.getClientRects()) add(rect, parent, node.data.trim().slice(0, 50))
  }
  for (const e of document.querySelectorAll(".button, input:not([type=hidden]), textarea, select")) {
    if (!hidden(e)) add(e.getBoundingClientRect(), e, `[${e.textContent.trim().slice(0, 50)}]`)
  }
  boxes.sort((a, b) => a.top - b.top)
  boxes.forEach((a, index) => {
    for (const b of boxes.slice(index + 1)) {
      if (b.top > a.bottom) break
      if (a.element.contains(b.element) || b.element.contains(a.element)) continue
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left)
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top)
      if (wide > 2 && high > 4) faults.push(["on each other", a.text, b.text])
    }
  })
  for (const e of [document.documentElement, ...document.body.querySelectorAll("*")]) {
    if (e.clientWidth <= 1 || hidden(e) || e.closest(".katex, svg")) continue
    const style = getComputedStyle(e), root = e === document.documentElement
    const sideways = e.scrollWidth > e.clientWidth + 1 && (root || style.overflowX !== "visible")
    const below = e.scrollHeight > e.clientHeight + 1 && ["hidden", "clip"].includes(style.overflowY)
    if (!sideways && !(below && !root && e !== document.body)) continue
    faults.push(["cut", `${e.tagName}.${e.className}`, e.textContent.trim().slice(0, 50)])
  }
  return faults
}"""


def find_layout_faults(page: Any) -> list[list[str]]:
    """Return the texts and buttons on each other, and the blocks whose words are cut at the side or below."""
    found: list[list[str]] = page.evaluate(_FAULTS)
    return found
