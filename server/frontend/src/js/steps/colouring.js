// Python in the colours that the editor gives it.

import { classHighlighter, highlightCode } from "@lezer/highlight";
import { parser } from "@lezer/python";

/** Of each line, its pieces as [text, class]. */
export function coloured(text) {
  const lines = [[]];
  const put = (piece, look) => lines.at(-1).push([piece, look]);
  highlightCode(text, parser.parse(text), classHighlighter, put, () => lines.push([]));
  return lines;
}
